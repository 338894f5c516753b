// What follows the phases in which a sheet is written back.

fn settle_bounds() {
    let receded = reduced_maxima[MAX_ROW] > -FAR;
    states[trial].changed = vec4u(0u);
    if receded {
        let low = vec2f(-reduced_maxima[MAX_LOW_ROW], -reduced_maxima[MAX_LOW_PLACE]);
        let first = vec2u(max(low - 2.0, vec2f(0.0)));
        let last = vec2f(vec2u(states[trial].window_size[0], across()) - 1u);
        let end = vec2u(min(vec2f(reduced_maxima[MAX_ROW], reduced_maxima[MAX_PLACE]) + 2.0, last)) + 1u;
        states[trial].changed = vec4u(first, end - first);
    }
    states[trial].phase = BRICKS;
    if !receded && reduced_maxima[MAX_DOSED] <= 0.0 {
        written_back();
    }
}

fn settle_bricks() {
    let wanted = atomicLoad(&own_count);
    states[trial].own_bricks = min(wanted, setups[trial].spare_bricks);
    states[trial].phase = COPY;
}

// What was copied is the trial's own; without room for the rest the host makes some.
fn settle_copy() {
    states[trial].filled_bricks = states[trial].own_bricks;
    states[trial].phase = RAISE;
    if states[trial].needed > setups[trial].spare_bricks {
        pause(STATUS_NEEDS_BRICKS, BRICKS);
    }
}

fn settle_far() {
    states[trial].layer += 1u;
    if states[trial].layer > states[trial].layers {
        written_back();
    }
}
