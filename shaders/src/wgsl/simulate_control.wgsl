// Choice of each trial's next phase, by one invocation per trial; host file: simulate.rs.

@compute @workgroup_size(WORKGROUP_SIZE)
fn simulate_control(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane_index: u32) {
    trial = group.x;
    lane_id = lane_index;
    setup = setups[trial];
    state = states[trial];
    if lane_id == 0u {
        control();
        states[trial] = state;
    }
}
