// Decisions after an evaluation of the force; twin of step/force_balance.rs.

// Processes the force of the evaluation.
fn settle_evaluation() {
    if fails() {
        return;
    }
    let force = reduced(SUM_FORCE);
    state.force_now = force;
    state.stiffness_now = reduced(SUM_STIFFNESS);
    var found = FOUND;
    if state.controller != CONTROLLER_REPLAY && !is_sampled() {
        let depth = select(reduced(SUMS + MAX_DEPTH), 0.0, force > 0.0);
        found = search(force, state.stiffness_now, depth);
        if found == NOTHING && force > 0.0 {
            state.too_soft = 1u;
        }
    }
    if fails() {
        return;
    }
    if found == SEARCHING {
        plan_evaluation();
    } else if found == NOTHING {
        settle_nothing();
    } else if found == TOO_FAST {
        state.step_dt = foreseen_step(shorter_step(state.dt));
        state.searched = 0u;
        state.phase = CHOOSE;
    } else if state.settling == 1u {
        state.coarse = state.guess_base;
        state.fine = state.guess;
        state.in_air = 0u;
        state.settling = 0u;
        state.phase = AIM;
    } else {
        settle_found();
    }
}

// No surface to press on: searches farther, or stays in the air.
fn settle_nothing() {
    if state.searched == 0u && is_ideal() {
        state.searched = 1u;
        state.extent = setup.extent;
        write_back(CHOOSE);
    } else {
        write_back(ENTER_AIR);
    }
}

// Accepts the motion found, or repeats the step on a larger height field if the patch may extend beyond the region.
fn settle_found() {
    if (state.border > 0.0 || reduced(SUMS + MAX_BORDER) > 0.0) && grow_extent() {
        write_back(CHOOSE);
        return;
    }
    state.border = max(reduced(SUMS + MAX_BORDER), 0.0);
    let dt = state.dt;
    if state.controller == CONTROLLER_REPLAY {
        state.found_speed = 0.0;
    } else if !is_sampled() {
        state.found_speed = tried_speed();
    }
    state.dt_limit = 2.0 * dt;
    if state.left - dt < DEVICE_CLOCK {
        state.dt = state.left;
    }
    let half = 0.5 * (state.guess - from_travel());
    let middle = changed(nominal(later(now(), 0.5 * state.dt)));
    keep_pose(POSE_MIDDLE, moved(moved(middle, middle.approach, state.coarse), middle.approach,
        state.fine + half));
    state.phase = COMPLETE;
}

// Grows the contact's extent by a quarter and two pitches, to the whole tool at most. Returns false if it was that
// large already.
fn grow_extent() -> bool {
    let most = setup.whole_extent;
    let old = state.extent;
    if old.x <= -most.x && old.y >= most.x && old.z <= -most.y && old.w >= most.y {
        return false;
    }
    let more = 0.25 * (old.yw - old.xz) + 2.0;
    state.extent = vec4f(
        max(old.x - more.x, -most.x), min(old.y + more.x, most.x),
        max(old.z - more.y, -most.y), min(old.w + more.y, most.y),
    );
    return true;
}
