//! Constants shared by Rust and WGSL: declared once here and written into every kernel.

macro_rules! shared_constants {
    ($($(#[doc = $doc:literal])+ $name:ident = $value:expr;)+) => {
        $($(#[doc = $doc])+ pub const $name: u32 = $value;)+

        fn indices_and_counts() -> String {
            let mut text = String::new();
            $(
                $(text.push_str(&format!("//{}\n", $doc));)+
                text.push_str(&format!("const {}: u32 = {}u;\n", stringify!($name), $name));
            )+
            text
        }
    };
}

macro_rules! shared_numbers {
    ($($(#[doc = $doc:literal])+ $name:ident: $rust:ty => $wgsl:ident = $value:expr;)+) => {
        $($(#[doc = $doc])+ pub const $name: $rust = $value;)+

        fn numbers() -> String {
            let mut text = String::new();
            $(
                $(text.push_str(&format!("//{}\n", $doc));)+
                text.push_str(&format!("const {}: {} = {:?};\n", stringify!($name), stringify!($wgsl), $name));
            )+
            text
        }
    };
}

/// The WGSL text that declares every constant of this module.
pub fn wgsl() -> String {
    indices_and_counts() + &numbers()
}

shared_constants! {
    /// log2 of the voxels along the side of a brick.
    BRICK_SHIFT = 3;
    /// Voxels along the side of a brick.
    BRICK_SIDE = 1 << BRICK_SHIFT;
    /// Voxels in a brick.
    BRICK_VOXELS = BRICK_SIDE * BRICK_SIDE * BRICK_SIDE;
    /// Index entry of a brick that is entirely outside, beyond the band.
    OUTSIDE = u32::MAX;
    /// Index entry of a brick that is entirely inside, beyond the band.
    INSIDE = u32::MAX - 1;
    /// Limit of voxel coordinates: from 2^22 on, an f32 has a resolution of half a voxel or coarser.
    FARTHEST_VOXEL = 1 << 22;
    /// Invocations in a workgroup of a kernel over a list: two subgroups of 32 or one of 64, within every device limit.
    WORKGROUP_SIZE = 64;
    /// Marks a plane of values that a pool does not store.
    ABSENT = u32::MAX;
    /// Blocks of time per second: clocks of the simulator consist of a number of blocks and a remainder.
    TIME_BLOCKS = 64;
    /// Cells of a tool, one for each invocation of a workgroup.
    TOOL_CELLS = WORKGROUP_SIZE;
    /// Number of arrays over the columns of a trial's height field.
    COLUMN_ARRAYS = 23;
    /// Number of sums and maxima taken over the invocations of a workgroup.
    REDUCED = 16;
    /// Numbers that a trial stores for these reductions.
    PARTIALS = (WORKGROUP_SIZE + 1) * REDUCED;
    /// Tool: a wheel.
    TOOL_WHEEL = 0;
    /// Tool: a pad, a disc that faces the part.
    TOOL_PAD = 1;
    /// Tool: a ball tip.
    TOOL_SPHERE = 2;
    /// Controller: the force equals the setpoint at all times.
    CONTROLLER_IDEAL = 0;
    /// Controller: the tool moves as a damped mass under the force.
    CONTROLLER_ADMITTANCE = 1;
    /// Controller: the tool keeps to its path.
    CONTROLLER_REPLAY = 2;
    /// Status: the trial is running.
    STATUS_RUNNING = 0;
    /// Status: the pass has ended.
    STATUS_DONE = 1;
    /// Status: a height field has more columns than allocated; `needed` of them.
    STATUS_NEEDS_COLUMNS = 2;
    /// Status: the trial writes more bricks than allocated; `needed` of them.
    STATUS_NEEDS_BRICKS = 3;
    /// Status: a formula gave no finite number; `detail` names the hook.
    STATUS_FORMULA = 4;
    /// Status: the pass was given up.
    STATUS_TOO_MANY_STEPS = 5;
    /// Fault in a formula of the pose.
    FAULT_POSE = 1;
    /// Fault in a formula of the gap.
    FAULT_SHAPE = 2;
    /// Fault in a formula of the pressure.
    FAULT_PRESSURE = 3;
    /// Fault in a formula of the spindle.
    FAULT_SPINDLE = 4;
    /// Fault in a formula of the force reading.
    FAULT_FORCE = 5;
    /// Fault in a formula of the recession speed.
    FAULT_RATE = 6;
    /// Fault in a formula of the dose rate.
    FAULT_DOSE = 7;
    /// Fault in a state of the tool.
    FAULT_TOOL_STATE = 8;
    /// Fault in a state of a tool cell.
    FAULT_TOOL_CELL = 9;
    /// A pixel shows the background.
    SEEN_BACKGROUND = 0;
    /// A pixel shows the part.
    SEEN_PART = 1;
    /// A pixel shows the table.
    SEEN_TABLE = 2;
}

shared_numbers! {
    /// Relative difference between two depths above which a slope between them is used.
    APART: f64 => f32 = 1e-5;
    /// Longest step during the approach [s].
    APPROACH_STEP: f64 => f32 = 0.01;
    /// Recession after which a height field's slopes are computed again [voxels].
    BENT: f64 => f32 = 0.02;
    /// Number of voxels by which a column is followed upwards out of the material.
    CLIMB: i32 => i32 = 400;
    /// Recession after which a height field is written back [voxels]: well within the distance that φ keeps beyond its
    /// zero set.
    WRITE_BACK_RECESSION: f64 => f32 = 0.75;
    /// Reflectance of paint at normal incidence.
    DIELECTRIC: f32 => f32 = 0.04;
    /// Length of a grinding mark in widths.
    ELONGATION: f32 => f32 = 60.0;
    /// First motion into the surface in the search for a force [m].
    FIRST_NUDGE: f64 => f32 = 1e-7;
    /// Longest first motion of the tool into a surface that it has just touched [m]; four times as far with each try.
    FIRST_STRIDE: f64 => f32 = 5e-6;
    /// Change of the force in a step [setpoints] above which an admittance controller's step is shortened.
    FORCE_JUMP: f64 => f32 = 0.1;
    /// Gauss's two points in the time for which a cell is under the tool: their distance from its middle, as a part of
    /// a whole sweep: 1/(2 √3). The two-point mean is exact for a speed that is a cubic in time.
    HALF_GAUSS: f64 => f32 = 0.288_675_134_594_812_9;
    /// Inertial force [setpoints] above which an admittance controller is stepped at its own period.
    INERTIA: f64 => f32 = 0.03;
    /// Depth below the surface at which labels are read [voxels], inside the metal that carries them.
    LABEL_DEPTH: f32 => f32 = 0.75;
    /// Shortest step towards a light [voxels]: features thinner than this throw no shadow.
    LEAST_STEP: f32 => f32 = 0.5;
    /// Narrowest width of the microfacet distribution: a sharper highlight is missed between pixels.
    LEAST_WIDTH: f32 => f32 = 0.004;
    /// Longest step [s].
    LONGEST_STEP: f64 => f32 = 0.05;
    /// Margin of surface evaluated ahead of a step, where the contact may move [voxels].
    LOOK_AHEAD: f64 => f32 = 3.0;
    /// Margin of columns around the contact that a height field holds.
    MARGIN: i32 => i32 = 3;
    /// Distance below the tool in which the surface is searched for while it is in contact [voxels].
    NEAR_BELOW: f64 => f32 = 4.0;
    /// Share of the band over which a penumbra is drawn; beyond it φ is truncated and carries no information.
    PENUMBRA_BAND: f32 => f32 = 0.9;
    /// Relative change of depth over which the slope of the recession speed is taken.
    PROBE: f64 => f32 = 1e-3;
    /// Start of a shadow ray above the surface [voxels].
    SHADOW_START: f32 => f32 = 0.6;
    /// Area ratio up to which a column's whole band is written.
    STEEPEST: f64 => f32 = 2.0;
    /// Share of the setpoint that counts as touching the part.
    TOUCH: f64 => f32 = 0.15;
    /// Share of the band up to which a value is a distance, not the clamp.
    WITHIN_BAND: f64 => f32 = 0.999;
    /// Maximum number of force evaluations, after which the best travel so far is taken.
    EVALUATIONS: usize => u32 = 40;
    /// Maximum number of iterations of the inversion; each gains about one digit for the distortion of a real lens.
    INVERSION_STEPS: usize => i32 = 16;
    /// Maximum number of root-finding steps: 18 halvings of 3 cells' thirds are below the resolution of f32 in a large
    /// grid.
    CUBIC_STEPS: usize => i32 = 18;
    /// Step size below which the root is found [thirds of a cell].
    CUBIC_RESOLUTION: f32 => f32 = 1e-5;
    /// Resolution of a device's clock [s].
    DEVICE_CLOCK: f64 => f32 = 1e-7;
    /// A law whose threshold depth, as a share of the depth, is below this counts as one without a threshold. It is far
    /// above the rounding errors of a slope, and insignificant for the recession of a cell.
    NO_THRESHOLD: f64 => f32 = 1e-2;
}
