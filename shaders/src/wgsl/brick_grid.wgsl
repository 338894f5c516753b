// Look-up and interpolation in a brick grid; twin of brick_grid.rs, with the same names and order of operations.
// No bindings: the including kernel declares `grid`, `grid_index` and `grid_phi`.

// Position of a brick in the index; valid only if `within_index` is true.
fn entry(brick: vec3i) -> u32 {
    let at = vec3u(brick - grid.origin.xyz);
    return (at.x * grid.dims.y + at.y) * grid.dims.z + at.z;
}

// True if the index contains a brick.
fn within_index(brick: vec3i) -> bool {
    let at = brick - grid.origin.xyz;
    return all(at >= vec3i(0)) && all(at < vec3i(grid.dims.xyz));
}

// Slot of a brick, OUTSIDE or INSIDE.
fn slot(brick: vec3i) -> u32 {
    if within_index(brick) {
        return grid_index[entry(brick)];
    }
    return OUTSIDE;
}

// Offset of a voxel within its brick's values, z fastest.
fn voxel_offset(voxel: vec3i) -> u32 {
    let local = vec3u(voxel & vec3i(i32(BRICK_SIDE) - 1));
    return (local.x << (2 * BRICK_SHIFT)) | (local.y << BRICK_SHIFT) | local.z;
}

// Phi at a voxel [m].
fn phi_at(voxel: vec3i) -> f32 {
    let place = slot(voxel >> vec3u(BRICK_SHIFT));
    if place < grid.bricks {
        return grid_phi[place * BRICK_VOXELS + voxel_offset(voxel)];
    }
    return select(grid.band, -grid.band, place == INSIDE);
}

// Phi at the eight corners of a cell [m], z fastest.
fn cell_phi(corner: vec3i) -> array<f32, 8> {
    var values: array<f32, 8>;
    for (var i = 0; i < 8; i++) {
        values[i] = phi_at(corner + vec3i(i >> 2, (i >> 1) & 1, i & 1));
    }
    return values;
}

// a + (b - a) * t, written out because implementations may compute the built-in `mix` differently.
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    return a + (b - a) * t;
}

// Trilinear interpolation of eight corner values, z fastest, at `f` (0 to 1 along each axis).
fn trilinear(v: array<f32, 8>, f: vec3f) -> f32 {
    let low = lerp(lerp(v[0], v[1], f.z), lerp(v[2], v[3], f.z), f.y);
    let high = lerp(lerp(v[4], v[5], f.z), lerp(v[6], v[7], f.z), f.y);
    return lerp(low, high, f.x);
}

// True if a point is finite. Tests the bits, because compilers may assume that no operand of a comparison is NaN.
fn is_finite(point: vec3f) -> bool {
    let exponent = vec3u(0x7f800000u);
    return all((bitcast<vec3u>(point) & exponent) != exponent);
}

// Phi at a point [m], interpolated trilinearly between the eight voxels around it.
fn sample_phi(point: vec3f) -> f32 {
    if !is_finite(point) {
        return grid.invalid;
    }
    let at = point / grid.voxel;
    if all(abs(at) < vec3f(f32(FARTHEST_VOXEL))) {
        let corner = floor(at);
        return trilinear(cell_phi(vec3i(corner)), at - corner);
    }
    return grid.band;
}
