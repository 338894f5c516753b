// Decisions of one invocation between the parallel parts of a step: clock, height field and poses; twin of step/mod.rs,
// step/force_balance.rs and extent.rs.


fn is_ideal() -> bool {
    return state.controller == CONTROLLER_IDEAL;
}

fn period() -> f32 {
    return select(FAR, setup.period, state.controller == CONTROLLER_ADMITTANCE);
}

fn path_speed() -> f32 {
    return length(path[piece_at(now())].velocity.xyz);
}

// Time in which the tool moves by `way` voxels [s]; 0 at rest.
fn time_for(way: f32) -> f32 {
    let speed = path_speed();
    return select(0.0, way / speed, speed > 0.0);
}

// Starts a step, or ends the pass.
fn plan_step() {
    let left = time_between(duration(), now());
    state.left = left;
    let most = setup.most_steps;
    if left <= 0.0 || (most > 0u && state.steps >= most) {
        if left > 0.0 {
            state.status = STATUS_TOO_MANY_STEPS;
        }
        write_back(FINISH);
        return;
    }
    state.piece = piece_at(now());
    let approach = time_between(Time(setup.approach_blocks, setup.approach_rest), now());
    let comes_down = approach > DEVICE_CLOCK;
    take_over(!comes_down);
    var dt = min(min(state.dt_limit, setup.longest_step), min(path[state.piece].approach.w, left));
    if setup.quasi_static == 0u {
        dt = min(dt, period());
    }
    if comes_down {
        dt = min(min(dt, APPROACH_STEP), approach);
    }
    state.searched = 0u;
    enter_moment();
    set_spindle();
    set_pose_change();
    state.step_dt = foreseen_step(dt);
    prepare_lanes();
    state.phase = CHOOSE;
}

// Ends the approach when its time is over or the tool touches the part.
fn take_over(over: bool) {
    let touches = value(V_FORCE) > TOUCH * setup.force_setpoint;
    if state.controller != setup.controller && (touches || over) {
        state.controller = setup.controller;
    }
}

// Extends the window [first u, first v, last u, last v] and its lowest height to the contact's corners at a pose.
fn widen(window: vec4i, lowest: i32, pose: Pose) -> array<vec4i, 2> {
    let whole = whole_to_height_field(pose.whole);
    let rest = to_height_field(pose.rest);
    let x = to_height_field(pose.x);
    let y = to_height_field(pose.y);
    var result = window;
    var low = lowest;
    for (var n = 0u; n < 4u; n++) {
        let at = rest + x * state.extent[n >> 1u] + y * state.extent[2u + (n & 1u)];
        let first = whole + vec3i(floor(at));
        let last = whole.xy + vec2i(ceil(at.xy));
        result = vec4i(min(result.xy, first.xy), max(result.zw, last));
        low = min(low, first.z);
    }
    return array<vec4i, 2>(result, vec4i(low));
}

fn no_window() -> array<vec4i, 2> {
    return array<vec4i, 2>(vec4i(2147483647, 2147483647, -2147483647, -2147483647), vec4i(2147483647));
}

// Lattice axis nearest to the approach axis, and its upward direction.
fn facing(approach: vec3f) -> vec2i {
    let size = abs(approach);
    var axis = select(0, 1, size.y > size.x);
    axis = select(axis, 2, size.z > max(size.x, size.y));
    return vec2i(axis, select(1, -1, approach[axis] < 0.0));
}

// Ensures a height field that contains the contact of the step, and sets the region of the step in it.
fn choose_height_field() {
    let dt = state.step_dt;
    let wanted = facing(nominal(now()).approach);
    let turned = state.axis != u32(wanted.x) || state.up != wanted.y;
    if state.has_height_field == 1u && turned {
        write_back(CHOOSE);
        return;
    }
    state.axis = u32(wanted.x);
    state.up = wanted.y;
    var window = no_window();
    let ways = vec3f(0.0, dt, dt + time_for(LOOK_AHEAD));
    for (var n = 0u; n < 3u; n++) {
        window = widen(window[0], window[1].x, pose_at(later(now(), ways[n])));
    }
    let low = window[0].xy - MARGIN;
    let size = max(window[0].zw + MARGIN - low + 1, vec2i(3));
    state.wanted = vec4i(low, size);
    let held = state.window_low.xy;
    let end = held + vec2i(vec2u(state.window_size[0], across()));
    if state.has_height_field == 1u && all(low + MARGIN >= held) && all(low + size - MARGIN <= end) {
        look();
        state.phase = TRY;
    } else {
        write_back(READ_HEIGHT_FIELD);
    }
}

// Sets the region that the step evaluates, of columns that have neighbours on all sides.
fn look() {
    let first = state.wanted.xy - state.window_low.xy;
    let ends = vec2i(vec2u(state.window_size[0], across())) - 1;
    let last = clamp(first + state.wanted.zw, vec2i(1), ends);
    let from_line = clamp(first, vec2i(1), last);
    state.region = vec4u(vec2u(from_line), vec2u(last - from_line));
}
