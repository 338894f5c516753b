// Pose of the tool over time; twin of path.rs and pose.rs. A pose is that of the tool's lowest point: lengths
// relative to it are small numbers, which f32 resolves.

// Time as a number of blocks of 1/64 s and a remainder [s].
struct Time {
    blocks: i32,
    rest: f32,
}

// Lowest point of a tool as a voxel and a remainder [voxels], and the tool's axes.
struct Pose {
    whole: vec3i,
    rest: vec3f,
    x: vec3f,
    y: vec3f,
    z: vec3f,
    approach: vec3f,
}

fn later(time: Time, way: f32) -> Time {
    let rest = time.rest + way;
    let blocks = floor(rest * f32(TIME_BLOCKS));
    return Time(time.blocks + i32(blocks), rest - blocks / f32(TIME_BLOCKS));
}

// Time from `b` to `a` [s].
fn time_between(a: Time, b: Time) -> f32 {
    return f32(a.blocks - b.blocks) / f32(TIME_BLOCKS) + (a.rest - b.rest);
}

fn now() -> Time {
    return Time(state.time_blocks, state.time_rest);
}

fn duration() -> Time {
    return Time(setup.duration_blocks, setup.duration_rest);
}

fn piece_time(piece: u32) -> Time {
    return Time(path[piece].whole.w, path[piece].rest.w);
}

// Segment of the path at a time that is not before the current one.
fn piece_at(time: Time) -> u32 {
    let last = setup.path_first + setup.path_pieces - 1u;
    var piece = state.piece;
    while piece < last && time_between(time, piece_time(piece + 1u)) >= 0.0 {
        piece += 1u;
    }
    return piece;
}

// Component of a vector perpendicular to a unit vector.
fn rejected(v: vec3f, unit: vec3f) -> vec3f {
    return v - unit * dot(v, unit);
}

fn normalized(v: vec3f) -> vec3f {
    let size = length(v);
    return select(vec3f(0.0), v / size, size > 0.0);
}

// The pose with each component of its remainder carried into 0 to 1.
fn carried(pose: Pose) -> Pose {
    var result = pose;
    let carry = floor(pose.rest);
    result.whole += vec3i(carry);
    result.rest -= carry;
    return result;
}

// The pose moved by `way` times a vector; whole voxels are split off first.
fn moved(pose: Pose, along: vec3f, way: f32) -> Pose {
    var result = pose;
    let step = along * way;
    let whole = floor(step);
    result.whole += vec3i(whole);
    result.rest += step - whole;
    return carried(result);
}

// The pose with the axes of a tool for its approach axis and the path's axis.
fn framed(pose: Pose, axis: vec3f) -> Pose {
    var result = pose;
    if setup.tool == TOOL_WHEEL {
        result.z = normalized(rejected(pose.approach, axis));
        result.y = axis;
        result.x = cross(axis, result.z);
    } else {
        result.z = pose.approach;
        result.x = normalized(rejected(cross(axis, pose.approach), pose.approach));
        result.y = cross(pose.approach, result.x);
    }
    return result;
}

// Nominal pose of the tool on its path, without travel and effects.
fn nominal(time: Time) -> Pose {
    let piece = piece_at(time);
    let span = path[piece].velocity.w;
    let t = clamp(time_between(time, piece_time(piece)), 0.0, span);
    let share = t / span;
    var pose: Pose;
    pose.whole = path[piece].whole.xyz;
    pose.rest = path[piece].rest.xyz + path[piece].velocity.xyz * t;
    pose.approach = normalized(mix(path[piece].approach.xyz, path[piece + 1u].approach.xyz, share));
    let axis = normalized(mix(path[piece].axis.xyz, path[piece + 1u].axis.xyz, share));
    return framed(carried(pose), axis);
}

// The pose with the offset and tilt of the model's effects; the tool tilts about its reference point.
fn changed(pose: Pose) -> Pose {
    let offset = state.offset;
    let tilt = state.tilt;
    var shift = offset.xyz;
    var result = pose;
    if tilt.x != 0.0 || tilt.y != 0.0 {
        let s = vec2f(op_sin(tilt.x), op_sin(tilt.y));
        let c = vec2f(op_cos(tilt.x), op_cos(tilt.y));
        let halves = vec2f(op_sin(0.5 * tilt.x), op_sin(0.5 * tilt.y));
        let rise = 2.0 * (halves.x * halves.x + c.x * halves.y * halves.y);
        shift += setup.drop * vec3f(-s.y, s.x * c.y, rise);
        let frame = mat3x3f(pose.x, pose.y, pose.z);
        result.x = frame * vec3f(c.y, s.x * s.y, -c.x * s.y);
        result.y = frame * vec3f(0.0, c.x, s.x);
        result.z = frame * vec3f(s.y, -s.x * c.y, c.x * c.y);
    }
    return moved(result, mat3x3f(pose.x, pose.y, pose.z) * shift, 1.0);
}

// The pose lifted by the current travel.
fn lifted(pose: Pose) -> Pose {
    return moved(moved(pose, pose.approach, state.coarse), pose.approach, state.fine);
}

// Pose of the tool with travel and effects.
fn pose_at(time: Time) -> Pose {
    return lifted(changed(nominal(time)));
}

// Displacement of the reference point from pose `a` to pose `b` [voxels].
fn way_between(a: Pose, b: Pose) -> vec3f {
    return vec3f(b.whole - a.whole) + (b.rest - a.rest) + setup.drop * (b.z - a.z);
}
