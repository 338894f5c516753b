// Traversal of the bricks by a ray; twin of walk.rs, with the same names and order of operations. Lengths are in
// voxels, from the lowest voxel of the index. The including kernel declares `blocks` and `stage`.

// Bits of the blocks in the first cube of 4^3 cells.
const QUAD: u32 = 0x00330033u;
// Replacement for infinity, which WGSL cannot express.
const FAR: f32 = 3e38;

struct Walk {
    origin: vec3f,
    direction: vec3f,
    inverse: vec3f,
    // Distance of `origin` from the start of the ray.
    entry: f32,
    t: f32,
    // Position along the ray at which it leaves the box; not above `t` if it misses the box.
    end: f32,
}

// Lowest voxel of the index.
fn lowest() -> vec3i {
    return grid.origin.xyz * i32(BRICK_SIDE);
}

fn start_walk(start: vec3f, direction: vec3f) -> Walk {
    let size = vec3f(grid.dims.xyz * BRICK_SIDE);
    let still = direction == vec3f(0.0);
    let inverse = select(1.0 / direction, vec3f(0.0), still);
    let a = select(-start * inverse, vec3f(-FAR), still);
    let b = select((size - start) * inverse, vec3f(FAR), still);
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    let leave = min(far.x, min(far.y, far.z));
    let beside = any(still & ((start < vec3f(0.0)) | (start > size)));
    // Zero for a ray that misses the box, and for a NaN.
    let end = select(0.0, leave - enter, enter < leave && leave < FAR && !beside);
    return Walk(start + direction * enter, direction, inverse, enter, 0.0, end);
}

// log2 of the side of the largest aligned cube around a cell of a brick in which no bit is set; 0 if the cell's is set.
fn blocks_clear_shift(bits: vec2u, cell: vec3i) -> u32 {
    if all(bits == vec2u(0u)) {
        return 3u;
    }
    let block = vec3u(cell & vec3i(7)) >> vec3u(1u);
    let quad = block >> vec3u(1u);
    let word = bits[quad.x];
    if (word & (QUAD << (8u * quad.y + 2u * quad.z))) == 0u {
        return 2u;
    }
    return select(0u, 1u, ((word >> (16u * (block.x & 1u) + 4u * block.y + block.z)) & 1u) == 0u);
}

// log2 of the side of the aligned cube around a cell in which a ray cannot enter metal; 0 if it may.
fn clear_shift(corner: vec3i) -> u32 {
    let place = slot((corner >> vec3u(BRICK_SHIFT)) + grid.origin.xyz);
    if place == OUTSIDE {
        return BRICK_SHIFT;
    }
    if place == INSIDE {
        return 0u;
    }
    return blocks_clear_shift(blocks[place], corner);
}

// Lowest corner of the cell that contains the ray or, on a border, of the cell that it enters next.
fn corner_at(walk: Walk, at: vec3f) -> vec3i {
    let whole = vec3i(at);
    let on_border = (walk.direction < vec3f(0.0)) & (vec3f(whole) == at);
    return whole - select(vec3i(0), vec3i(1), on_border);
}

// Length from `at` to the exit of the ray from the cube with lowest corner `low`.
fn length_in(walk: Walk, at: vec3f, low: vec3f, side: f32) -> f32 {
    let border = select(low + side, low, walk.direction < vec3f(0.0));
    let length = select((border - at) * walk.inverse, vec3f(FAR), walk.direction == vec3f(0.0));
    return max(min(length.x, min(length.y, length.z)), 0.0);
}

// Length of the ray within a cell up to the first zero of phi, or NO_ROOT.
fn crossing(values: array<f32, 8>, start: vec3f, direction: vec3f, length: f32) -> f32 {
    let low = min(min(values[0], values[1]), min(values[2], values[3]));
    let high = min(min(values[4], values[5]), min(values[6], values[7]));
    if min(low, high) > 0.0 {
        return NO_ROOT;
    }
    let step = direction * length;
    let along = vec4f(
        trilinear(values, start),
        trilinear(values, start + direction * (1.0 / 3.0 * length)),
        trilinear(values, start + direction * (2.0 / 3.0 * length)),
        trilinear(values, start + step),
    );
    let root = first_root(along);
    return select(NO_ROOT, root * length, root >= 0.0);
}

// Distance from the start of a ray to its entry into the metal, or NO_ROOT.
fn first_crossing(start: vec3f, direction: vec3f) -> f32 {
    var walk = start_walk(start, direction);
    while walk.t < walk.end {
        let at = walk.origin + walk.direction * walk.t;
        let corner = corner_at(walk, at);
        let shift = clear_shift(corner);
        let low = (corner >> vec3u(shift)) << vec3u(shift);
        let length = length_in(walk, at, vec3f(low), f32(1u << shift));
        if shift == 0u {
            let root = crossing(cell_phi(corner + lowest()), at - vec3f(low), direction, length);
            if root >= 0.0 {
                return walk.entry + walk.t + root;
            }
        }
        walk.t += length + stage.nudge;
    }
    return NO_ROOT;
}

// Share of a light that reaches the start of a ray towards it; `spread`: tangent of the light's half angle.
fn light_share_along(start: vec3f, direction: vec3f, spread: f32) -> f32 {
    var walk = start_walk(start, direction);
    let band = grid.band / grid.voxel;
    var share = 1.0;
    while walk.t < walk.end {
        let at = walk.origin + walk.direction * walk.t;
        let corner = corner_at(walk, at);
        let brick = corner >> vec3u(BRICK_SHIFT);
        let place = slot(brick + grid.origin.xyz);
        if place == OUTSIDE {
            walk.t += length_in(walk, at, vec3f(brick << vec3u(BRICK_SHIFT)), f32(BRICK_SIDE)) + stage.nudge;
            continue;
        }
        let clearance = trilinear(cell_phi(corner + lowest()), at - vec3f(corner)) / grid.voxel;
        if !(clearance > 0.0) {
            return 0.0;
        }
        let cone = min(spread * (walk.entry + walk.t), PENUMBRA_BAND * band);
        if clearance < share * cone {
            share = clearance / cone;
        }
        walk.t += max(clearance, LEAST_STEP);
    }
    return share;
}
