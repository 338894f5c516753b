// Second dispatch of each phase: it reads what all invocations of the first one wrote.

fn second_part(phase: u32) {
    switch phase {
        case READ, BEND: { take_slopes(phase == BEND); }
        case BEGIN: { begin_lines(); }
        case EVALUATE: { respond_lines(); }
        case COMPLETE: { if HAS_TOOL_CELLS { sum_cell(lane_id, kept_pose(POSE_MIDDLE)); } }
        case APPLY, AIR: { if HAS_TOOL_CELLS { advance_tool_cell(lane_id); } }
        case BRICKS: { if lane_id == 0u { own_all_bricks(); } }
        case SLOPES: { for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) { note_reach(n); } }
        case FAR_LAYER: { write_lines(); }
        default: {}
    }
}

// Computes the slopes of the whole height field, or of the step's region and the columns around it.
fn take_slopes(looked_at: bool) {
    let region = select(vec4u(0u, 0u, state.window_size[0], across()), grown(state.region), looked_at);
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        set_slope(region_line(region, n));
    }
}

fn begin_lines() {
    let region = state.region;
    let start = kept_pose(POSE_START);
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        measure(region_line(region, n), start_array(END_DEPTH), start, vec3f(0.0));
    }
}

fn respond_lines() {
    let region = state.region;
    let end = kept_pose(POSE_END);
    let middle = kept_pose(POSE_MIDDLE);
    for (var n = lane_id; n < region_count(region); n += WORKGROUP_SIZE) {
        respond(region_line(region, n), end, middle);
    }
}

fn note_reach(line: u32) {
    if is_changed(line) {
        maxima[MAX_REACH] = max(maxima[MAX_REACH], f32(reach_of(line)));
    }
}

fn write_lines() {
    let layer = i32(state.layer);
    for (var n = lane_id; n < line_count(); n += WORKGROUP_SIZE) {
        if is_changed(n) {
            write_renewed(n, layer, 1, column_value(RECESSION, n));
            write_renewed(n, layer, -1, column_value(MEAN_LOAD, n));
        }
    }
}
