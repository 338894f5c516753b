// Step-wide variables of the formulas; twin of step_values.rs.

// Sets the variables known before a step.
fn enter_moment() {
    let pose = nominal(now());
    let voxel = setup.voxel;
    let velocity = rejected(path[piece_at(now())].velocity.xyz, pose.approach) * voxel;
    let speed = length(velocity);
    let feed = normalized(velocity);
    let along = dot(feed, pose.x);
    let spindle = setup.spindle_speed;
    state.feed_speed = speed;
    let time = time_between(now(), Time(0, 0.0));
    set_value(V_TIME, time);
    set_value(V_TRIAL_TIME, setup.trial_time + time);
    set_value(V_FEED_SPEED, speed);
    set_value(V_FEED_X, feed.x);
    set_value(V_FEED_Y, feed.y);
    set_value(V_FEED_ALONG, along);
    set_value(V_FEED_ACROSS, dot(feed, pose.y));
    // A wheel's rim moves along -x under its centre.
    let turns = select(0.0, -select(-1.0, 1.0, along * spindle >= 0.0), along != 0.0);
    set_value(V_CUTTING_DIRECTION, select(0.0, turns, setup.tool == TOOL_WHEEL));
    set_value(V_SPINDLE_SPEED, spindle);
    publish_clock();
}

fn publish_clock() {
    set_value(V_CONTACT_TIME, state.contact_time);
    set_value(V_PATH_POSITION, state.path_position);
    set_value(V_PATH_REMAINING, max(setup.path_length - state.path_position, 0.0));
}

// Sets the spindle speed that the model gives, and the sliding speed of the rim.
fn set_spindle() {
    if HAS_SPINDLE {
        let speed = formula_spindle();
        note_fault(speed, FAULT_SPINDLE);
        set_value(V_SPINDLE_SPEED, speed);
    }
    let rim = setup.rim_radius * setup.voxel;
    set_value(V_SLIDING_SPEED, abs(value(V_SPINDLE_SPEED)) * rim);
}

// Sets the offset and tilt of the tool in this step.
fn set_pose_change() {
    if !HAS_POSE {
        return;
    }
    let change = formula_pose();
    for (var n = 0u; n < 5u; n++) {
        note_fault(change[n], FAULT_POSE);
    }
    state.offset = vec4f(change[0], change[1], change[2], 0.0) / setup.voxel;
    state.tilt = vec4f(change[3], change[4], 0.0, 0.0);
}

// Records the results of a step and sets the variables of formulas.
fn leave_moment(width: f32) {
    let dt = state.dt;
    let voxel = setup.voxel;
    let speed = (state.guess - from_travel()) * voxel / dt;
    let force = reduced(SUM_FORCE);
    let area = reduced(SUM_AREA);
    set_value(V_LIFT_ACCELERATION, (speed - value(V_LIFT_SPEED)) / dt);
    set_value(V_LIFT_SPEED, speed);
    set_value(V_FORCE, force);
    set_value(V_CONTACT_AREA, area);
    set_value(V_PRESSURE_MEAN, select(0.0, force / area, area > 0.0));
    set_value(V_PATCH_WIDTH, width);
    set_value(V_REMOVAL_RATE, reduced(SUM_VOLUME) / dt);
    set_value(V_DOSE_VOLUME_RATE, reduced(SUM_COATING) / dt);
    if force > 0.0 {
        state.touched = 1u;
    }
    if state.touched == 1u {
        state.contact_time += dt;
        state.path_position += state.feed_speed * dt;
    }
    publish_clock();
}

// The same for a step in the air.
fn leave_air() {
    for (var n = 0u; n < 8u; n++) {
        let variables = array<u32, 8>(V_LIFT_ACCELERATION, V_LIFT_SPEED, V_FORCE, V_CONTACT_AREA, V_PRESSURE_MEAN,
            V_PATCH_WIDTH, V_REMOVAL_RATE, V_DOSE_VOLUME_RATE);
        set_value(variables[n], 0.0);
    }
    publish_clock();
}

// Writes the log row of the accepted step.
fn write_row(in_air: u32) {
    let time = later(now(), state.dt);
    var row: LogRecord;
    row.time_blocks = time.blocks;
    row.time_rest = time.rest;
    row.coarse = state.coarse;
    row.fine = state.fine;
    row.spindle_speed = value(V_SPINDLE_SPEED);
    row.dt = state.dt;
    row.in_air = in_air;
    if in_air == 0u {
        row.end_force = state.force_now;
        row.force = reduced(SUM_FORCE);
        row.load = reduced(SUM_LOAD);
        row.area = reduced(SUM_AREA);
        row.pressure_max = max(reduced(SUMS + MAX_PRESSURE), 0.0);
        row.volume = reduced(SUM_VOLUME);
        row.coating_volume = reduced(SUM_COATING);
    }
    log_rows[setup.log_first + state.steps % setup.log_rows] = row;
    state.steps += 1u;
}
