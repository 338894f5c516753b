// Grinding marks along an abrasive's path; twin of marks.rs, with the same names and order of operations. The including
// kernel declares `stage` and `rows`, in which the path follows the lamps.


struct Groove {
    along: vec3f,
    tilt: f32,
    share: f32,
}

// Unit vector perpendicular to a unit vector (Duff et al. 2017).
fn any_tangent(normal: vec3f) -> vec3f {
    let sign = select(-1.0, 1.0, normal.z >= 0.0);
    let a = -1.0 / (sign + normal.z);
    return vec3f(1.0 + sign * normal.x * normal.x * a, sign * normal.x * normal.y * a, -sign * normal.x);
}

// Pseudorandom number from 0 to 1 for a lattice point: the first component of PCG2D (Jarzynski & Olano 2020).
fn lattice_value(u: i32, v: i32) -> f32 {
    var x = bitcast<u32>(u) * 1664525u + 1013904223u;
    var y = bitcast<u32>(v) * 1664525u + 1013904223u;
    x += y * 1664525u;
    y += x * 1664525u;
    x ^= x >> 16u;
    y ^= y >> 16u;
    x += y * 1664525u;
    return f32((x ^ (x >> 16u)) >> 8u) / 16777216.0;
}

fn noise_row(u: i32, v: i32) -> f32 {
    return lattice_value(u + 1, v) - lattice_value(u, v);
}

// Derivative along u of value noise on the integer lattice (u, v).
fn noise_slope(u: f32, v: f32) -> f32 {
    let low_u = floor(u);
    let low_v = floor(v);
    let fu = u - low_u;
    let fv = v - low_v;
    let smoothed = fv * fv * (3.0 - 2.0 * fv);
    let here = noise_row(i32(low_u), i32(low_v));
    let next = noise_row(i32(low_u), i32(low_v) + 1);
    return (here + (next - here) * smoothed) * (6.0 * fu * (1.0 - fu));
}

// Direction of the marks at a point [m] of a surface, and tilt of the normal across them.
fn marks_at(point: vec3f, normal: vec3f, footprint: f32) -> Groove {
    var along = vec3f(0.0);
    var centre = vec3f(0.0);
    var arc = 0.0;
    var weights = 0.0;
    for (var i = 0u; i < stage.marks; i++) {
        let place = rows[2u * (stage.lamps + i)];
        let motion = rows[2u * (stage.lamps + i) + 1u].xyz;
        let away = point - place.xyz;
        let near = 1.0 / (dot(away, away) + 1e-8);
        let weight = near * near;
        along += motion * weight;
        centre += place.xyz * weight;
        arc += (place.w + dot(motion, away)) * weight;
        weights += weight;
    }
    along -= normal * dot(normal, along);
    let size = length(along);
    if !(size > 1e-6 * weights) {
        return Groove(any_tangent(normal), 0.0, 0.0);
    }
    along = along / size;
    let across = dot(cross(normal, along), point - centre / weights) / stage.mark_width;
    let down = arc / weights / (stage.mark_width * ELONGATION);
    let fade = 1.0 - clamp((footprint / stage.mark_width - 0.4) / 0.8, 0.0, 1.0);
    let slope = noise_slope(across, down) + 0.6 * noise_slope(2.7 * across + 11.3, 1.3 * down);
    return Groove(along, stage.mark_slope * fade * slope, 1.0);
}
