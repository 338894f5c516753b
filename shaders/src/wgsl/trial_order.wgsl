// The order of the phases.

// What follows the parallel part that has been done.
fn settle() {
    switch states[trial].phase {
        case READ: { states[trial].has_sheet = 1u; look(); states[trial].phase = TRY; }
        case BEGIN: {
            states[trial].border = max(reduced(SUMS + MAX_BORDER), 0.0);
            states[trial].phase = SEARCH;
            _ = fails();
        }
        case EVALUATE: { settle_evaluation(); }
        case COMPLETE: { settle_complete(); }
        case APPLY: { settle_apply(); }
        case BEND: { states[trial].bent = 0.0; states[trial].phase = AFTER_STEP; }
        case AIR: { advance_clock(); states[trial].phase = STEP; _ = fails(); }
        case BOUNDS: { settle_bounds(); }
        case BRICKS: { states[trial].phase = COPY; }
        case COPY: { settle_copy(); }
        case RAISE: { states[trial].phase = select(SLOPES, BOUNDS_DONE, states[trial].changed.z == 0u); }
        case SLOPES: {
            states[trial].layers = u32(max(reduced(SUMS + MAX_REACH), 0.0));
            states[trial].layer = 1u;
            states[trial].phase = FAR_LAYER;
        }
        case FAR_LAYER: { settle_far(); }
        default: { if states[trial].status == STATUS_RUNNING { states[trial].phase = states[trial].resume; } }
    }
}

// Decides until there is work for all invocations again.
fn control() {
    fault = 0.0;
    settle();
    while states[trial].phase < FIRST_PARALLEL {
        switch states[trial].phase {
            case STEP: { plan_step(); if fault > 0.0 { _ = fails(); } }
            case CHOOSE: { choose_sheet(); }
            case READ_SHEET: { plan_sheet(); }
            case TRY: { plan_try(); }
            case AIM: { plan_aim(); }
            case SEARCH: { plan_search(); }
            case AFTER_STEP: { plan_after_step(); }
            case ENTER_AIR: { plan_air(); }
            case BOUNDS_DONE: { written_back(); }
            default: {
                if states[trial].status == STATUS_RUNNING { states[trial].status = STATUS_DONE; }
                states[trial].resume = FINISH;
                states[trial].phase = IDLE;
            }
        }
    }
}
