// Decisions after the phases of write-back.

fn settle_bounds() {
    let receded = reduced(SUMS + MAX_ROW) > -FAR;
    state.changed = vec4u(0u);
    if receded {
        let low = vec2f(-reduced(SUMS + MAX_LOW_ROW), -reduced(SUMS + MAX_LOW_PLACE));
        let first = vec2u(max(low - 2.0, vec2f(0.0)));
        let last = vec2f(vec2u(state.window_size[0], across()) - 1u);
        let end = vec2u(min(vec2f(reduced(SUMS + MAX_ROW), reduced(SUMS + MAX_PLACE)) + 2.0, last)) + 1u;
        state.changed = vec4u(first, end - first);
    }
    state.phase = BRICKS;
    if !receded && reduced(SUMS + MAX_DOSED) <= 0.0 {
        written_back();
    }
}

// Marks the copied bricks as filled; if spare bricks are missing, pauses until the host has allocated more.
fn settle_copy() {
    state.filled_bricks = state.own_bricks;
    state.phase = RAISE;
    if state.needed > setup.spare_bricks {
        pause(STATUS_NEEDS_BRICKS, BRICKS);
    }
}

fn settle_far() {
    state.layer += 1u;
    if state.layer > state.layers {
        written_back();
    }
}
