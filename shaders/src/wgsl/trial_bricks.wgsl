// Own bricks of a trial, allocated before it writes: copies of shared bricks, and new ones ahead of the receding
// surface. The voxels of a tile of 8 x 8 columns form one stack of bricks.

// Lowest tile of the window; `tile_counts` is the number of its tiles.
fn tile_low() -> vec2i {
    return state.window_low.xy >> vec2u(BRICK_SHIFT);
}

fn tile_counts() -> vec2u {
    let last = state.window_low.xy + vec2i(vec2u(state.window_size[0], across())) - 1;
    return vec2u((last >> vec2u(BRICK_SHIFT)) - tile_low() + 1);
}

// Brick of a tile at height `k` [voxels].
fn tile_brick(tile: u32, k: i32) -> vec3i {
    let counts = tile_counts();
    let at = tile_low() + vec2i(vec2u(tile / counts.y, tile % counts.y));
    return voxel_at(at.x << BRICK_SHIFT, at.y << BRICK_SHIFT, k) >> vec3u(BRICK_SHIFT);
}

// Lowest and highest voxel that a column writes, and the one that must have a brick; nothing is written if low > high.
fn written(line: u32) -> vec3i {
    let below = voxel_below(line, column_value(SUNK, line));
    if is_changed(line) {
        let far = i32(ceil(setup.band * STEEPEST)) + 2;
        let open = below - reach_of(line);
        return vec3i(min(below, open) - far, voxel_below(line, 0.0) + far, open);
    }
    if is_dosed(line) {
        return vec3i(below - 1, below + 2, below);
    }
    return vec3i(1, 0, 0);
}

// Replaces the bricks that a tile's columns write by own bricks, as far as spare bricks are left. With `looks`, changes
// nothing and returns true if any brick has to be replaced.
fn own_bricks(tile: u32, looks: bool) -> bool {
    let counts = tile_counts();
    let corner = (tile_low() + vec2i(vec2u(tile / counts.y, tile % counts.y))) * i32(BRICK_SIDE);
    let low = max(corner - state.window_low.xy, vec2i(0));
    let size = vec2i(vec2u(state.window_size[0], across()));
    let high = min(corner + i32(BRICK_SIDE) - state.window_low.xy, size);
    for (var row = low.x; row < high.x; row++) {
        for (var place = low.y; place < high.y; place++) {
            let span = written(u32(row) * across() + u32(place));
            for (var k = span.x; k < span.y + i32(BRICK_SIDE); k += i32(BRICK_SIDE)) {
                if own_brick(tile_brick(tile, min(k, span.y)), span, looks) && looks {
                    return true;
                }
            }
        }
    }
    return false;
}

// Replaces a shared brick, or an inside brick that contains the third voxel of `span`, by an own brick. Returns true if
// the brick is one of these; with `looks`, changes nothing.
fn own_brick(brick: vec3i, span: vec3i, looks: bool) -> bool {
    let entry = index_entry(brick);
    if entry == OUTSIDE || span.x > span.y {
        return false;
    }
    let slot = brick_index[entry];
    let opens = slot == INSIDE && (span.z * state.up) >> BRICK_SHIFT == brick[state.axis];
    if !opens && (slot >= INSIDE || is_own(slot)) {
        return false;
    }
    if !looks {
        let number = state.needed;
        state.needed += 1u;
        if number < setup.spare_bricks {
            brick_index[setup.source_first + number] = slot;
            brick_index[entry] = setup.shared_bricks + number;
        }
    }
    return true;
}

// Replaces the bricks of all marked tiles by own bricks; run by one invocation.
fn own_all_bricks() {
    let counts = tile_counts();
    state.needed = state.own_bricks;
    for (var tile = 0u; tile < counts.x * counts.y; tile++) {
        if column_value(DOSE_GAIN, tile) > 0.0 {
            _ = own_bricks(tile, false);
        }
    }
    state.own_bricks = min(state.needed, setup.spare_bricks);
    states[trial].needed = state.needed;
    states[trial].own_bricks = state.own_bricks;
}

// Fills value `n` of the new bricks: a copy of the source brick, or the values of the inside.
fn fill_own(n: u32) {
    let values_of_brick = run.planes * BRICK_VOXELS;
    let number = state.filled_bricks + n / values_of_brick;
    let at = n % values_of_brick;
    let source = brick_index[setup.source_first + number];
    let place = (setup.spare_first + number) * values_of_brick + at;
    if source == INSIDE {
        pool[place] = select(0.0, -setup.band_length, at < BRICK_VOXELS);
    } else {
        pool[place] = pool[(setup.first_brick + source) * values_of_brick + at];
    }
}
