// Variables of a cell in contact that formulas may read; twin of physics.rs. SI units.

// Values of a cell, one for each variable of the cells.
struct Lane {
    x: f32,
    y: f32,
    z: f32,
    tool_x: f32,
    tool_y: f32,
    depth: f32,
    depth_rate: f32,
    depth_laplacian: f32,
    slip_speed: f32,
    removed_depth: f32,
    dose: f32,
    coating_removed: f32,
    slope: f32,
    label: f32,
    pressure: f32,
    tool_cell: f32,
}

// Slip speed of the working surface at a point in the tool's frame, relative to the tool's lowest point [m/s].
fn slip_speed(at: vec3f) -> f32 {
    let spin = value(V_SPINDLE_SPEED) * setup.voxel;
    let feed = value(V_FEED_SPEED) * vec3f(value(V_FEED_ALONG), value(V_FEED_ACROSS), 0.0);
    if setup.tool == TOOL_WHEEL {
        return length(spin * vec3f(at.z - setup.drop, 0.0, -at.x) + feed);
    }
    return length(spin * vec3f(-at.y, at.x, 0.0) + feed);
}

// Laplacian of the depth at a column [1/m].
fn depth_laplacian(line: u32, depths: u32) -> f32 {
    let depth = column_value(depths, line);
    let along = difference(column_value(depths, line - across()), depth, column_value(depths, line + across()));
    let sideways = difference(column_value(depths, line - 1u), depth, column_value(depths, line + 1u));
    return (along.bend + sideways.bend) / setup.voxel;
}

// Lane of a cell under the tool at a pose.
fn lane_at(line: u32, pose: Pose) -> Lane {
    let at = local_point(line, pose);
    let voxel = setup.voxel;
    let flat = vec2f(line_place(line));
    let up = f32(state.base) + column_value(WHOLE, line) + (column_value(PART, line) - column_value(SUNK, line));
    let place = from_height_field(vec3f(flat, up)) * voxel;
    let dose = column_value(DOSE, line);
    var lane: Lane;
    lane.x = place.x;
    lane.y = place.y;
    lane.z = place.z;
    lane.tool_x = at.x * voxel;
    lane.tool_y = at.y * voxel;
    lane.slip_speed = slip_speed(at);
    lane.removed_depth = column_value(REMOVED, line);
    lane.dose = dose;
    lane.coating_removed = min(dose, 1.0) * setup.coating;
    lane.slope = slope_against(line, pose.approach);
    lane.label = column_value(LABEL, line);
    lane.tool_cell = tool_cell_place(at);
    return lane;
}

// Depth of a column under the tool at a pose [voxels], less the gap that effects add.
fn measured_depth(line: u32, pose: Pose) -> f32 {
    let depth = tool_depth(local_point(line, pose));
    if !HAS_SHAPE {
        return depth;
    }
    let gap = formula_shape(lane_at(line, pose));
    note_bad(gap, FAULT_SHAPE);
    return depth - gap / setup.voxel;
}

// Records that a formula of a cell gave no finite number.
fn note_bad(result: f32, place: u32) {
    if is_bad(result) {
        maxima[MAX_BAD] = max(maxima[MAX_BAD], f32(place));
    }
}

// Records that a formula of the step gave no finite number.
fn note_fault(result: f32, place: u32) {
    if is_bad(result) {
        fault = max(fault, f32(place));
    }
}

// Pressure [Pa] at a depth [voxels] that changes by `depth_rate` [m/s].
fn pressed(lane: Lane, depth: f32, depth_rate: f32) -> f32 {
    var at = lane;
    at.depth = depth * setup.voxel;
    at.depth_rate = depth_rate;
    let pressure = formula_pressure(at);
    note_bad(pressure, FAULT_PRESSURE);
    return pressure;
}

// Recession speed [m/s] at such a depth; in the air, at depth 0.
fn ground(lane: Lane, depth: f32, depth_rate: f32) -> f32 {
    if setup.grinds == 0u {
        return 0.0;
    }
    var at = lane;
    at.depth = max(depth, 0.0) * setup.voxel;
    at.depth_rate = depth_rate;
    at.pressure = formula_pressure(at);
    note_bad(at.pressure, FAULT_PRESSURE);
    let rate = formula_rate(at);
    note_bad(rate, FAULT_RATE);
    return rate;
}

// Dose per time [1/s] at a depth [voxels] and pressure [Pa].
fn sanded(lane: Lane, depth: f32, pressure: f32) -> f32 {
    if setup.sands == 0u {
        return 0.0;
    }
    var at = lane;
    at.depth = depth * setup.voxel;
    at.pressure = pressure;
    let rate = formula_dose(at);
    note_bad(rate, FAULT_DOSE);
    return rate;
}
