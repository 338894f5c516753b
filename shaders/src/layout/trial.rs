//! Structs of the simulator.

use bytemuck::{Pod, Zeroable};

use super::SharedType;

shared_struct! {
    /// Constant inputs of a trial.
    TrialSetup {
        /// Brick coordinates of the first index entry [bricks]; the fourth is 0.
        grid_origin: [i32; 4],
        /// Index entries per axis [bricks]; the fourth is the offset of the first entry.
        grid_dims: [u32; 4],
        /// Least and greatest x, then y, of the region that the tool can touch [voxels].
        extent: [f32; 4],
        /// Half length of the whole tool along the feed and across it [voxels].
        whole_extent: [f32; 4],
        /// Distance between voxels [m].
        voxel: f32,
        /// Distance at which φ is truncated [m].
        band_length: f32,
        /// The same [voxels].
        band: f32,
        /// Distance up to which φ carries the zero set [m].
        kept_length: f32,
        /// Infinity, which WGSL cannot express.
        infinity: f32,
        /// First brick in the pool of the asset that the trial shares with others.
        first_brick: u32,
        /// Bricks of that asset; slots from this number on are the trial's own.
        shared_bricks: u32,
        /// First of the trial's own bricks in the pool.
        spare_first: u32,
        /// Number of own bricks allocated to the trial.
        spare_bricks: u32,
        /// Offset in the index of the sources of the trial's own bricks.
        source_first: u32,
        /// Offset of the trial's column arrays.
        column_first: u32,
        /// Number of columns allocated.
        column_lines: u32,
        /// First segment of the path.
        path_first: u32,
        /// Number of segments of the path; the entry after them is its end.
        path_pieces: u32,
        /// First row of the log.
        log_first: u32,
        /// Number of rows of the log, a ring buffer.
        log_rows: u32,
        /// Offset of the trial's values.
        value_first: u32,
        /// Kind of tool.
        tool: u32,
        /// R or s [voxels].
        tool_radius: f32,
        /// Half width of a wheel [voxels].
        tool_half_width: f32,
        /// Curvature of a wheel's rim along the axis [1/voxel].
        tool_crown: f32,
        /// Radius that multiplies the spindle speed to give the rim speed [voxels].
        rim_radius: f32,
        /// Distance from the reference point down to the lowest point [voxels].
        drop: f32,
        /// Kind of controller.
        controller: u32,
        /// M [N s²/voxel].
        mass: f32,
        /// B [N s/voxel].
        damping: f32,
        /// Time between samples [s].
        period: f32,
        /// F_set [N].
        force_setpoint: f32,
        /// Speed of the spindle [rad/s].
        spindle_speed: f32,
        /// Distance of the tool in a step [voxels].
        step_way: f32,
        /// Distance of the tool on a height field [voxels].
        write_back_way: f32,
        /// Search range for the tool's travel above and below its path [voxels].
        search_reach: f32,
        /// Thickness of the coating [m].
        coating: f32,
        /// Longest step [s].
        longest_step: f32,
        /// 1 if an admittance controller is stepped at its period only where its dynamics matter.
        quasi_static: u32,
        /// 1 if the surface recedes.
        grinds: u32,
        /// 1 if pressure or recession may be nonlinear in the depth.
        bends: u32,
        /// 1 if coating is removed.
        sands: u32,
        /// Row of parameters that have one value per pass.
        pass_row: u32,
        /// Steps after which the pass is given up; 0 for never.
        most_steps: u32,
        /// End of the approach: blocks of time.
        approach_blocks: i32,
        /// Its remainder [s].
        approach_rest: f32,
        /// End of the path: blocks of time.
        duration_blocks: i32,
        /// Its remainder [s].
        duration_rest: f32,
        /// Time since the trial's first pass began [s].
        trial_time: f32,
        /// Length of the path [m].
        path_length: f32,
        /// Padding.
        padding_a: u32,
        /// Padding.
        padding_b: u32,
    }
}

