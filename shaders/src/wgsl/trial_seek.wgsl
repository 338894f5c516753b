// Search for the tool's motion in a step, evaluation by evaluation; twin of step/force_balance.rs.

// Chooses a height field that contains the contact of the next steps.
fn plan_height_field() {
    let write_back_way = setup.write_back_way;
    let ahead = time_for(write_back_way + setup.step_way + LOOK_AHEAD);
    let count = u32(ceil(write_back_way / setup.step_way));
    var window = no_window();
    var start: Pose;
    for (var n = 0u; n <= count + 1u; n++) {
        let way = select(state.step_dt + ahead * (f32(n) - 1.0) / f32(count), 0.0, n == 0u);
        let pose = pose_at(later(now(), way));
        window = widen(window[0], window[1].x, pose);
        if n == 0u {
            start = pose;
        }
    }
    let low = window[0].xy - MARGIN;
    let size = vec2u(max(window[0].zw + MARGIN - low + 1, vec2i(3)));
    let lines = size.x * size.y;
    if lines > setup.column_lines {
        state.needed = lines;
        pause(STATUS_NEEDS_COLUMNS, READ_HEIGHT_FIELD);
        return;
    }
    state.window_low = vec4i(low, 0, 0);
    state.window_size = vec4u(size, 0u, 0u);
    let level = whole_to_height_field(start.whole).z;
    state.base = level + i32(ceil(to_height_field(start.rest).z));
    let seeks = state.searched == 1u || state.in_air == 1u || setup.grinds == 0u;
    let below = select(NEAR_BELOW, 2.0 * setup.search_reach, seeks);
    let falling = max(-state.speed, 0.0) * max(LONGEST_STEP, state.step_dt);
    state.least = min(window[1].x, level) - i32(ceil(below + falling));
    state.phase = READ;
}

// Stops the trial until the host has acted.
fn pause(status: u32, resume: u32) {
    state.status = status;
    state.resume = resume;
    state.phase = IDLE;
}

// Decides if the tool is first balanced at its current position: from the air, and if an ideal controller grinds and
// the step does not continue from the previous one.
fn plan_try() {
    let anew = is_ideal() && setup.grinds == 1u && state.goes_on == 0u;
    state.settling = select(0u, 1u, state.in_air == 1u || anew);
    state.phase = AIM;
}

// Sets the poses of the trial step.
fn plan_aim() {
    state.dt = select(state.step_dt, 0.0, state.settling == 1u);
    let dt = state.dt;
    // Poses at the start, in the middle and at the end, without travel.
    var poses: array<Pose, 3>;
    for (var n = 0u; n < 3u; n++) {
        poses[n] = changed(nominal(later(now(), 0.5 * f32(n) * dt)));
    }
    keep_pose(POSE_START, lifted(poses[0]));
    state.sweep = vec4f(0.0);
    state.phase = SEARCH;
    if setup.grinds == 1u {
        keep_pose(POSE_AIM, poses[2]);
        if state.goes_on == 0u {
            state.start_region = state.region;
            state.phase = BEGIN;
        }
    } else {
        keep_pose(POSE_AIM, poses[1]);
        state.sweep = vec4f(to_height_field(way_between(poses[0], poses[2])), 0.0);
    }
    state.goes_on = 0u;
}

// True if the controller is stepped at its own period.
fn is_sampled() -> bool {
    return state.controller == CONTROLLER_ADMITTANCE && state.dt <= period() * (1.0 + 1e-5);
}

// Advances an admittance controller by one sample (semi-implicit Euler).
fn sample_admittance() {
    let dt = state.dt;
    let mass = setup.mass;
    let over = force_reading(state.end_force) - setup.force_setpoint;
    let speed = (mass * state.speed + dt * over) / (mass + dt * setup.damping);
    state.found_speed = speed;
    state.guess = state.fine + dt * speed;
    rebase();
}

fn plan_search() {
    state.guess_base = state.coarse;
    if state.controller == CONTROLLER_REPLAY {
        state.guess_base = 0.0;
        state.guess = 0.0;
    } else if is_sampled() {
        sample_admittance();
    } else {
        let follows = f32(u32(!is_ideal()));
        start_balance(follows * setup.damping, follows * setup.mass);
    }
    plan_evaluation();
}

// Bulge: excess of a surface point's depth in the middle of the tool's motion `way` over the mean of both ends.
fn tool_bulge(pose: Pose, way: vec3f) -> f32 {
    let along = dot(pose.x, way) * dot(pose.x, way);
    let across = dot(pose.y, way) * dot(pose.y, way);
    if setup.tool == TOOL_WHEEL {
        return (along / setup.tool_radius + across * setup.tool_crown) / 8.0;
    }
    return select(0.0, (along + across) / (8.0 * setup.tool_radius), setup.tool == TOOL_SPHERE);
}

// Sets the poses for an evaluation of the force at `guess`.
fn plan_evaluation() {
    let aim = kept_pose(POSE_AIM);
    let end = moved(moved(aim, aim.approach, state.guess_base), aim.approach, state.guess);
    store_pose(POSE_END, end);
    var middle = end;
    if setup.grinds == 1u {
        let start = kept_pose(POSE_START);
        let way = 0.5 * (vec3f(start.whole - end.whole) + (start.rest - end.rest));
        middle = moved(end, way + 0.5 * setup.drop * (start.z - end.z), 1.0);
        state.bulge = tool_bulge(end, 2.0 * (way + 0.5 * setup.drop * (start.z - end.z)));
    }
    store_pose(POSE_MIDDLE, middle);
    state.phase = EVALUATE;
}
