// First part of each phase, column by column; no invocation reads values that another writes in this part.

fn first_part(phase: u32) {
    switch phase {
        case READ: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { read_column(n); } }
        case BEGIN: { depths(start_array(END_DEPTH), kept_pose(POSE_START)); }
        case EVALUATE: { depths(end_array(END_DEPTH), kept_pose(POSE_END)); }
        case COMPLETE: { complete_lines(); }
        case APPLY: { apply_lines(); }
        case AIR: { for (var n = lane_id; n < 7u * TOOL_CELLS; n += WORKGROUP_SIZE) { set_value(CELL_SUMS_AT + n, 0.0); } }
        case BOUNDS: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { note_receded(n); } }
        case BRICKS: {
            let counts = tile_counts();
            for (var n = lane_id; n < counts.x * counts.y; n += WORKGROUP_SIZE) {
                set_column(DOSE_GAIN, n, select(0.0, 1.0, own_bricks(n, true)));
            }
        }
        case COPY: {
            let new_values = (state.own_bricks - state.filled_bricks) * run.planes * BRICK_VOXELS;
            for (var n = lane_id; n < new_values; n += WORKGROUP_SIZE) { fill_own(n); }
        }
        case RAISE: { raise_lines(); }
        case SLOPES: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { set_slope(n); } }
        case FAR_LAYER: { find_renewed(); }
        default: {}
    }
}

fn depths(array_id: u32, pose: Pose) {
    let region = grown(state.region);
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        let line = region_line(region, n);
        set_column(array_id, line, depth_without_side_faces(line, region, pose));
    }
}

fn complete_lines() {
    let region = state.region;
    let middle = kept_pose(POSE_MIDDLE);
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        complete(region_line(region, n), middle);
    }
}

fn apply_lines() {
    let region = state.region;
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        apply(region_line(region, n));
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

// Computes the new distances of a layer; they are written in the second part, once all are known.
fn find_renewed() {
    let layer = i32(state.layer);
    for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) {
        if is_changed(n) {
            set_column(RECESSION, n, renewed(n, layer, 1));
            set_column(MEAN_LOAD, n, renewed(n, layer, -1));
        }
    }
}
