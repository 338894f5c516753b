// What the formulas may read once per step; twin of step_values.rs.

// Sets what is known before a step.
fn enter_moment() {
    let pose = nominal(now());
    let voxel = setups[trial].voxel;
    let velocity = rejected(path[piece_at(now())].velocity.xyz, pose.approach) * voxel;
    let speed = length(velocity);
    let feed = normalized(velocity);
    let along = dot(feed, pose.x);
    let spindle = setups[trial].spindle_speed;
    states[trial].feed_speed = speed;
    let time = time_between(now(), Time(0, 0.0));
    set_value(V_TIME, time);
    set_value(V_TRIAL_TIME, setups[trial].trial_time + time);
    set_value(V_FEED_SPEED, speed);
    set_value(V_FEED_X, feed.x);
    set_value(V_FEED_Y, feed.y);
    set_value(V_FEED_ALONG, along);
    set_value(V_FEED_ACROSS, dot(feed, pose.y));
    // A wheel's rim moves along -x under its centre.
    let turns = select(0.0, -select(-1.0, 1.0, along * spindle >= 0.0), along != 0.0);
    set_value(V_CUTTING_DIRECTION, select(0.0, turns, setups[trial].tool == TOOL_WHEEL));
    set_value(V_SPINDLE_SPEED, spindle);
    publish_clock();
}

fn publish_clock() {
    set_value(V_CONTACT_TIME, states[trial].contact_time);
    set_value(V_PATH_POSITION, states[trial].path_position);
    set_value(V_PATH_REMAINING, max(setups[trial].path_length - states[trial].path_position, 0.0));
}

// Sets the spindle's speed as the model has it.
fn set_spindle() {
    if HAS_SPINDLE {
        let speed = formula_spindle();
        note_fault(speed, FAULT_SPINDLE);
        set_value(V_SPINDLE_SPEED, speed);
    }
    let rim = setups[trial].rim_radius * setups[trial].voxel;
    set_value(V_SLIDING_SPEED, abs(value(V_SPINDLE_SPEED)) * rim);
}

// Offset and tilt of the tool in this step.
fn set_pose_change() {
    if !HAS_POSE {
        return;
    }
    let change = formula_pose();
    for (var n = 0u; n < 5u; n++) {
        note_fault(change[n], FAULT_POSE);
    }
    states[trial].offset = vec4f(change[0], change[1], change[2], 0.0) / setups[trial].voxel;
    states[trial].tilt = vec4f(change[3], change[4], 0.0, 0.0);
}

// Takes up what a step did, and tells the formulas.
fn leave_moment(width: f32) {
    let dt = states[trial].dt;
    let voxel = setups[trial].voxel;
    let speed = (states[trial].guess - from_travel()) * voxel / dt;
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
        states[trial].touched = 1u;
    }
    if states[trial].touched == 1u {
        states[trial].contact_time += dt;
        states[trial].path_position += states[trial].feed_speed * dt;
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

// Writes the row of the step that has been taken.
fn write_row(in_air: u32) {
    let time = later(now(), states[trial].dt);
    var row: LogRecord;
    row.time_blocks = time.blocks;
    row.time_rest = time.rest;
    row.coarse = states[trial].coarse;
    row.fine = states[trial].fine;
    row.spindle_speed = value(V_SPINDLE_SPEED);
    row.dt = states[trial].dt;
    row.in_air = in_air;
    if in_air == 0u {
        row.end_force = states[trial].force_now;
        row.force = reduced(SUM_FORCE);
        row.load = reduced(SUM_LOAD);
        row.area = reduced(SUM_AREA);
        row.pressure_max = max(reduced(SUMS + MAX_PRESSURE), 0.0);
        row.volume = reduced(SUM_VOLUME);
        row.coating_volume = reduced(SUM_COATING);
    }
    log_rows[setups[trial].log_first + states[trial].steps % setups[trial].log_rows] = row;
    states[trial].steps += 1u;
}
