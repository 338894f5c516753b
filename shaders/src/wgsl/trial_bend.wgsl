// Laws that are not straight lines in the depth; twin of step/bend.rs.

// Relative change of depth over which the slope of the recession is taken.
const PROBE: f32 = 1e-3;

// Relative difference of two depths from which a slope is taken between them.
const APART: f32 = 1e-5;

// What a step does to a square.
struct Relaxed {
    // [voxels]
    recession: f32,
    // Pressure times wet share at the start and at the end after all, and as a mean over the step [Pa].
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
    let other = select(vec2f(depths.y, rates.y), vec2f(depths.x, rates.x), rates.x > 0.0);
    let slope = max(slope_between(other, vec2f(depths.z, rates.z), known), 0.0);
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
