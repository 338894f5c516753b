// One step of the contact over the cells of the region, distributed over the invocations; twin of scheme/grinding.rs
// and scheme/sanding.rs.


// True if a column is in the region that was measured at the start of the step.
fn has_start(line: u32) -> bool {
    let region = state.start_region;
    let at = vec2u(line / across(), line % across());
    return setup.grinds == 1u && all(at >= region.xy) && all(at < region.xy + region.zw);
}

// Cell at one end of the step, from the arrays that begin at `depths`.
fn kept_cell(line: u32, depths: u32) -> Cell {
    let mean = column_value(depths + (END_MEAN - END_DEPTH), line);
    let share = column_value(depths + (END_SHARE - END_DEPTH), line);
    let area = column_value(depths + (END_AREA - END_DEPTH), line);
    return Cell(mean, share, area, column_value(depths + (END_COVER - END_DEPTH), line));
}

fn start_cell(line: u32) -> Cell {
    if !has_start(line) {
        return Cell(0.0, 0.0, 0.0, 0.0);
    }
    return kept_cell(line, start_array(END_DEPTH));
}

fn end_cell(line: u32) -> Cell {
    return kept_cell(line, end_array(END_DEPTH));
}

// Mean depth over the share in contact.
fn wet_depth(cell: Cell) -> f32 {
    return select(0.0, cell.mean / cell.share, cell.share > 0.0);
}

fn on_border(line: u32, region: vec4u) -> bool {
    let at = vec2u(line / across(), line % across()) - region.xy;
    return at.x == 0u || at.y == 0u || at.x + 1u == region.z || at.y + 1u == region.w;
}

// Measures a cell at one end of the step and stores it in the arrays that begin at `depths`.
fn measure(line: u32, depths: u32, pose: Pose, sweep: vec3f) {
    let cell = cell_at(line, depths, pose, sweep);
    set_column(depths + (END_MEAN - END_DEPTH), line, cell.mean);
    set_column(depths + (END_SHARE - END_DEPTH), line, cell.share);
    set_column(depths + (END_AREA - END_DEPTH), line, cell.area);
    set_column(depths + (END_COVER - END_DEPTH), line, cell.cover);
    if cell.share > 0.0 && on_border(line, state.region) {
        maxima[MAX_BORDER] = 1.0;
    }
}

// Evaluates one cell's force at the end of the step and its dependence on the travel.
fn respond(line: u32, pose: Pose, middle: Pose) {
    measure(line, end_array(END_DEPTH), pose, state.sweep.xyz);
    let depth = column_value(end_array(END_DEPTH), line);
    if depth > maxima[MAX_DEPTH] && cover(line, local_point(line, pose), pose, vec3f(0.0)).share > 0.0 {
        maxima[MAX_DEPTH] = depth;
    }
    let start = start_cell(line);
    let end = end_cell(line);
    set_column(RECESSION, line, 0.0);
    set_column(MEAN_LOAD, line, 0.0);
    if start.share + end.share > 0.0 {
        if setup.grinds == 0u {
            press_whole(line, end, pose, middle);
        } else {
            relax(line, start, end, pose, middle);
        }
    }
}

fn lane_here(line: u32, middle: Pose) -> Lane {
    var lane = lane_at(line, middle);
    lane.depth_laplacian = depth_laplacian(line, end_array(END_DEPTH));
    if setup.grinds == 0u {
        lane.slip_speed = swept_slip_speed(line, middle, end_cell(line));
    }
    return lane;
}

// Mean slip speed at a cell while the tool is over it, weighted with its depth, for a step evaluated at its middle.
fn swept_slip_speed(line: u32, middle: Pose, cell: Cell) -> f32 {
    let at = local_point(line, middle);
    let sweep = state.sweep.xyz;
    let way = vec3f(dot(middle.x, sweep), dot(middle.y, sweep), dot(middle.z, sweep));
    let lag = cover(line, at, middle, sweep).lag;
    let apart = HALF_GAUSS * (1.0 - 2.0 * abs(lag));
    let sinks = sinking(middle, sweep) * apart * cell.share;
    let deeper = clamp(sinks / cell.mean, -1.0, 1.0);
    return 0.5 * ((1.0 - deeper) * slip_speed(at - (lag - apart) * way) + (1.0 + deeper) * slip_speed(at - (lag + apart) * way));
}

// Adds the force of a cell for a step evaluated at its middle.
fn press_whole(line: u32, end: Cell, pose: Pose, middle: Pose) {
    let voxel = setup.voxel;
    let depth = wet_depth(end);
    let pressure = pressed(lane_here(line, middle), depth, 0.0);
    let load = pressure * end.share;
    let facing = voxel * voxel * approach_share(line, pose.approach);
    set_column(PRESSURE_START, line, pressure);
    set_column(PRESSURE_END, line, pressure);
    set_column(MEAN_LOAD, line, load);
    totals[SUM_FORCE] += load * facing;
    totals[SUM_STIFFNESS] += load / depth * facing;
}

// Integrates a cell over the step and adds its force.
fn relax(line: u32, start: Cell, end: Cell, pose: Pose, middle: Pose) {
    let voxel = setup.voxel;
    let lane = lane_here(line, middle);
    let depths = vec2f(wet_depth(start), wet_depth(end));
    let depth_rate = select(0.0, (depths.y - depths.x) * voxel / state.dt, state.dt > 0.0);
    let flat_here = stays_flat(line);
    var looks = look_at_ends(lane, depths, receding(line, start, end, flat_here), depth_rate);
    looks.bulge = select(-1.0, state.bulge, flat_here);
    looks.shares = vec2f(start.share, end.share);
    let relaxation = relaxation_of(lane, looks, depth_rate);
    looks = with_means(looks, relaxation);
    var relaxed = integrate(looks, end, relaxation);
    if setup.bends == 1u && state.dt > 0.0 {
        looks.depths.z = left_of(looks.depths.y, end.share, relaxed.recession);
        looks.pressures.z = pressed(lane, looks.depths.z, depth_rate);
        looks.rates.z = ground(lane, looks.depths.z, depth_rate);
        relaxed = bend(looks, relaxed);
    }
    set_column(RECESSION, line, relaxed.recession);
    set_column(PRESSURE_START, line, looks.pressures.x);
    set_column(PRESSURE_END, line, looks.pressures.y);
    set_column(MEAN_LOAD, line, relaxed.mean_load);
    let facing = voxel * voxel * approach_share(line, pose.approach);
    totals[SUM_FORCE] += relaxed.end_load * facing;
    totals[SUM_STIFFNESS] += relaxed.stiffness * facing;
}
