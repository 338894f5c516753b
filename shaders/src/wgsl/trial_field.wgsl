// Distance field of a trial: bricks of its asset, shared with other trials, and own bricks, which it may write.
// Twin of sdf-bake's grid.rs and of lattice_line.rs.


// Position of a brick in the index; OUTSIDE if the index does not contain it.
fn index_entry(brick: vec3i) -> u32 {
    let at = brick - setup.grid_origin.xyz;
    let dims = setup.grid_dims;
    if any(at < vec3i(0)) || any(at >= vec3i(dims.xyz)) {
        return OUTSIDE;
    }
    return dims.w + (u32(at.x) * dims.y + u32(at.y)) * dims.z + u32(at.z);
}

// Slot of a brick, OUTSIDE or INSIDE.
fn slot_of(brick: vec3i) -> u32 {
    let entry = index_entry(brick);
    if entry == OUTSIDE {
        return OUTSIDE;
    }
    return brick_index[entry];
}

// True if a slot holds one of the trial's own bricks.
fn is_own(slot: u32) -> bool {
    return slot < INSIDE && slot >= setup.shared_bricks;
}

// Position in the pool of the first value of a slot's plane.
fn brick_values(slot: u32, plane: u32) -> u32 {
    let first = select(setup.first_brick, setup.spare_first - setup.shared_bricks, is_own(slot));
    return ((first + slot) * run.planes + plane) * BRICK_VOXELS;
}

fn voxel_offset(voxel: vec3i) -> u32 {
    let local = vec3u(voxel & vec3i(i32(BRICK_SIDE) - 1));
    return (local.x << (2 * BRICK_SHIFT)) | (local.y << BRICK_SHIFT) | local.z;
}

// Position in the pool of a voxel's value; OUTSIDE if the voxel has no brick.
fn place_of(voxel: vec3i, plane: u32) -> u32 {
    let slot = slot_of(voxel >> vec3u(BRICK_SHIFT));
    if slot >= INSIDE {
        return OUTSIDE;
    }
    return brick_values(slot, plane) + voxel_offset(voxel);
}

// Phi at a voxel [m].
fn phi_length(voxel: vec3i) -> f32 {
    let slot = slot_of(voxel >> vec3u(BRICK_SHIFT));
    if slot >= INSIDE {
        return select(setup.band_length, -setup.band_length, slot == INSIDE);
    }
    return pool[brick_values(slot, 0u) + voxel_offset(voxel)];
}

// The same [voxels].
fn phi_at(voxel: vec3i) -> f32 {
    return phi_length(voxel) / setup.voxel;
}

fn stride(phi: f32) -> i32 {
    return max(i32(abs(phi)), 1);
}

// Voxel at which a lattice line leaves the material, the first found from voxel `high`: upwards if it starts inside,
// otherwise downwards to voxel `least`. Returns (voxel below the surface, 1), or (0, 0) if there is none.
fn surface(i: i32, j: i32, high: i32, least: i32) -> vec2i {
    var k = high;
    var phi = phi_at(voxel_at(i, j, k));
    while phi < 0.0 {
        k += stride(phi);
        if k > high + CLIMB {
            return vec2i(0);
        }
        phi = phi_at(voxel_at(i, j, k));
    }
    while k >= least {
        var below = k - stride(phi);
        let next = phi_at(voxel_at(i, j, below));
        if next < 0.0 {
            while below + 1 < k && phi_at(voxel_at(i, j, below + 1)) < 0.0 {
                below += 1;
            }
            return vec2i(below, 1);
        }
        k = below;
        phi = next;
    }
    return vec2i(0);
}

// Distance from the voxel below the surface to the zero of phi; twin of crossing.rs.
fn way_to_zero(before: f32, a: f32, b: f32, after: f32) -> f32 {
    let chord = a / (a - b);
    let limit = WITHIN_BAND * setup.band;
    if max(max(abs(before), abs(a)), max(abs(b), abs(after))) >= limit {
        return chord;
    }
    let second = 0.5 * (before - 2.0 * a + b);
    let third = (0.5 * (a - 2.0 * b + after) - second) / 3.0;
    var t = chord;
    for (var n = 0; n < 3; n++) {
        let bend = second + third * (t + 1.0);
        let left = a + (b - a) * t + bend * t * (t - 1.0);
        let steepness = (b - a) + bend * (2.0 * t - 1.0) + third * t * (t - 1.0);
        t = clamp(t - left / steepness, 0.0, 1.0);
    }
    return select(t, chord, is_bad(t));
}
