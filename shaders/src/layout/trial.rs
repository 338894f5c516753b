//! Structs of the simulator.

use bytemuck::{Pod, Zeroable};

use super::SharedType;

shared_struct! {
    /// What a trial is made with.
    TrialSetup {
        /// Brick coordinates of the first index entry [bricks]; the fourth is 0.
        grid_origin: [i32; 4],
        /// Index entries per axis [bricks]; the fourth is where they begin.
        grid_dims: [u32; 4],
        /// Least and greatest x, then y, of what the tool can touch [voxels].
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
        /// Infinity, which WGSL cannot write down.
        infinity: f32,
        /// First brick in the pool of the asset that trials share.
        first_brick: u32,
        /// Bricks of that asset: slots from there on are the trial's own.
        shared_bricks: u32,
        /// First brick in the pool of the trial's own.
        spare_first: u32,
        /// Bricks that the trial has room for.
        spare_bricks: u32,
        /// Where in the index the sources of the trial's own bricks begin.
        source_first: u32,
        /// Where the trial's columns begin.
        column_first: u32,
        /// Lines for which there is room.
        column_lines: u32,
        /// First piece of the path.
        path_first: u32,
        /// Pieces of the path; the entry after them is its end.
        path_pieces: u32,
        /// First row of the log.
        log_first: u32,
        /// Rows of the log, which is a ring.
        log_rows: u32,
        /// Where the trial's values begin.
        value_first: u32,
        /// Kind of tool.
        tool: u32,
        /// R or s [voxels].
        tool_radius: f32,
        /// Half width of a wheel [voxels].
        tool_half_width: f32,
        /// Curvature of a wheel's rim along the axis [1/voxel].
        tool_crown: f32,
        /// Radius that turns a spindle speed into the rim speed [voxels].
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
        /// Way of the tool in a step [voxels].
        step_way: f32,
        /// Way of the tool on a sheet [voxels].
        commit_way: f32,
        /// The tool is sought this far above and below its path [voxels].
        search_reach: f32,
        /// Thickness of the coating [m].
        coating: f32,
        /// Longest step [s].
        longest_step: f32,
        /// Whether an admittance is stepped at its period only where its dynamics matter.
        quasi_static: u32,
        /// Whether the surface recedes.
        grinds: u32,
        /// Whether pressure and recession may be anything but straight lines in the depth.
        bends: u32,
        /// Whether coating is taken off.
        sands: u32,
        /// Row of parameters that have one value per pass.
        pass_row: u32,
        /// Steps after which the pass is given up; 0 for never.
        most_steps: u32,
        /// End of the approach: blocks of time.
        approach_blocks: i32,
        /// The rest of it [s].
        approach_rest: f32,
        /// End of the path: blocks of time.
        duration_blocks: i32,
        /// The rest of it [s].
        duration_rest: f32,
        /// Time since the trial's first pass began [s].
        trial_time: f32,
        /// Length of the path [m].
        path_length: f32,
        /// Nothing.
        padding_a: u32,
        /// Nothing.
        padding_b: u32,
    }
}

