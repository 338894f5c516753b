// A square integrated over a step, and put right where its law is no straight line in the depth; twin of step/relax.rs and step/bend.rs.

// Relative change of depth over which the slope of the recession is taken.
const PROBE: f32 = 1e-3;

// Relative difference of two depths from which a slope is taken between them.
const APART: f32 = 1e-5;

// What a step does to a square.
struct Relaxed {
    // [voxels]
    recession: f32,
    // Pressure times wet share at the end after all, and as a mean over the step [Pa].
    end_load: f32,
    mean_load: f32,
    // -dp/dz [Pa / voxel]
    stiffness: f32,
    // Relaxation in the step.
    relaxation: f32,
}

// The law at the start of a step (x), at its end without recession (y) and where it ends after all (z).
struct Looks {
    // [voxels]
    depths: vec3f,
    // [Pa]
    pressures: vec3f,
    // [m/s]
    rates: vec3f,
    // Wet shares at start and end.
    shares: vec2f,
}

// Looks at the law at both ends of the step, at depths [voxels].
fn look_at_ends(lane: Lane, depths: vec2f, shares: vec2f, depth_rate: f32) -> Looks {
    let a = ground(lane, depths.x, depth_rate);
    let b = ground(lane, depths.y, depth_rate);
    return Looks(vec3f(depths, 0.0), vec3f(a.x, b.x, 0.0), vec3f(a.y, b.y, 0.0), shares);
}

// Integrates a square over the step with the law straight from its ends on.
fn integrate(lane: Lane, looks: Looks, end: Square, depth_rate: f32) -> Relaxed {
    let dt = state.dt;
    let depth = max(looks.depths.x, looks.depths.y);
    let is_start = looks.depths.x > looks.depths.y;
    let deeper = select(vec2f(looks.pressures.y, looks.rates.y), vec2f(looks.pressures.x, looks.rates.x), is_start);
    let probe = ground(lane, depth * (1.0 + PROBE), depth_rate);
    let relaxation = max((probe.y - deeper.y) / (PROBE * depth * setup.voxel), 0.0);
    let weights = decay_weights(relaxation * dt);
    let rates = looks.rates.xy * looks.shares;
    let recession = dt * (rates.x * weights.x + (rates.y - rates.x) * weights.y) / setup.voxel;
    let loads = looks.pressures.xy * looks.shares;
    let left = select(0.0, max(1.0 - recession / end.mean, 0.0), end.mean > 0.0);
    let mean_recession = dt * (rates.x * weights.y + (rates.y - rates.x) * weights.z) / setup.voxel;
    let stiffness = deeper.x / depth;
    let mean_load = max(0.5 * (loads.x + loads.y) - stiffness * mean_recession, 0.0);
    let answer = stiffness * end.share * (1.0 - relaxation * dt * weights.y);
    return Relaxed(recession, loads.y * left, mean_load, answer, relaxation * dt);
}

// Mean depth over the wet share that a recession leaves [voxels].
fn left_of(depth: f32, share: f32, recession: f32) -> f32 {
    return select(0.0, max(depth - recession / share, 0.0), share > 0.0);
}

// Slope between two points, or another where they are too near each other.
fn slope_between(a: vec2f, b: vec2f, otherwise: f32) -> f32 {
    return select(otherwise, (b.y - a.y) / (b.x - a.x), abs(b.x - a.x) > APART * max(a.x, b.x));
}

// Puts a square right whose law bends.
fn bend(looks: Looks, straight: Relaxed) -> Relaxed {
    let voxel = setup.voxel;
    let dt = state.dt;
    let known = straight.relaxation / dt;
    if looks.shares.y <= 0.0 {
        return straight;
    }
    let depths = looks.depths;
    let rates = looks.rates / voxel;
    let slope = max(slope_between(vec2f(depths.x, rates.x), vec2f(depths.z, rates.z), known), 0.0);
    let weights = decay_weights(slope * dt);
    let before = rates.x * looks.shares.x;
    let more = (rates.z + slope * (depths.y - depths.z)) * looks.shares.y - before;
    let recession = dt * (before * weights.x + more * weights.y);
    let pressures = looks.pressures;
    let stiffness = slope_between(vec2f(depths.z, pressures.z), vec2f(depths.y, pressures.y), pressures.y / depths.y);
    let depth = left_of(depths.y, looks.shares.y, recession);
    let load = max(pressures.z + stiffness * (depth - depths.z), 0.0) * looks.shares.y;
    let load_before = pressures.x * looks.shares.x;
    let mean_before = depths.x * looks.shares.x;
    let mean = 0.5 * (mean_before + depths.y * looks.shares.y) - dt * (before * weights.y + more * weights.z);
    let along = slope_between(vec2f(mean_before, load_before), vec2f(depth * looks.shares.y, load), stiffness);
    let mean_load = max(load_before + along * (mean - mean_before), 0.0);
    let answer = stiffness * looks.shares.y * (1.0 - slope * dt * weights.y);
    return Relaxed(recession, load, mean_load, answer, slope * dt);
}
