// Surface under the tool as columns along lattice lines; twin of height_field.rs. The search on every column starts at
// the height field's level. The CPU starts at the neighbour's height, which gives the same surface except at overhangs.

// Height step between neighbouring columns from which on it counts as a side face [pitches].
const WALL: f32 = 2.0;

// Lattice indices of a column.
fn line_place(line: u32) -> vec2i {
    return state.window_low.xy + vec2i(i32(line / across()), i32(line % across()));
}

// Reads a column from the distance field.
fn read_column(line: u32) {
    let at = line_place(line);
    let base = state.base;
    let met = surface(at.x, at.y, base, state.least);
    set_column(SUNK, line, 0.0);
    set_column(DOSE, line, 0.0);
    set_column(REMOVED, line, 0.0);
    set_column(LABEL, line, 0.0);
    set_column(END_SHARE, line, 0.0);
    set_column(END_SHARE + SIDE_ARRAYS, line, 0.0);
    if met.y == 0 {
        set_column(WHOLE, line, NO_SURFACE);
        set_column(PART, line, 0.0);
        return;
    }
    let k = met.x;
    let part = way_to_zero(
        phi_at(voxel_at(at.x, at.y, k - 1)), phi_at(voxel_at(at.x, at.y, k)),
        phi_at(voxel_at(at.x, at.y, k + 1)), phi_at(voxel_at(at.x, at.y, k + 2)),
    );
    set_column(WHOLE, line, f32(k - base));
    set_column(PART, line, part);
    let nearest = voxel_at(at.x, at.y, k + select(0, 1, part >= 0.5));
    read_channel(DOSE, line, nearest, run.dose_plane);
    read_channel(REMOVED, line, nearest, run.removed_plane);
    read_channel(LABEL, line, nearest, run.label_plane);
}

fn read_channel(array_id: u32, line: u32, nearest: vec3i, plane: u32) {
    if plane == ABSENT {
        return;
    }
    let at = place_of(nearest, plane);
    if at != OUTSIDE {
        set_column(array_id, line, pool[at]);
    }
}

// Slope at a column from the height steps before and after it; a side face does not count.
fn slope_from(before: f32, after: f32) -> f32 {
    let near_before = abs(before) < WALL;
    let near_after = abs(after) < WALL;
    if near_before && near_after {
        return 0.5 * (before + after);
    }
    return select(select(0.0, after, near_after), before, near_before);
}

// Height step between two columns; that of a side face if one of them is outside the window.
fn rise(there: bool, from_line: u32, to_line: u32) -> f32 {
    if !there {
        return 2.0 * WALL;
    }
    return height_difference(to_line, from_line);
}

// Computes the slopes at a column from the current heights.
fn set_slope(line: u32) {
    let rows = state.window_size[0];
    let row = line / across();
    let place = line % across();
    let u = slope_from(
        rise(row > 0u, line - across(), line),
        rise(row + 1u < rows, line, line + across()),
    );
    let v = slope_from(rise(place > 0u, line - 1u, line), rise(place + 1u < across(), line, line + 1u));
    set_column(SLOPE_U, line, u);
    set_column(SLOPE_V, line, v);
}

// Tangent of the angle between the surface's normal and the approach axis.
fn slope_against(line: u32, approach: vec3f) -> f32 {
    let slope = slope_of(line);
    let cosine = clamp(dot(normalize(vec3f(-slope, 1.0)), approach), 1e-6, 1.0);
    return sqrt(max(1.0 - cosine * cosine, 0.0)) / cosine;
}

// Share of a cell's lattice area that faces the approach axis.
fn approach_share(line: u32, approach: vec3f) -> f32 {
    let slope = slope_of(line);
    return max(approach.z - slope.x * approach.x - slope.y * approach.y, 0.0);
}

// Stores a pose in the coordinates of the height field.
fn keep_pose(slot: u32, pose: Pose) {
    state.wholes[slot] = vec4i(whole_to_height_field(pose.whole), 0);
    state.frames[5u * slot] = vec4f(to_height_field(pose.rest), 0.0);
    state.frames[5u * slot + 1u] = vec4f(to_height_field(pose.x), 0.0);
    state.frames[5u * slot + 2u] = vec4f(to_height_field(pose.y), 0.0);
    state.frames[5u * slot + 3u] = vec4f(to_height_field(pose.z), 0.0);
    state.frames[5u * slot + 4u] = vec4f(to_height_field(pose.approach), 0.0);
}

// Stored pose; its vectors are (u, v, up).
fn kept_pose(slot: u32) -> Pose {
    return Pose(
        state.wholes[slot].xyz, state.frames[5u * slot].xyz, state.frames[5u * slot + 1u].xyz,
        state.frames[5u * slot + 2u].xyz, state.frames[5u * slot + 3u].xyz,
        state.frames[5u * slot + 4u].xyz,
    );
}

// Stores a pose that is already in the coordinates of the height field.
fn store_pose(slot: u32, pose: Pose) {
    state.wholes[slot] = vec4i(pose.whole, 0);
    state.frames[5u * slot] = vec4f(pose.rest, 0.0);
    state.frames[5u * slot + 1u] = vec4f(pose.x, 0.0);
    state.frames[5u * slot + 2u] = vec4f(pose.y, 0.0);
    state.frames[5u * slot + 3u] = vec4f(pose.z, 0.0);
    state.frames[5u * slot + 4u] = vec4f(pose.approach, 0.0);
}

// Surface point of a column in the tool's frame, relative to the tool's lowest point [voxels].
fn local_point(line: u32, pose: Pose) -> vec3f {
    let at = line_place(line) - pose.whole.xy;
    let flat = vec2f(at) - pose.rest.xy;
    let up = (column_value(WHOLE, line) + f32(state.base - pose.whole.z))
        + ((column_value(PART, line) - pose.rest.z) - column_value(SUNK, line));
    let from_low = vec3f(flat, up);
    return vec3f(dot(pose.x, from_low), dot(pose.y, from_low), dot(pose.z, from_low));
}
