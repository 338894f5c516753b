// Sums and maxima over the invocations of each trial, in their order; host file: simulate.rs.

@compute @workgroup_size(WORKGROUP_SIZE)
fn simulate_reduce(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane_index: u32) {
    trial = group.x;
    lane_id = lane_index;
    setup.value_first = setups[trial].value_first;
    if lane_id >= REDUCED {
        return;
    }
    var result = value(PARTIALS_AT + lane_id);
    for (var n = 1u; n < WORKGROUP_SIZE; n++) {
        let next = value(PARTIALS_AT + n * REDUCED + lane_id);
        result = select(max(result, next), result + next, lane_id < SUMS);
    }
    set_value(PARTIALS_AT + WORKGROUP_SIZE * REDUCED + lane_id, result);
}
