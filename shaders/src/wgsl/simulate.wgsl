// A pass of every trial, one workgroup each: parts that all invocations share, and between them the decisions of one.
// Host file: simulate.rs.

// Sums and greatest values over the workgroup, in the order of its invocations.
fn reduce() {
    if lane_id < SUMS {
        var sum = 0.0;
        for (var n = 0u; n < WORKGROUP_SIZE; n++) { sum += all_totals[n * SUMS + lane_id]; }
        reduced_totals[lane_id] = sum;
    }
    if lane_id < MAXIMA {
        var greatest = all_maxima[lane_id];
        for (var n = 1u; n < WORKGROUP_SIZE; n++) { greatest = max(greatest, all_maxima[n * MAXIMA + lane_id]); }
        reduced_maxima[lane_id] = greatest;
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn simulate(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane_index: u32) {
    trial = group.x;
    lane_id = lane_index;
    for (var tick = 0u; tick < run.ticks; tick++) {
        let phase = states[trial].phase;
        for (var n = 0u; n < SUMS; n++) { totals[n] = 0.0; }
        for (var n = 0u; n < MAXIMA; n++) { maxima[n] = -NONE; }
        if lane_id == 0u {
            atomicStore(&own_count, states[trial].own_bricks);
        }
        workgroupBarrier();
        first_part(phase);
        storageBarrier();
        workgroupBarrier();
        second_part(phase);
        for (var n = 0u; n < SUMS; n++) { all_totals[lane_id * SUMS + n] = totals[n]; }
        for (var n = 0u; n < MAXIMA; n++) { all_maxima[lane_id * MAXIMA + n] = maxima[n]; }
        workgroupBarrier();
        reduce();
        storageBarrier();
        workgroupBarrier();
        if lane_id == 0u {
            control();
        }
        storageBarrier();
        workgroupBarrier();
    }
}
