// First part of each trial's phase, one workgroup per trial; host file: simulate.rs.

@compute @workgroup_size(WORKGROUP_SIZE)
fn simulate_first(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane_index: u32) {
    trial = group.x;
    lane_id = lane_index;
    setup = setups[trial];
    state = states[trial];
    begin_sums();
    first_part(state.phase);
    keep_sums();
}
