// Serial work after each parallel part; twin of step/mod.rs. One invocation of the workgroup runs it.


// Ends the trial and returns true if a formula gave no finite number; the height field is written back first.
fn fails() -> bool {
    let place = max(reduced(SUMS + MAX_BAD), fault);
    if place <= 0.0 {
        return false;
    }
    state.status = STATUS_FORMULA;
    state.detail = u32(place);
    write_back(FINISH);
    return true;
}

// Schedules the write-back and discard of the height field, if there is one, and the phase `then` after them.
fn write_back(then: u32) {
    state.travelled = 0.0;
    state.bent = 0.0;
    state.goes_on = 0u;
    state.border = 0.0;
    state.phase = then;
    if state.has_height_field == 1u {
        state.then = then;
        state.phase = BOUNDS;
    }
}

fn written_back() {
    state.has_height_field = 0u;
    state.phase = state.then;
}

// Accepts the step that was found.
fn settle_complete() {
    if fails() {
        return;
    }
    var width = 0.0;
    if reduced(SUMS + MAX_X) > -FAR {
        let low = vec2f(-reduced(SUMS + MAX_LOW_X), -reduced(SUMS + MAX_LOW_Y));
        state.extent = vec4f(low.x, reduced(SUMS + MAX_X), low.y, reduced(SUMS + MAX_Y));
        width = (reduced(SUMS + MAX_Y) - low.y) * setup.voxel;
    }
    state.bent += max(reduced(SUMS + MAX_RECESSION), 0.0);
    state.receded = max(reduced(SUMS + MAX_RECEDED), 0.0);
    leave_moment(width);
    prepare_states();
    let way = length(way_between(nominal(now()), nominal(later(now(), state.dt))));
    state.travelled += way;
    state.is_far = select(0u, 1u, state.travelled + 0.5 * way > setup.write_back_way);
    state.coarse = state.guess_base;
    state.fine = state.guess;
    state.speed = state.found_speed;
    let change = (state.force_now - state.end_force) / (state.stiffness_now * state.dt);
    let is_held = state.end_stiffness > 0.0 && state.stiffness_now > 0.0;
    state.surface_speed = select(0.0, state.speed + change, is_held);
    state.end_force = state.force_now;
    state.end_stiffness = state.stiffness_now;
    write_row(0u);
    state.phase = APPLY;
}

fn advance_clock() {
    let time = later(now(), state.dt);
    state.time_blocks = time.blocks;
    state.time_rest = time.rest;
    if state.dt == state.left {
        state.time_blocks = setup.duration_blocks;
        state.time_rest = setup.duration_rest;
    }
}

fn settle_apply() {
    advance_clock();
    if fails() {
        return;
    }
    if setup.grinds == 1u {
        state.flip = 1u - state.flip;
        state.start_region = state.region;
        state.goes_on = 1u;
    }
    state.phase = select(AFTER_STEP, BEND, state.bent > BENT);
}

fn plan_after_step() {
    if state.is_far == 1u || state.receded > WRITE_BACK_RECESSION {
        write_back(STEP);
    } else {
        state.phase = STEP;
    }
}

fn plan_air() {
    let reach = setup.search_reach;
    state.dt = state.step_dt;
    state.extent = setup.extent;
    state.coarse = floor(reach * SPLIT) / SPLIT;
    state.fine = reach - state.coarse;
    state.speed = 0.0;
    state.in_air = 1u;
    leave_air();
    prepare_states();
    write_row(1u);
    state.phase = AIR;
}
