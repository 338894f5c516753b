// Cells that start or stop receding within a step, and the depths that enter the recession law; twin of
// scheme/threshold.rs and of scheme/contact_state.rs.

// Recession over a step per bulge, for a depth that follows a parabola over time.
fn bulge_gain(x: f32) -> f32 {
    let weights = decay_weights(x);
    return 4.0 * x * (weights.y - 2.0 * weights.z);
}

// True if the depth curves as over flat work.
fn is_flat(line: u32, depths: u32) -> bool {
    let here = column_value(depths, line);
    let along = (column_value(depths, line - across()) - here) + (column_value(depths, line + across()) - here);
    let sideways = (column_value(depths, line - 1u) - here) + (column_value(depths, line + 1u) - here);
    let bend = 1.0 / setup.tool_radius;
    let whole = bend + select(setup.tool_crown, bend, setup.tool == TOOL_SPHERE);
    return abs(along + sideways + whole) <= 0.5 * bend && max(abs(along), abs(sideways)) <= 1.5 * bend;
}

// True if it does so at both ends of the step, and the column is in contact at one end at least.
fn stays_flat(line: u32) -> bool {
    // The slope at the deeper end does not locate the threshold of a nonlinear law.
    if setup.tool == TOOL_PAD || setup.bends == 1u || !has_start(line) {
        return false;
    }
    if max(column_value(start_array(END_DEPTH), line), column_value(end_array(END_DEPTH), line)) <= 0.0 {
        return false;
    }
    return is_flat(line, start_array(END_DEPTH)) && is_flat(line, end_array(END_DEPTH));
}

// Depths that enter the recession law at start and end (x, y), and the shares of the cell that recede (z, w).
fn receding(line: u32, start: Cell, end: Cell, flat_here: bool) -> vec4f {
    if !flat_here {
        return vec4f(wet_depth(start), wet_depth(end), start.share, end.share);
    }
    let depths = vec2u(start_array(END_DEPTH), end_array(END_DEPTH));
    let own = vec2f(column_value(depths.x, line), column_value(depths.y, line));
    let shares = vec2f(start.share, end.share);
    let covers = select(vec2f(0.0), vec2f(start.cover, end.cover), shares > vec2f(0.0));
    // A column in the air takes its cover from the other end of the step.
    return vec4f(own, select(covers, covers.yx, shares == vec2f(0.0) & own < vec2f(0.0)));
}


// Resets a cell without a threshold in its law to the mean depth over its share in contact; `slope`: of the law [1/s].
fn with_means(looks: Looks, slope: f32) -> Looks {
    let voxel = setup.voxel;
    let own = max(looks.own.x, looks.own.y);
    let rate = select(looks.rates.y, looks.rates.x, looks.own.x > looks.own.y);
    if looks.bulge < 0.0 || own <= 0.0 || rate <= 0.0 || own - rate / (slope * voxel) > NO_THRESHOLD * own {
        return looks;
    }
    var means = looks;
    means.bulge = -1.0;
    means.own = looks.depths.xy;
    means.covers = looks.shares;
    let rates = max(vec2f(rate) + slope * voxel * (looks.depths.xy - vec2f(own)), vec2f(0.0));
    means.rates = vec3f(select(vec2f(0.0), rates, looks.shares > vec2f(0.0)), 0.0);
    return means;
}

// True if a cell over flat work recedes at only one end of the step.
fn crosses(looks: Looks) -> bool {
    return looks.bulge >= 0.0 && (looks.rates.x > 0.0) != (looks.rates.y > 0.0);
}

// Part of a step, from its deeper end, in which the depth is less than `above` below that end. Over the step the depth
// changes by `way`, on a parabola with the given bulge.
fn part_above(above: f32, way: f32, bulge: f32) -> f32 {
    let slope = way - 4.0 * bulge;
    let root = sqrt(slope * slope + 16.0 * bulge * above);
    return select((root - slope) / (8.0 * bulge), 2.0 * above / (slope + root), slope > 0.0);
}

// 1 - ln(1 + z)/z
fn late(z: f32) -> f32 {
    let series = z * (0.5 - z * (0.33333334 - z * (0.25 - z * (0.2 - z * 0.16666667))));
    return select(1.0 - op_log(1.0 + z) / z, series, z < 0.1);
}

// Recession, its mean over the step [voxels], and 1, for a cell that crosses the threshold depth of its law and relaxes
// at a rate [1/s]; zeros if it does not cross it.
fn cross_threshold(looks: Looks, relaxation: f32) -> vec3f {
    let begins = looks.rates.y > 0.0;
    let deeper = select(vec3f(looks.own.x, looks.rates.x, looks.covers.x), vec3f(looks.own.y, looks.rates.y, looks.covers.y), begins);
    let way = deeper.x - select(looks.own.y, looks.own.x, begins);
    if way <= 0.0 {
        return vec3f(0.0);
    }
    let above = min(deeper.y / (relaxation * setup.voxel), deeper.x);
    let part = min(part_above(above, way, looks.bulge), 1.0);
    let z = relaxation * state.dt * part;
    let weights = decay_weights(z);
    let bulged = looks.bulge * part * part * bulge_gain(z);
    var recession = above * z * weights.y + bulged;
    var mean = part * above * z * weights.z;
    if !begins {
        recession = above * late(z) + bulged;
        mean = recession * (1.0 - part * (1.0 - late(z)) / 3.0);
    }
    return vec3f(deeper.z * vec2f(recession, mean), 1.0);
}
