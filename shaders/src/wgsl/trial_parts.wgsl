// The shares of the phases, line by line.

// First share of a phase: nothing in it reads what it writes.
fn first_part(phase: u32) {
    switch phase {
        case READ: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { read_column(n); } }
        case BEGIN: { depths(start_array(END_DEPTH), kept_pose(POSE_START)); }
        case EVALUATE: { depths(end_array(END_DEPTH), kept_pose(POSE_END)); }
        case COMPLETE: { squares(phase); }
        case APPLY: { squares(phase); }
        case AIR: { for (var n = lane_id; n < 7u * TOOL_CELLS; n += WORKGROUP_SIZE) { set_value(CELL_SUMS_AT + n, 0.0); } }
        case BOUNDS: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { note_receded(n); } }
        case BRICKS: {
            let counts = tile_counts();
            for (var n = lane_id; n < counts.x * counts.y; n += WORKGROUP_SIZE) { own_bricks(n); }
        }
        case COPY: {
            let new_values = (states[trial].own_bricks - states[trial].filled_bricks) * run.planes * BRICK_VOXELS;
            for (var n = lane_id; n < new_values; n += WORKGROUP_SIZE) { fill_own(n); }
        }
        case RAISE: { raise_lines(); }
        case SLOPES: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { set_slope(n); } }
        case FAR_LAYER: { renew_lines(false); }
        default: {}
    }
}

// Second share, after all have done the first.
fn second_part(phase: u32) {
    switch phase {
        case READ: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { set_slope(n); } }
        case BEGIN: { squares(phase); }
        case EVALUATE: { squares(phase); }
        case COMPLETE: { if HAS_TOOL_CELLS { sum_cell(lane_id, kept_pose(POSE_MIDDLE)); } }
        case APPLY: { if HAS_TOOL_CELLS { advance_tool_cell(lane_id); } }
        case AIR: { if HAS_TOOL_CELLS { advance_tool_cell(lane_id); } }
        case BEND: {
            let region = grown(states[trial].region);
            for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) { set_slope(region_line(region, n)); }
        }
        case SLOPES: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { note_reach(n); } }
        case FAR_LAYER: { renew_lines(true); }
        default: {}
    }
}

fn depths(array_id: u32, pose: Pose) {
    let region = grown(states[trial].region);
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        let line = region_line(region, n);
        set_column(array_id, line, measured_depth(line, pose));
    }
}

fn squares(phase: u32) {
    let region = states[trial].region;
    let middle = kept_pose(POSE_MIDDLE);
    let end = kept_pose(select(POSE_END, POSE_START, phase == BEGIN));
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        let line = region_line(region, n);
        switch phase {
            case BEGIN: { measure(line, start_array(END_DEPTH), end, vec3f(0.0)); }
            case EVALUATE: { respond(line, end, middle); }
            case COMPLETE: { complete(line, middle); }
            default: { apply(line); }
        }
    }
}

fn raise_lines() {
    for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) {
        if is_dosed(n) {
            write_near(n, run.dose_plane, column_value(DOSE, n));
        }
        if is_changed(n) {
            raise(n);
            if run.removed_plane != ABSENT {
                write_near(n, run.removed_plane, column_value(REMOVED, n));
            }
        }
    }
}

fn note_reach(line: u32) {
    if is_changed(line) {
        maxima[MAX_REACH] = max(maxima[MAX_REACH], f32(reach_of(line)));
    }
}

// Distances of a layer: all are found before any is written.
fn renew_lines(writes: bool) {
    let layer = i32(states[trial].layer);
    for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) {
        if !is_changed(n) {
            continue;
        }
        if writes {
            write_renewed(n, layer, 1, column_value(RECESSION, n));
            write_renewed(n, layer, -1, column_value(MEAN_LOAD, n));
        } else {
            set_column(RECESSION, n, renewed(n, layer, 1));
            set_column(MEAN_LOAD, n, renewed(n, layer, -1));
        }
    }
}
