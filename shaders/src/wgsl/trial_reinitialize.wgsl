// Reinitialises distances that carry no zero set, from one voxel nearer to the surface; twin of write_back/reinitialize.rs.

// Voxel of a column in a layer on one side of the surface; layer 1 is next to the surface.
fn layer_voxel(line: u32, layer: i32, side: i32) -> i32 {
    let below = voxel_below(line, column_value(SUNK, line));
    return select(below + 1 - layer, below + layer, side > 0);
}

// New signed distance of a column's voxel in a layer from the surface [m]; NONE if it is left unchanged.
fn renewed(line: u32, layer: i32, side: i32) -> f32 {
    let at = line_place(line);
    let k = layer_voxel(line, layer, side);
    let place = place_of(voxel_at(at.x, at.y, k), 0u);
    if place == OUTSIDE {
        return NONE;
    }
    let old = pool[place];
    if abs(old) <= setup.kept_length || old * f32(side) < 0.0 {
        return NONE;
    }
    let nearer = phi_around(line, slope_of(line) * f32(side), k - side);
    if nearer == NONE {
        return NONE;
    }
    let distance = max(nearer * f32(side), 0.0) + area_ratio(line) * setup.voxel;
    return clamp(distance, setup.kept_length, setup.band_length) * f32(side);
}

// Phi [m] at height `k`, `shift` columns away from a column; NONE beyond the window or the band.
fn phi_around(line: u32, shift: vec2f, k: i32) -> f32 {
    let own = vec2f(f32(line / across()), f32(line % across()));
    let at = own + shift;
    let last = vec2f(vec2u(state.window_size[0], across()) - 1u);
    if any(at < vec2f(0.0)) || any(at > last) {
        return NONE;
    }
    let corner = min(floor(at), last - 1.0);
    let f = at - corner;
    let place = state.window_low.xy + vec2i(corner);
    var sum = 0.0;
    for (var n = 0; n < 4; n++) {
        let step = vec2i(n >> 1u, n & 1);
        let weight = select(1.0 - f.x, f.x, step.x == 1) * select(1.0 - f.y, f.y, step.y == 1);
        if weight > 0.0 {
            let phi = phi_length(voxel_at(place.x + step.x, place.y + step.y, k));
            if abs(phi) >= setup.band_length {
                return NONE;
            }
            sum += weight * phi;
        }
    }
    return sum;
}

// Writes a reinitialised distance; a voxel that was inside, beyond the band, takes the label of the voxel above it.
fn write_renewed(line: u32, layer: i32, side: i32, distance: f32) {
    if distance == NONE {
        return;
    }
    let at = line_place(line);
    let k = layer_voxel(line, layer, side);
    let place = place_of(voxel_at(at.x, at.y, k), 0u);
    if run.label_plane != ABSENT && pool[place] == -setup.band_length {
        let above = place_of(voxel_at(at.x, at.y, k + 1), run.label_plane);
        let own = place_of(voxel_at(at.x, at.y, k), run.label_plane);
        if above != OUTSIDE {
            pool[own] = pool[above];
        } else {
            pool[own] = 0.0;
        }
    }
    pool[place] = distance;
}
