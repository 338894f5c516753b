// Search for the travel at which the force meets the controller's law, one evaluation at a time; twin of control.rs.
// Travels are relative to `guess_base`, a multiple of 1/16 voxel, so that f32 resolves them near the balance.

// Tolerance of the force, relative to the setpoint; the sums are accurate to 1e-6.
const FORCE_TOLERANCE: f32 = 2e-5;
// Width of the bracket below which the search ends [voxels].
const RESOLUTION: f32 = 3e-8;
// Marks a missing bound.
const FAR: f32 = 1e30;
// Number of parts per voxel: coarse travels are multiples of 1/SPLIT voxel.
const SPLIT: f32 = 16.0;

// Force reading of the controller [N] for a true `force`.
fn force_reading(force: f32) -> f32 {
    if !HAS_FORCE {
        return force;
    }
    set_value(V_FORCE_READING, force);
    let reading = formula_force();
    note_fault(reading, FAULT_FORCE);
    return reading;
}

// Travel at the start of the step, relative to `guess_base`.
fn from_travel() -> f32 {
    return (state.coarse - state.guess_base) + state.fine;
}

// Starts a search for the balance at the one that is foreseen.
fn start_balance(damping: f32, mass: f32) {
    set_balance(state.dt, damping, mass);
    state.low = -FAR;
    state.high = FAR;
    state.before = FAR;
    state.stride = FIRST_STRIDE / setup.voxel;
    state.nudge = 0.5 * FIRST_NUDGE / setup.voxel;
    state.evaluations = 0u;
    let reach = setup.search_reach;
    let base = state.guess_base;
    let guess = state.fine + foreseen_speed() * state.dt;
    state.guess = clamp(guess, -reach - base, reach - base);
    rebase();
}

// Moves whole sixteenths of a voxel from `guess` to `guess_base`.
fn rebase() {
    let shift = round(state.guess * SPLIT) / SPLIT;
    state.guess_base += shift;
    state.guess -= shift;
    if state.before < FAR {
        state.before -= shift;
    }
    if state.low > -FAR {
        state.low -= shift;
    }
    if state.high < FAR {
        state.high -= shift;
    }
}

// Fall of the excess force since the evaluation before, as a share of what the mean of both slopes promises; that of
// the evaluations before if there is none or it does not fall. A static contact has the slope of its stiffness.
fn slope_scale(excess: f32, slope: f32) -> f32 {
    let promised = 0.5 * (state.before_slope + slope) * (state.guess - state.before);
    let seen = state.before_excess - excess;
    let is_static = state.dt == 0.0;
    let known = select(state.scale, 1.0, is_static);
    let scale = select(known, seen / promised, state.before < FAR && seen * promised > 0.0);
    state.scale = select(scale, state.scale, is_static);
    return scale;
}

// Next travel: Newton's step with a scaled slope, or without stiffness down to the surface and slightly into it; FAR
// without a surface.
fn next_guess(excess: f32, stiffness: f32, depth: f32) -> f32 {
    let dt = state.dt;
    let drag = select(0.0, state.damping / dt + state.mass / (dt * dt), dt > 0.0);
    let guess = state.guess;
    let slope = state.end_weight * stiffness + drag;
    if slope > 0.0 {
        let next = guess + excess / (slope_scale(excess, slope) * slope);
        state.before = guess;
        state.before_excess = excess;
        state.before_slope = slope;
        state.stride *= 4.0;
        return select(max(next, guess - state.stride), next, state.low > -FAR);
    }
    if depth <= -FAR {
        return FAR;
    }
    state.nudge *= 2.0;
    return guess + min(depth, 0.0) * (1.0 + 1e-6) - state.nudge;
}

// Result of a search that ends at `guess` with a force read by the controller [N].
fn ended(reading: f32) -> u32 {
    return select(FOUND, TOO_FAST, is_too_fast(tried_speed(), reading, 0.0));
}

// Updates the search with the force [N], its stiffness [N/voxel] and the depth under the tool [voxels] at `guess`.
// Returns SEARCHING, FOUND, NOTHING or TOO_FAST.
fn search(force: f32, stiffness: f32, depth: f32) -> u32 {
    let reading = force_reading(force);
    let excess = excess_force(reading);
    if abs(excess) <= FORCE_TOLERANCE * setup.force_setpoint {
        return ended(reading);
    }
    if is_too_fast(tried_speed(), reading, abs(excess)) {
        return TOO_FAST;
    }
    if excess > 0.0 {
        state.low = state.guess;
    } else {
        state.high = state.guess;
    }
    let low = state.low;
    let high = state.high;
    let step = next_guess(excess, stiffness, depth);
    if step == FAR {
        return NOTHING;
    }
    let between = (step > low && step < high) || low == -FAR || high == FAR;
    var guess = select(0.5 * (low + high), step, between);
    let least = -setup.search_reach - state.guess_base;
    if is_bad(guess) || guess < least {
        // The first touch of a wide tool is so soft that the step overshoots far below the balance.
        if is_bad(guess) || high <= least {
            return NOTHING;
        }
        guess = least;
    }
    if high - low < RESOLUTION {
        state.guess = low;
        return ended(reading);
    }
    state.guess = guess;
    state.evaluations += 1u;
    if state.evaluations >= EVALUATIONS {
        return ended(reading);
    }
    rebase();
    return SEARCHING;
}