shared_struct! {
    /// How far a trial is.
    TrialState {
        /// First line of the window along u and v [voxels].
        window_low: [i32; 4],
        /// Lines along u and v.
        window_size: [u32; 4],
        /// Window that the step needs: first lines and numbers of lines.
        wanted: [i32; 4],
        /// First row and place, rows and places that the step looks at.
        region: [u32; 4],
        /// The same where the start of the step was measured.
        start_region: [u32; 4],
        /// The same whose voxels change when the sheet is written back.
        changed: [u32; 4],
        /// Least and greatest x, then y, of the contact in the tool's frame [voxels].
        extent: [f32; 4],
        /// Offset of the tool by the model's effects, in its frame [voxels].
        offset: [f32; 4],
        /// Roll and pitch by the model's effects [rad].
        tilt: [f32; 4],
        /// Sweep of the working surface's border [voxels]; u, v, up.
        sweep: [f32; 4],
        /// Lowest points of the poses that are kept, in whole voxels; u, v, up.
        wholes: [[i32; 4]; 4],
        /// The rest of them, and their axes and approach axes.
        frames: [[f32; 4]; 20],
        /// What is done next.
        phase: u32,
        /// What is done after the sheet is written back.
        then: u32,
        /// What is done once the host has helped.
        resume: u32,
        /// Why the trial stands still.
        status: u32,
        /// The hook at fault.
        detail: u32,
        /// Lines or bricks for which room is needed.
        needed: u32,
        /// Steps taken.
        steps: u32,
        /// Bricks of the trial's own.
        own_bricks: u32,
        /// Those of them that have been filled.
        filled_bricks: u32,
        /// Layer whose distances are renewed.
        layer: u32,
        /// Layers to renew.
        layers: u32,
        /// Whether a sheet was read.
        has_sheet: u32,
        /// Axis of the field along which columns run.
        axis: u32,
        /// Which way is up: 1 or -1.
        up: i32,
        /// Height above which columns count [voxels].
        base: i32,
        /// Lowest voxel that is looked at.
        least: i32,
        /// Time: blocks.
        time_blocks: i32,
        /// The rest of it [s].
        time_rest: f32,
        /// Piece of the path.
        piece: u32,
        /// Who leads.
        controller: u32,
        /// Travel: a multiple of 1/16 voxel.
        coarse: f32,
        /// The rest of it [voxels].
        fine: f32,
        /// Speed along the approach axis [voxel/s].
        speed: f32,
        /// The same at the end of the step that is tried.
        found_speed: f32,
        /// Travel that is tried: a multiple of 1/16 voxel.
        guess_base: f32,
        /// The rest of it [voxels].
        guess: f32,
        /// Travel known to be too low, beyond the base [voxels].
        low: f32,
        /// Travel known to be too high, beyond the base [voxels].
        high: f32,
        /// Furthest way of the next step into what was touched [voxels].
        stride: f32,
        /// Way into the surface [voxels].
        nudge: f32,
        /// Damping of the search [N s/voxel].
        damping: f32,
        /// Mass of the search [N s²/voxel].
        mass: f32,
        /// Evaluations of the search.
        evaluations: u32,
        /// Whether the tool is first brought into balance where it is.
        settling: u32,
        /// Whether the surface was sought from the air.
        searched: u32,
        /// Whether the tool is as high as it goes.
        in_air: u32,
        /// Whether the step goes on from the one before.
        goes_on: u32,
        /// Whether the step is taken as its middle.
        whole_step: u32,
        /// Which arrays hold the start of the step.
        flip: u32,
        /// Whether the tool has touched the part.
        touched: u32,
        /// Whether the tool touched and went as deep as it may without meeting the setpoint.
        too_soft: u32,
        /// Length of the step that is sought [s].
        step_dt: f32,
        /// Length of the step that is tried [s].
        dt: f32,
        /// Longest step for the controller [s].
        dt_limit: f32,
        /// Time left [s].
        left: f32,
        /// Force of the last step [N].
        end_force: f32,
        /// Its stiffness [N/voxel].
        end_stiffness: f32,
        /// Force of the last evaluation [N].
        force_now: f32,
        /// Its stiffness [N/voxel].
        stiffness_now: f32,
        /// Force at the start of the step as the controller reads it [N].
        start_force: f32,
        /// Weight of the force at the end of the step in its mean.
        end_weight: f32,
        /// By how much deeper a point lies in the middle of the step than the mean of both ends, without recession [voxels].
        bulge: f32,
        /// Way of the tool on this sheet [voxels].
        travelled: f32,
        /// Recession since the slopes were taken [voxels].
        bent: f32,
        /// Recession since the sheet was read [voxels].
        receded: f32,
        /// Above 0 where the patch reached the region's border at the start of the step.
        border: f32,
        /// Feed [m/s].
        feed_speed: f32,
        /// Time since the first contact [s].
        contact_time: f32,
        /// Way since then [m].
        path_position: f32,
        /// Whether the tool has gone its way on this sheet.
        is_far: u32,
    }
}

shared_struct! {
    /// A straight piece of a path, at most some voxels long.
    PathPiece {
        /// Where it begins, in whole voxels; the fourth is its time in blocks.
        whole: [i32; 4],
        /// The rest of them [voxels, s].
        rest: [f32; 4],
        /// Velocity [voxel/s]; the fourth is its duration [s].
        velocity: [f32; 4],
        /// Approach axis where it begins; the fourth is the longest step that may begin on it [s].
        approach: [f32; 4],
        /// Axis of the tool where it begins.
        axis: [f32; 4],
    }
}

shared_struct! {
    /// One step of a trial.
    LogRecord {
        /// Time at its end: blocks.
        time_blocks: i32,
        /// The rest of it [s].
        time_rest: f32,
        /// Travel at its end: a multiple of 1/16 voxel.
        coarse: f32,
        /// The rest of it [voxels].
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
        /// Volume taken off the part [m³].
        volume: f32,
        /// Volume taken off the coating [m³].
        coating_volume: f32,
        /// Length [s].
        dt: f32,
        /// Speed of the spindle [rad/s].
        spindle_speed: f32,
        /// Whether there was nothing to press against.
        in_air: u32,
        /// Nothing.
        padding_a: u32,
        /// Nothing.
        padding_b: u32,
    }
}
