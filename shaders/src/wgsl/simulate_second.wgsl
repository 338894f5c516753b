// Second part of each trial's phase; host file: simulate.rs.

@compute @workgroup_size(WORKGROUP_SIZE)
fn simulate_second(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane_index: u32) {
    trial = group.x;
    lane_id = lane_index;
    setup = setups[trial];
    state = states[trial];
    take_up_sums();
    second_part(state.phase);
    keep_sums();
}
