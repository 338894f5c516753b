// Order of the phases.

// Completes the phase that has run and chooses the next one.
fn settle() {
    switch state.phase {
        case READ: { state.has_height_field = 1u; look(); state.phase = TRY; }
        case BEGIN: {
            state.border = max(reduced(SUMS + MAX_BORDER), 0.0);
            state.phase = SEARCH;
            _ = fails();
        }
        case EVALUATE: { settle_evaluation(); }
        case COMPLETE: { settle_complete(); }
        case APPLY: { settle_apply(); }
        case BEND: { state.bent = 0.0; state.phase = AFTER_STEP; }
        case AIR: { advance_clock(); state.phase = STEP; _ = fails(); }
        case BOUNDS: { settle_bounds(); }
        case BRICKS: { state.phase = COPY; }
        case COPY: { settle_copy(); }
        case RAISE: { state.phase = select(SLOPES, BOUNDS_DONE, state.changed.z == 0u); }
        case SLOPES: {
            state.layers = u32(max(reduced(SUMS + MAX_REACH), 0.0));
            state.layer = 1u;
            state.phase = FAR_LAYER;
        }
        case FAR_LAYER: { settle_far(); }
        default: { if state.status == STATUS_RUNNING { state.phase = state.resume; } }
    }
}

// Runs the phases of one invocation until there is work for all invocations.
fn control() {
    fault = 0.0;
    settle();
    while state.phase < FIRST_PARALLEL {
        switch state.phase {
            case STEP: { plan_step(); if fault > 0.0 { _ = fails(); } }
            case CHOOSE: { choose_height_field(); }
            case READ_HEIGHT_FIELD: { plan_height_field(); }
            case TRY: { plan_try(); }
            case AIM: { plan_aim(); }
            case SEARCH: { plan_search(); }
            case AFTER_STEP: { plan_after_step(); }
            case ENTER_AIR: { plan_air(); }
            case BOUNDS_DONE: { written_back(); }
            default: {
                if state.status == STATUS_RUNNING { state.status = STATUS_DONE; }
                state.resume = FINISH;
                state.phase = IDLE;
            }
        }
    }
}
