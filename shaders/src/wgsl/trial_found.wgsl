// What follows an evaluation of the force; twin of pass/seek.rs.

// Takes up the force of the evaluation.
fn settle_evaluation() {
    if fails() {
        return;
    }
    let force = reduced(SUM_FORCE);
    states[trial].force_now = force;
    var found = FOUND;
    if states[trial].controller != CONTROLLER_REPLAY && !is_sampled() {
        let depth = select(reduced(SUMS + MAX_DEPTH), 0.0, force > 0.0);
        found = search(force, reduced(SUM_STIFFNESS) * setups[trial].voxel, depth);
        if found == NOTHING && force > 0.0 {
            states[trial].too_soft = 1u;
        }
    }
    if fails() {
        return;
    }
    if found == SEARCHING {
        plan_evaluation();
    } else if found == NOTHING {
        settle_nothing();
    } else if states[trial].settling == 1u {
        states[trial].coarse = states[trial].guess_base;
        states[trial].fine = states[trial].guess;
        states[trial].in_air = 0u;
        states[trial].settling = 0u;
        states[trial].phase = AIM;
    } else {
        settle_found();
    }
}

// Nothing to press on: looks further, or stays in the air.
fn settle_nothing() {
    if states[trial].searched == 0u && is_ideal() {
        states[trial].searched = 1u;
        states[trial].extent = setups[trial].extent;
        write_back(CHOOSE);
    } else {
        write_back(ENTER_AIR);
    }
}

// The motion is found: takes it, on a larger sheet if the patch may go on, or in a shorter step.
fn settle_found() {
    if (states[trial].border > 0.0 || reduced(SUMS + MAX_BORDER) > 0.0) && grow_extent() {
        write_back(CHOOSE);
        return;
    }
    states[trial].border = max(reduced(SUMS + MAX_BORDER), 0.0);
    let dt = states[trial].dt;
    if states[trial].controller == CONTROLLER_REPLAY {
        states[trial].found_speed = 0.0;
    } else if !is_sampled() {
        states[trial].found_speed = select(0.0, (states[trial].guess - from_travel()) / dt, dt > 0.0);
    }
    if dt > period() && is_fast() {
        states[trial].step_dt = max(0.25 * dt, period());
        states[trial].searched = 0u;
        states[trial].phase = CHOOSE;
        return;
    }
    states[trial].dt_limit = 2.0 * dt;
    if states[trial].left - dt < 1e-7 {
        states[trial].dt = states[trial].left;
    }
    let half = 0.5 * (states[trial].guess - from_travel());
    let middle = changed(nominal(later(now(), 0.5 * states[trial].dt)));
    keep_pose(POSE_MIDDLE, moved(moved(middle, middle.approach, states[trial].coarse), middle.approach,
        states[trial].fine + half));
    states[trial].phase = COMPLETE;
}

// Whether an admittance moves too fast for the step to follow it.
fn is_fast() -> bool {
    let inertial = abs(setups[trial].mass * (states[trial].found_speed - states[trial].speed) / states[trial].dt);
    let setpoint = setups[trial].force_setpoint;
    return inertial > INERTIA * setpoint || abs(states[trial].force_now - states[trial].end_force) > FORCE_JUMP * setpoint;
}

// Grows the contact's extent by a quarter and two pitches, to the whole tool at most; says no if it was that large.
fn grow_extent() -> bool {
    let most = setups[trial].whole_extent;
    let old = states[trial].extent;
    if old.x <= -most.x && old.y >= most.x && old.z <= -most.y && old.w >= most.y {
        return false;
    }
    let more = 0.25 * (old.yw - old.xz) + 2.0;
    states[trial].extent = vec4f(
        max(old.x - more.x, -most.x), min(old.y + more.x, most.x),
        max(old.z - more.y, -most.y), min(old.w + more.y, most.y),
    );
    return true;
}