shared_struct! {
    /// State of a trial.
    TrialState {
        /// Index of the first line of the window along u and v [voxels].
        window_low: [i32; 4],
        /// Number of lines along u and v.
        window_size: [u32; 4],
        /// Window that the step needs: first lines and numbers of lines.
        wanted: [i32; 4],
        /// First row and column position, and number of rows and columns, of the region that the step evaluates.
        region: [u32; 4],
        /// The same for the measurement at the start of the step.
        start_region: [u32; 4],
        /// The same for the columns whose voxels change when the height field is written back.
        changed: [u32; 4],
        /// Least and greatest x, then y, of the contact in the tool's frame [voxels].
        extent: [f32; 4],
        /// Offset of the tool by the model's effects, in its frame [voxels].
        offset: [f32; 4],
        /// Roll and pitch by the model's effects [rad].
        tilt: [f32; 4],
        /// Sweep of the working surface's border [voxels]; u, v, up.
        sweep: [f32; 4],
        /// Lowest points of the stored poses, in whole voxels; u, v, up.
        wholes: [[i32; 4]; 4],
        /// Their remainders, and the poses' axes and approach axes.
        frames: [[f32; 4]; 20],
        /// Current phase.
        phase: u32,
        /// Phase after the height field is written back.
        then: u32,
        /// Phase to resume once the host has provided memory.
        resume: u32,
        /// Status of the trial; the reason why it stopped.
        status: u32,
        /// The hook at fault.
        detail: u32,
        /// Number of columns or bricks for which memory is needed.
        needed: u32,
        /// Steps taken.
        steps: u32,
        /// Number of the trial's own bricks.
        own_bricks: u32,
        /// Number of those that have been filled.
        filled_bricks: u32,
        /// Layer whose distances are reinitialised.
        layer: u32,
        /// Number of layers to reinitialise.
        layers: u32,
        /// 1 if a height field was read.
        has_height_field: u32,
        /// Axis of the field along which columns run.
        axis: u32,
        /// Which way is up: 1 or -1.
        up: i32,
        /// Height from which the columns' heights are measured [voxels].
        base: i32,
        /// Lowest voxel that is read.
        least: i32,
        /// Time: blocks.
        time_blocks: i32,
        /// Its remainder [s].
        time_rest: f32,
        /// Current segment of the path.
        piece: u32,
        /// Current controller.
        controller: u32,
        /// Travel: a multiple of 1/16 voxel.
        coarse: f32,
        /// Its remainder [voxels].
        fine: f32,
        /// Speed along the approach axis [voxel/s].
        speed: f32,
        /// The same at the end of the trial step.
        found_speed: f32,
        /// Travel under evaluation: a multiple of 1/16 voxel.
        guess_base: f32,
        /// Its remainder [voxels].
        guess: f32,
        /// Travel known to be too low, relative to the base [voxels].
        low: f32,
        /// Travel known to be too high, relative to the base [voxels].
        high: f32,
        /// Travel of the evaluation before, relative to the base [voxels].
        before: f32,
        /// Its excess force [N].
        before_excess: f32,
        /// The fall of the excess per travel that its stiffness promises [N/voxel].
        before_slope: f32,
        /// Share of the slope that the last search has shown.
        scale: f32,
        /// Longest next motion into the touched surface [voxels].
        stride: f32,
        /// Motion into the surface in the search for a force [voxels].
        nudge: f32,
        /// Damping in the force balance [N s/voxel].
        damping: f32,
        /// Mass in the force balance [N s²/voxel].
        mass: f32,
        /// Number of force evaluations so far.
        evaluations: u32,
        /// 1 if the tool is first brought into balance at its current position.
        settling: u32,
        /// 1 if the surface was searched for from the air.
        searched: u32,
        /// 1 if the tool is at the upper end of its travel.
        in_air: u32,
        /// 1 if the step continues from the previous one.
        goes_on: u32,
        /// Selects the arrays that hold the start of the step.
        flip: u32,
        /// 1 if the tool has touched the part.
        touched: u32,
        /// 1 if the tool touched and reached its search limit without reaching the setpoint.
        too_soft: u32,
        /// Length of the step before any shortening [s].
        step_dt: f32,
        /// Length of the trial step [s].
        dt: f32,
        /// Longest step that the controller allows [s].
        dt_limit: f32,
        /// Time left [s].
        left: f32,
        /// Force of the last step [N].
        end_force: f32,
        /// Its stiffness [N/voxel].
        end_stiffness: f32,
        /// Speed of the surface along the travel in that step [voxel/s], from the change of the force.
        surface_speed: f32,
        /// Force of the last evaluation [N].
        force_now: f32,
        /// Its stiffness [N/voxel].
        stiffness_now: f32,
        /// Force at the start of the step as the controller reads it [N].
        start_force: f32,
        /// Weight of the force at the end of the step in its mean.
        end_weight: f32,
        /// Bulge: excess of the depth in the middle of the step over the mean of both ends, without recession [voxels].
        bulge: f32,
        /// Distance of the tool on this height field [voxels].
        travelled: f32,
        /// Recession since the slopes were taken [voxels].
        bent: f32,
        /// Recession since the height field was read [voxels].
        receded: f32,
        /// Above 0 if the patch reached the region's border at the start of the step.
        border: f32,
        /// Feed [m/s].
        feed_speed: f32,
        /// Time since the first contact [s].
        contact_time: f32,
        /// Distance since the first contact [m].
        path_position: f32,
        /// 1 if the tool has moved the distance allowed on this height field.
        is_far: u32,
    }
}

shared_struct! {
    /// A straight segment of a path, a few voxels long at most.
    PathPiece {
        /// Its start in whole voxels; the fourth is its time in blocks.
        whole: [i32; 4],
        /// Their remainders [voxels, s].
        rest: [f32; 4],
        /// Velocity [voxel/s]; the fourth is its duration [s].
        velocity: [f32; 4],
        /// Approach axis at its start; the fourth is the longest step that may begin on it [s].
        approach: [f32; 4],
        /// Axis of the tool at its start.
        axis: [f32; 4],
    }
}

shared_struct! {
    /// One step of a trial.
    LogRecord {
        /// Time at its end: blocks.
        time_blocks: i32,
        /// Its remainder [s].
        time_rest: f32,
        /// Travel at its end: a multiple of 1/16 voxel.
        coarse: f32,
        /// Its remainder [voxels].
        fine: f32,
        /// Force at its end [N].
        end_force: f32,
        /// Mean force [N].
        force: f32,
        /// `∫ p dA` [N].
        load: f32,
        /// Area under pressure [m²].
        area: f32,
        /// Highest pressure [Pa].
        pressure_max: f32,
        /// Removed volume of the part [m³].
        volume: f32,
        /// Removed volume of the coating [m³].
        coating_volume: f32,
        /// Length [s].
        dt: f32,
        /// Speed of the spindle [rad/s].
        spindle_speed: f32,
        /// 1 if there was no contact.
        in_air: u32,
        /// Padding.
        padding_a: u32,
        /// Padding.
        padding_b: u32,
    }
}
