// The order of things: what follows each parallel part; twin of pass/mod.rs. One invocation of the workgroup runs it.

// Recession after which a sheet is written back, and after which its slopes are taken anew [voxels].
const COMMIT_RECESSION: f32 = 0.4;
const BENT: f32 = 0.02;

// Ends the trial if a formula gave no finite number; the sheet is written back first.
fn fails() -> bool {
    let place = max(reduced(SUMS + MAX_BAD), fault);
    if place <= 0.0 {
        return false;
    }
    states[trial].status = STATUS_FORMULA;
    states[trial].detail = u32(place);
    write_back(FINISH);
    return true;
}

// Writes the sheet's losses into the field and drops it; then goes on with a phase.
fn write_back(then: u32) {
    states[trial].travelled = 0.0;
    states[trial].bent = 0.0;
    states[trial].goes_on = 0u;
    states[trial].border = 0.0;
    states[trial].phase = then;
    if states[trial].has_sheet == 1u {
        states[trial].then = then;
        states[trial].phase = BOUNDS;
    }
}

fn written_back() {
    states[trial].has_sheet = 0u;
    states[trial].phase = states[trial].then;
}

// Takes the step that was found.
fn settle_complete() {
    if fails() {
        return;
    }
    var width = 0.0;
    if reduced(SUMS + MAX_X) > -FAR {
        let low = vec2f(-reduced(SUMS + MAX_LOW_X), -reduced(SUMS + MAX_LOW_Y));
        states[trial].extent = vec4f(low.x, reduced(SUMS + MAX_X), low.y, reduced(SUMS + MAX_Y));
        width = (reduced(SUMS + MAX_Y) - low.y) * setups[trial].voxel;
    }
    states[trial].bent += max(reduced(SUMS + MAX_RECESSION), 0.0);
    states[trial].receded = max(reduced(SUMS + MAX_RECEDED), 0.0);
    leave_moment(width);
    prepare_states();
    let way = way_between(nominal(now()), nominal(later(now(), states[trial].dt)));
    states[trial].travelled += length(way);
    states[trial].coarse = states[trial].guess_base;
    states[trial].fine = states[trial].guess;
    states[trial].speed = states[trial].found_speed;
    states[trial].end_force = states[trial].force_now;
    write_row(0u);
    states[trial].phase = APPLY;
}

fn advance_clock() {
    let time = later(now(), states[trial].dt);
    states[trial].time_blocks = time.blocks;
    states[trial].time_rest = time.rest;
    if states[trial].dt == states[trial].left {
        states[trial].time_blocks = setups[trial].duration_blocks;
        states[trial].time_rest = setups[trial].duration_rest;
    }
}

fn settle_apply() {
    advance_clock();
    if fails() {
        return;
    }
    if setups[trial].grinds == 1u {
        states[trial].flip = 1u - states[trial].flip;
        states[trial].start_region = states[trial].region;
        states[trial].goes_on = 1u;
    }
    states[trial].phase = select(AFTER_STEP, BEND, states[trial].bent > BENT);
}

fn plan_after_step() {
    let far = states[trial].travelled > setups[trial].commit_way;
    if far || states[trial].receded > COMMIT_RECESSION {
        write_back(STEP);
    } else {
        states[trial].phase = STEP;
    }
}

fn plan_air() {
    let reach = setups[trial].search_reach;
    states[trial].dt = states[trial].step_dt;
    states[trial].extent = setups[trial].extent;
    states[trial].coarse = floor(reach * SPLIT) / SPLIT;
    states[trial].fine = reach - states[trial].coarse;
    states[trial].speed = 0.0;
    states[trial].in_air = 1u;
    leave_air();
    prepare_states();
    write_row(1u);
    states[trial].phase = AIR;
}
