// Results of a step at the cells, and their sums; twin of scheme/contact_integrals.rs and of Scheme::apply.

// Height of the parabola's vertex above the column if it lies in the cell, otherwise 0.
fn peak_rise(d: Difference) -> f32 {
    let inside = d.bend < 0.0 && abs(d.mean) <= -0.5 * d.bend * (1.0 + 1e-6);
    return select(0.0, -0.5 * d.mean * d.mean / d.bend, inside);
}

// Depth at the vertex of the parabolas through a column and its neighbours.
fn top(line: u32, depths: u32) -> f32 {
    let depth = column_value(depths, line);
    let along = difference(column_value(depths, line - across()), depth, column_value(depths, line + across()));
    let sideways = difference(column_value(depths, line - 1u), depth, column_value(depths, line + 1u));
    return depth + peak_rise(along) + peak_rise(sideways);
}

// Share of a cell in contact, averaged over the step.
fn mean_share(line: u32) -> f32 {
    let end = end_cell(line).share;
    return select(0.5 * (start_cell(line).share + end), end, setup.grinds == 0u);
}

// Dose gained by a cell in the step: from the mean rate of both ends, or from the rate at the middle of a whole step.
fn dose_gain(line: u32, start: Cell, end: Cell, middle: Pose) -> f32 {
    if setup.sands == 0u {
        return 0.0;
    }
    let lane = lane_here(line, middle);
    let dt = state.dt;
    let at_end = sanded(lane, wet_depth(end), column_value(PRESSURE_END, line)) * end.share;
    if setup.grinds == 0u {
        return dt * at_end;
    }
    return 0.5 * dt * (sanded(lane, wet_depth(start), column_value(PRESSURE_START, line)) * start.share + at_end);
}

// Completes a cell's results and adds them to the sums of the step.
fn complete(line: u32, middle: Pose) {
    let start = start_cell(line);
    let end = end_cell(line);
    set_column(DOSE_GAIN, line, 0.0);
    if start.share + end.share == 0.0 {
        return;
    }
    let voxel = setup.voxel;
    let whole = setup.grinds == 0u;
    let gain = dose_gain(line, start, end, middle);
    set_column(DOSE_GAIN, line, gain);
    let ratio = area_ratio(line);
    let cell_area = voxel * voxel;
    let facing = cell_area * approach_share(line, middle.approach);
    let load = column_value(MEAN_LOAD, line);
    let recession = column_value(RECESSION, line);
    totals[SUM_FORCE] += load * facing;
    totals[SUM_LOAD] += load * cell_area * ratio;
    totals[SUM_AREA] += select(0.5 * (start.area + end.area), end.area, whole) * facing;
    totals[SUM_VOLUME] += recession * voxel * cell_area * ratio;
    totals[SUM_COATING] += min(gain, max(1.0 - column_value(DOSE, line), 0.0)) * setup.coating * cell_area * ratio;
    complete_maxima(line, middle, ratio, recession);
    if whole {
        add_pressure(line, end, end_array(END_DEPTH), column_value(PRESSURE_END, line));
    } else {
        add_pressure(line, start, start_array(END_DEPTH), column_value(PRESSURE_START, line));
    }
}

// Updates the maximum pressure: `pressure` belongs to the cell's mean depth, and the vertex may be deeper.
fn add_pressure(line: u32, cell: Cell, depths: u32, pressure: f32) {
    if cell.share > 0.0 {
        let peak = max(top(line, depths) / wet_depth(cell), 1.0);
        maxima[MAX_PRESSURE] = max(maxima[MAX_PRESSURE], pressure * peak);
    }
}

fn complete_maxima(line: u32, middle: Pose, ratio: f32, recession: f32) {
    let at = local_point(line, middle);
    maxima[MAX_X] = max(maxima[MAX_X], at.x);
    maxima[MAX_Y] = max(maxima[MAX_Y], at.y);
    maxima[MAX_LOW_X] = max(maxima[MAX_LOW_X], -at.x);
    maxima[MAX_LOW_Y] = max(maxima[MAX_LOW_Y], -at.y);
    maxima[MAX_RECESSION] = max(maxima[MAX_RECESSION], recession);
    if recession != 0.0 {
        maxima[MAX_RECEDED] = max(maxima[MAX_RECEDED], column_value(SUNK, line) / ratio + recession);
    }
}

// Sums over the cells under one tool cell, intensive quantities as means over its contact; twin of CellSums.
fn sum_cell(cell: u32, middle: Pose) {
    let voxel = setup.voxel;
    let dt = state.dt;
    var sums = array<f32, 7>();
    let region = state.region;
    for (var n = 0u; n < region_count(region); n++) {
        let line = region_line(region, n);
        let share = mean_share(line);
        if share == 0.0 {
            continue;
        }
        let at = local_point(line, middle);
        let weight = max(1.0 - abs(tool_cell_place(at) - f32(cell)), 0.0);
        if weight == 0.0 {
            continue;
        }
        let surface = voxel * voxel * area_ratio(line);
        let rate = column_value(RECESSION, line) * voxel / dt;
        let dose = column_value(DOSE_GAIN, line) / dt;
        sums[0] += weight * share;
        sums[1] += weight * column_value(MEAN_LOAD, line);
        sums[2] += weight * share * slip_speed(at);
        sums[3] += weight * rate;
        sums[4] += weight * dose;
        sums[5] += weight * rate * surface;
        sums[6] += weight * dose * surface * setup.coating;
    }
    let per_share = select(0.0, 1.0 / sums[0], sums[0] > 0.0);
    for (var n = 0u; n < 7u; n++) {
        set_value(CELL_SUMS_AT + n * TOOL_CELLS + cell, sums[n] * select(1.0, per_share, n >= 1u && n <= 4u));
    }
}

// Applies the step to a cell, and updates its end for a next step that starts from it.
fn apply(line: u32) {
    let start = start_cell(line);
    let end = end_cell(line);
    if start.share + end.share == 0.0 {
        return;
    }
    let recession = column_value(RECESSION, line);
    set_column(REMOVED, line, column_value(REMOVED, line) + recession * setup.voxel);
    set_column(SUNK, line, column_value(SUNK, line) + recession * area_ratio(line));
    set_column(DOSE, line, column_value(DOSE, line) + column_value(DOSE_GAIN, line));
    if setup.grinds == 1u {
        let side = end_array(END_DEPTH);
        let left = end.mean - recession;
        // The height of a cell that the tool's border crosses is a mean of groove and side face.
        let cover = select(1.0, end.cover, end.share > 0.0);
        set_column(side, line, column_value(side, line) - recession / cover);
        set_column(end_array(END_MEAN), line, max(left, 0.0));
        if left <= 0.0 {
            set_column(end_array(END_SHARE), line, 0.0);
            set_column(end_array(END_AREA), line, 0.0);
        }
    }
}
