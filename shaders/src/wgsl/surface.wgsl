// Channels of a grid at points of its surface; twin of surface.rs, field.rs and parts of shade.rs. Points are in voxels
// from the lowest voxel of the index. The including kernel declares the channels and `stage`.


// Phi at a point [m].
fn phi_near(point: vec3f) -> f32 {
    let corner = floor(point);
    return trilinear(cell_phi(vec3i(corner) + lowest()), point - corner);
}

// Outward unit normal from differences over two voxels; `otherwise` where phi is constant.
fn normal_at(point: vec3f, otherwise: vec3f) -> vec3f {
    let x = vec3f(1.0, 0.0, 0.0);
    let along = vec3f(
        phi_near(point + x) - phi_near(point - x),
        phi_near(point + x.yxy) - phi_near(point - x.yxy),
        phi_near(point + x.yyx) - phi_near(point - x.yyx),
    );
    let size = length(along);
    if size > 0.0 {
        return along / size;
    }
    return otherwise;
}

// Position of a voxel in the pool; OUTSIDE if it has no brick.
fn place_of(voxel: vec3i) -> u32 {
    let brick = slot(voxel >> vec3u(BRICK_SHIFT));
    return select(OUTSIDE, brick * BRICK_VOXELS + voxel_offset(voxel), brick < grid.bricks);
}

// Coating dose D and removed depth [m] at a point, interpolated trilinearly; 0 outside the bricks.
fn scalars_at(point: vec3f) -> vec2f {
    let corner = floor(point);
    var doses: array<f32, 8>;
    var depths: array<f32, 8>;
    for (var i = 0; i < 8; i++) {
        let place = place_of(vec3i(corner) + lowest() + vec3i(i >> 2, (i >> 1) & 1, i & 1));
        if place != OUTSIDE && stage.has_dose != 0u {
            doses[i] = grid_dose[place];
        }
        if place != OUTSIDE && stage.has_removed != 0u {
            depths[i] = grid_removed[place];
        }
    }
    let at = point - corner;
    return vec2f(trilinear(doses, at), trilinear(depths, at));
}

// Weld id of a voxel; 0 for base metal.
fn label_at(voxel: vec3i) -> u32 {
    let place = place_of(voxel);
    if place == OUTSIDE {
        return 0u;
    }
    return (grid_label[place >> 1u] >> (16u * (place & 1u))) & 0xffffu;
}

// Weld id of greatest weight among the metal voxels around a point, and the share of all welds.
fn weld_at(point: vec3f) -> vec2f {
    if stage.has_label == 0u {
        return vec2f(0.0);
    }
    let corner = floor(point);
    let f = point - corner;
    var phi = cell_phi(vec3i(corner) + lowest());
    var labels: array<u32, 8>;
    var weights: array<f32, 8>;
    var total = 0.0;
    var welds = 0.0;
    for (var i = 0; i < 8; i++) {
        let c = vec3i(i >> 2, (i >> 1) & 1, i & 1);
        let near = select(1.0 - f, f, c == vec3i(1));
        labels[i] = label_at(vec3i(corner) + lowest() + c);
        weights[i] = select(0.0, near.x * near.y * near.z, phi[i] <= 0.0);
        total += weights[i];
        welds += select(0.0, weights[i], labels[i] != 0u);
    }
    if total <= 0.0 {
        let nearest = label_at(vec3i(floor(point + 0.5)) + lowest());
        return vec2f(f32(nearest), f32(min(nearest, 1u)));
    }
    if welds < 0.5 * total {
        return vec2f(0.0, welds / total);
    }
    var most = 0u;
    var most_weight = 0.0;
    for (var i = 0; i < 8; i++) {
        var weight = 0.0;
        for (var j = 0; j < 8; j++) {
            weight += select(0.0, weights[j], labels[j] == labels[i]);
        }
        if labels[i] != 0u && weight > most_weight {
            most = labels[i];
            most_weight = weight;
        }
    }
    return vec2f(f32(most), welds / total);
}

// Share of open space just above a point (Evans 2006).
fn ambient_occlusion(point: vec3f, normal: vec3f) -> f32 {
    let parts = vec3f(0.3, 0.6, 0.95);
    var missing = 0.0;
    for (var i = 0; i < 3; i++) {
        let reach = parts[i] * grid.band;
        missing += 1.0 - clamp(phi_near(point + normal * (reach / grid.voxel)) / reach, 0.0, 1.0);
    }
    return max(1.0 - 1.5 * (missing / 3.0), 0.15);
}

// Share of the light from a unit direction that reaches a surface.
fn light_share(point: vec3f, normal: vec3f, towards: vec3f, spread: f32) -> f32 {
    if dot(normal, towards) <= 0.0 {
        return 0.0;
    }
    return light_share_along(point + normal * SHADOW_START, towards, spread);
}
