// The travel at which the force is the one that the controller wants, one evaluation at a time; twin of control.rs.
// Travels are those beyond `guess_base`, a multiple of 1/16 voxel, so that f32 resolves them near the balance.

// Evaluations of the force before the best travel so far is taken.
const EVALUATIONS: u32 = 40u;
// Relative difference between force and setpoint that is good enough; the sums are good to 1e-6.
const FORCE_TOLERANCE: f32 = 2e-5;
// Travels that are not told apart [voxels].
const RESOLUTION: f32 = 3e-8;
// Furthest that the tool is first sent into what it has just touched, and its way into the surface at first [m].
const FIRST_STRIDE: f32 = 5e-6;
const FIRST_NUDGE: f32 = 1e-7;
// Stands for no bound.
const FAR: f32 = 1e30;
// Parts of a voxel by which travels are split.
const SPLIT: f32 = 16.0;

// Force that the controller believes [N].
fn force_reading(force: f32) -> f32 {
    if !HAS_FORCE {
        return force;
    }
    set_value(V_FORCE_READING, force);
    let reading = formula_force();
    note_fault(reading, FAULT_FORCE);
    return reading;
}

// The travel where the step starts, beyond the base of the search.
fn from_travel() -> f32 {
    return (states[trial].coarse - states[trial].guess_base) + states[trial].fine;
}

// Starts a search for the balance with so much damping and mass.
fn start_balance(damping: f32, mass: f32) {
    states[trial].damping = damping;
    states[trial].mass = mass;
    states[trial].low = -FAR;
    states[trial].high = FAR;
    states[trial].stride = FIRST_STRIDE / setups[trial].voxel;
    states[trial].nudge = 0.5 * FIRST_NUDGE / setups[trial].voxel;
    states[trial].evaluations = 0u;
    let reach = setups[trial].search_reach;
    let base = states[trial].guess_base;
    let guess = states[trial].fine + states[trial].speed * states[trial].dt;
    states[trial].guess = clamp(guess, -reach - base, reach - base);
    rebase();
}

// Moves whole sixteenths of a voxel from the travel to its base.
fn rebase() {
    let shift = round(states[trial].guess * SPLIT) / SPLIT;
    states[trial].guess_base += shift;
    states[trial].guess -= shift;
    if states[trial].low > -FAR {
        states[trial].low -= shift;
    }
    if states[trial].high < FAR {
        states[trial].high -= shift;
    }
}

// Force in excess of what the controller lets stand [N].
fn excess_force(force: f32) -> f32 {
    let dt = states[trial].dt;
    let over = force - setups[trial].force_setpoint;
    if dt == 0.0 {
        return over;
    }
    let speed = (states[trial].guess - from_travel()) / dt;
    return over - states[trial].damping * speed - states[trial].mass * (speed - states[trial].speed) / dt;
}

// The next travel by Newton's step, or down to the surface and a little into it; FAR where there is no surface.
fn next_guess(excess: f32, stiffness: f32, depth: f32) -> f32 {
    let dt = states[trial].dt;
    let drag = select(0.0, states[trial].damping / dt + states[trial].mass / (dt * dt), dt > 0.0);
    let guess = states[trial].guess;
    if stiffness + drag > 0.0 {
        let newton = guess + excess / (stiffness + drag);
        states[trial].stride *= 4.0;
        return select(max(newton, guess - states[trial].stride), newton, states[trial].low > -FAR);
    }
    if depth <= -FAR {
        return FAR;
    }
    states[trial].nudge *= 2.0;
    return guess + min(depth, 0.0) * (1.0 + 1e-6) - states[trial].nudge;
}

// Takes up the force [N], its stiffness [N/voxel] and the depth under the tool [voxels] at the guess. Gives SEARCHING,
// FOUND or NOTHING.
fn search(force: f32, stiffness: f32, depth: f32) -> u32 {
    let excess = excess_force(force_reading(force));
    if abs(excess) <= FORCE_TOLERANCE * setups[trial].force_setpoint {
        return FOUND;
    }
    if excess > 0.0 {
        states[trial].low = states[trial].guess;
    } else {
        states[trial].high = states[trial].guess;
    }
    let low = states[trial].low;
    let high = states[trial].high;
    let step = next_guess(excess, stiffness, depth);
    if step == FAR {
        return NOTHING;
    }
    let between = (step > low && step < high) || low == -FAR || high == FAR;
    var guess = select(0.5 * (low + high), step, between);
    let least = -setups[trial].search_reach - states[trial].guess_base;
    if is_bad(guess) || guess < least {
        // The first touch of a wide tool is so soft that Newton's step leads far below the balance.
        if is_bad(guess) || high <= least {
            return NOTHING;
        }
        guess = least;
    }
    if high - low < RESOLUTION {
        states[trial].guess = low;
        return FOUND;
    }
    states[trial].guess = guess;
    states[trial].evaluations += 1u;
    if states[trial].evaluations >= EVALUATIONS {
        return FOUND;
    }
    rebase();
    return SEARCHING;
}

// One sample of an admittance controller (semi-implicit Euler).
fn sample_admittance() {
    let dt = states[trial].dt;
    let mass = setups[trial].mass;
    let over = force_reading(states[trial].end_force) - setups[trial].force_setpoint;
    let speed = (mass * states[trial].speed + dt * over) / (mass + dt * setups[trial].damping);
    states[trial].found_speed = speed;
    states[trial].guess = states[trial].fine + dt * speed;
    rebase();
}
