// The balance of forces in a step, the one that is foreseen, and the longest step for it; twin of control.rs and
// step/guide.rs.

// Sets the balance of a step of `dt` [s] with the given damping and mass.
fn set_balance(dt: f32, damping: f32, mass: f32) {
    state.dt = dt;
    state.damping = damping;
    state.mass = mass;
    state.start_force = force_reading(state.end_force);
    state.end_weight = 1.0;
    // A contact that has just begun has no stiffness, so the decay of the force is unknown.
    if setup.grinds == 1u && damping > 0.0 && state.end_stiffness > 0.0 {
        let weights = decay_weights(dt * state.end_stiffness / (damping + mass / dt));
        state.end_weight = weights.y / weights.x;
    }
}

// Speed in the balance that is foreseen: that of a spring on a surface that moves as in the last step; under an ideal
// controller, that of the last step.
fn foreseen_speed() -> f32 {
    let dt = state.dt;
    if dt == 0.0 {
        return 0.0;
    }
    if state.damping + state.mass == 0.0 {
        return state.speed;
    }
    let spring = state.end_weight * state.end_stiffness * dt;
    let resistance = state.damping + state.mass / dt + spring;
    let excess = state.start_force - setup.force_setpoint + state.mass / dt * state.speed;
    return (excess + spring * state.surface_speed) / resistance;
}

// Speed at the travel under evaluation; 0 for a static balance.
fn tried_speed() -> f32 {
    return select(0.0, (state.guess - from_travel()) / state.dt, state.dt > 0.0);
}

// Force in excess of the controller's law [N].
fn excess_force(force: f32) -> f32 {
    let dt = state.dt;
    let over = force - setup.force_setpoint;
    if dt == 0.0 {
        return over;
    }
    let speed = tried_speed();
    let mean = state.start_force + state.end_weight * (force - state.start_force) - setup.force_setpoint;
    return mean - state.damping * speed - state.mass * (speed - state.speed) / dt;
}

// True if the balance is sure to change more than is allowed, seen from a speed at which the force read by the
// controller is in excess by `doubt` [N]: force, damping and inertia all grow with the depth, so each of them is at most
// as far from its value in the balance.
fn is_too_fast(speed: f32, force: f32, doubt: f32) -> bool {
    if state.dt <= period() {
        return false;
    }
    let inertial = abs(state.mass * (speed - state.speed) / state.dt);
    let change = abs(force - state.start_force);
    return inertial - doubt > INERTIA * setup.force_setpoint
        || change - doubt / state.end_weight > FORCE_JUMP * setup.force_setpoint;
}

// The longest step up to `longest` [s] in which an admittance controller is not foreseen to move too fast.
fn foreseen_step(longest: f32) -> f32 {
    var dt = longest;
    while dt > period() {
        set_balance(dt, setup.damping, setup.mass);
        let speed = foreseen_speed();
        let sinking = dt * (state.surface_speed - speed);
        if !is_too_fast(speed, state.start_force + state.end_stiffness * sinking, 0.0) {
            break;
        }
        dt = shorter_step(dt);
    }
    return dt;
}

// The step to be tried after one of `dt` [s] in which the controller moves too fast.
fn shorter_step(dt: f32) -> f32 {
    return max(0.25 * dt, period());
}
