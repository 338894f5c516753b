// Integration of a cell over a step, with a correction for laws that are nonlinear in the depth; twin of
// scheme/exponential_integrator.rs and scheme/nonlinear_correction.rs.



// Result of a step at one cell.
struct Relaxed {
    // [voxels]
    recession: f32,
    // Pressure times share in contact: at the end of the step after recession, and as a mean over the step [Pa].
    end_load: f32,
    mean_load: f32,
    // -dp/dz [Pa / voxel]
    stiffness: f32,
    // Relaxation in the step, lambda dt.
    relaxation: f32,
}

// The law at the start of a step (x), at its end without recession (y) and at its end with recession (z).
struct Looks {
    // [voxels]
    depths: vec3f,
    // [Pa]
    pressures: vec3f,
    // [m/s]
    rates: vec3f,
    // Depths that enter the recession law at start and end [voxels], negative in the air.
    own: vec2f,
    // Shares in contact at start and end, and shares of the cell that recede.
    shares: vec2f,
    covers: vec2f,
    // Bulge: excess of the depth in the middle of the step over the mean of both ends [voxels]; negative where the work
    // is not flat.
    bulge: f32,
}

// Evaluates the law at both ends of the step, pressures at the mean `depths` [voxels]. `own` holds the depths that
// enter the recession law (x, y) and the shares that recede (z, w).
fn look_at_ends(lane: Lane, depths: vec2f, own: vec4f, depth_rate: f32) -> Looks {
    let pressures = vec2f(pressed(lane, depths.x, depth_rate), pressed(lane, depths.y, depth_rate));
    let rates = vec2f(ground(lane, own.x, depth_rate), ground(lane, own.y, depth_rate));
    return Looks(vec3f(depths, 0.0), vec3f(pressures, 0.0), vec3f(rates, 0.0), own.xy, vec2f(0.0), own.zw, -1.0);
}

// Slope of the recession speed over the depth at the deeper end [1/s].
fn relaxation_of(lane: Lane, looks: Looks, depth_rate: f32) -> f32 {
    let own = max(looks.own.x, looks.own.y);
    let steeper = ground(lane, own * (1.0 + PROBE), depth_rate) - select(looks.rates.y, looks.rates.x, looks.own.x > looks.own.y);
    return select(0.0, max(steeper / (PROBE * own * setup.voxel), 0.0), own > 0.0);
}

// Integrates a cell over the step with the law linearised at its ends; `relaxation`: slope of the law [1/s].
fn integrate(looks: Looks, end: Cell, relaxation: f32) -> Relaxed {
    let dt = state.dt;
    let depth = max(looks.depths.x, looks.depths.y);
    let pressure = select(looks.pressures.y, looks.pressures.x, looks.depths.x > looks.depths.y);
    let weights = decay_weights(relaxation * dt);
    let rates = looks.rates.xy * looks.covers;
    var recession = dt * (rates.x * weights.x + (rates.y - rates.x) * weights.y) / setup.voxel;
    var mean_recession = dt * (rates.x * weights.y + (rates.y - rates.x) * weights.z) / setup.voxel;
    if rates.x > 0.0 && rates.y > 0.0 {
        recession += max(looks.bulge, 0.0) * bulge_gain(relaxation * dt) * looks.covers.y;
    }
    if crosses(looks) && relaxation > 0.0 {
        let crossed = cross_threshold(looks, relaxation);
        recession = select(recession, crossed.x, crossed.z > 0.0);
        mean_recession = select(mean_recession, crossed.y, crossed.z > 0.0);
    }
    let loads = looks.pressures.xy * looks.shares;
    let left = select(0.0, max(1.0 - recession / end.mean, 0.0), end.mean > 0.0);
    let stiffness = select(0.0, pressure / depth, depth > 0.0);
    let mean_load = max(0.5 * (loads.x + loads.y) - stiffness * mean_recession, 0.0);
    let answer = stiffness * end.share * (1.0 - relaxation * dt * weights.y);
    return Relaxed(recession, loads.y * left, mean_load, answer, relaxation * dt);
}

// Mean depth over the share in contact after a recession [voxels].
fn left_of(depth: f32, share: f32, recession: f32) -> f32 {
    return select(0.0, max(depth - recession / share, 0.0), share > 0.0);
}

// Slope between two points; `otherwise` if they are too close.
fn slope_between(a: vec2f, b: vec2f, otherwise: f32) -> f32 {
    return select(otherwise, (b.y - a.y) / (b.x - a.x), abs(b.x - a.x) > APART * max(a.x, b.x));
}

// Corrects a cell whose law is nonlinear, by the law at the depth at the end of the step.
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
