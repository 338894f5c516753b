// The way of a ray through the bricks; twin of walk.rs, same names and order of operations. Lengths in voxels, from the
// lowest voxel of the index. The kernel that includes this declares `blocks` and `stage`.

// Bits of the blocks in a cube of 4^3 cells whose lowest block is the first.
const QUAD: u32 = 0x00330033u;
// Stands for infinity, which WGSL cannot write down.
const FAR: f32 = 3e38;

struct Walk {
    origin: vec3f,
    direction: vec3f,
    inverse: vec3f,
    // Distance of `origin` from the ray's own start.
    entry: f32,
    t: f32,
    // Where the ray leaves the box; not above `t` for one that misses it.
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
    // Zero for a ray that misses, and for a NaN.
    let end = select(0.0, leave - enter, enter < leave && leave < FAR && !beside);
    return Walk(start + direction * enter, direction, inverse, enter, 0.0, end);
}

// log2 of the side of the largest aligned cube around a cell of a brick in which no bit is set.
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

// log2 of the side of the aligned cube around a cell in which no metal can be entered; 0 where it can.
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

// Lowest corner of the cell that the ray is in or, on a border, enters next.
fn corner_at(walk: Walk, at: vec3f) -> vec3i {
    let whole = vec3i(at);
    let on_border = (walk.direction < vec3f(0.0)) & (vec3f(whole) == at);
    return whole - select(vec3i(0), vec3i(1), on_border);
}

// Length from `at` to where the ray leaves the cube with lowest corner `low`.
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

// Distance from the start of a ray to where it enters the metal, or NO_ROOT.
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

// Share of a light that reaches the start of a ray towards it; `spread` is the tangent of its half angle.
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
