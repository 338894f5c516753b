//! Numbers that Rust and WGSL must agree on, declared once here and written out into every kernel.

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
    /// Index entry of a brick that is wholly outside, beyond the band.
    OUTSIDE = u32::MAX;
    /// Index entry of a brick that is wholly inside, beyond the band.
    INSIDE = u32::MAX - 1;
    /// Voxel coordinates are looked up below this: from 2^22 on, an f32 steps by half a voxel or more.
    FARTHEST_VOXEL = 1 << 22;
    /// Invocations in a workgroup of a kernel over a list: two waves of 32, one of 64, inside every limit.
    WORKGROUP_SIZE = 64;
    /// A plane of values that a pool does not have.
    ABSENT = u32::MAX;
    /// Blocks of time in a second: clocks of the simulator are blocks and the rest of one.
    TIME_BLOCKS = 64;
    /// Cells of a tool, one for each invocation of a workgroup.
    TOOL_CELLS = WORKGROUP_SIZE;
    /// Arrays over the lines of a trial's sheet.
    COLUMN_ARRAYS = 23;
    /// Sums and greatest values that are taken over the invocations of a workgroup.
    REDUCED = 16;
    /// Numbers that a trial keeps for them.
    PARTIALS = (WORKGROUP_SIZE + 1) * REDUCED;
    /// A wheel.
    TOOL_WHEEL = 0;
    /// A disc that faces the part.
    TOOL_PAD = 1;
    /// A ball tip.
    TOOL_SPHERE = 2;
    /// The force is the setpoint at every time.
    CONTROLLER_IDEAL = 0;
    /// The tool moves as a damped mass under the force.
    CONTROLLER_ADMITTANCE = 1;
    /// The tool keeps to its path.
    CONTROLLER_REPLAY = 2;
    /// The trial goes on.
    STATUS_RUNNING = 0;
    /// The pass is at its end.
    STATUS_DONE = 1;
    /// A sheet has more lines than the trial has room for; `needed` of them.
    STATUS_NEEDS_COLUMNS = 2;
    /// The trial writes more bricks than it has room for; `needed` of them.
    STATUS_NEEDS_BRICKS = 3;
    /// A formula gave no finite number; `detail` says at which hook.
    STATUS_FORMULA = 4;
    /// The pass was given up.
    STATUS_TOO_MANY_STEPS = 5;
    /// The hook of a pose.
    FAULT_POSE = 1;
    /// The hook of a gap.
    FAULT_SHAPE = 2;
    /// The hook of a pressure.
    FAULT_PRESSURE = 3;
    /// The hook of the spindle.
    FAULT_SPINDLE = 4;
    /// The hook of a force reading.
    FAULT_FORCE = 5;
    /// The hook of a recession speed.
    FAULT_RATE = 6;
    /// The hook of a dose rate.
    FAULT_DOSE = 7;
    /// A state of the tool.
    FAULT_TOOL_STATE = 8;
    /// A state of a tool cell.
    FAULT_TOOL_CELL = 9;
    /// A pixel shows the room behind the scene.
    SEEN_BACKGROUND = 0;
    /// A pixel shows the part.
    SEEN_PART = 1;
    /// A pixel shows the table.
    SEEN_TABLE = 2;
}

shared_numbers! {
    /// Relative difference of two depths from which a slope is taken between them.
    APART: f64 => f32 = 1e-5;
    /// Longest step while the tool comes down [s].
    APPROACH_STEP: f64 => f32 = 0.01;
    /// Recession after which a sheet's slopes are taken anew [voxels].
    BENT: f64 => f32 = 0.02;
    /// Voxels by which a column is followed upwards out of the material.
    CLIMB: i32 => i32 = 400;
    /// Recession after which a sheet is written back [voxels]: well within the distance that φ keeps beyond its zero set.
    COMMIT_RECESSION: f64 => f32 = 0.75;
    /// Reflectance of paint at normal incidence.
    DIELECTRIC: f32 => f32 = 0.04;
    /// Length of a groove in widths.
    ELONGATION: f32 => f32 = 60.0;
    /// Way into the surface at first [m].
    FIRST_NUDGE: f64 => f32 = 1e-7;
    /// Furthest that the tool is first sent into what it has just touched [m]; four times as far with each try.
    FIRST_STRIDE: f64 => f32 = 5e-6;
    /// Change of the force in a step [setpoints] beyond which it is shortened, too.
    FORCE_JUMP: f64 => f32 = 0.1;
    /// Distance of Gauss's two points from the middle of the time in which a square is under the tool, as a part of a
    /// whole sweep: 1/(2 √3). Their mean is exact for a speed that is a cubic in time.
    HALF_GAUSS: f64 => f32 = 0.288_675_134_594_812_9;
    /// Inertial force [setpoints] beyond which an admittance is stepped at its own period.
    INERTIA: f64 => f32 = 0.03;
    /// Labels are read this far below the surface [voxels], where the metal that carries them is.
    LABEL_DEPTH: f32 => f32 = 0.75;
    /// Least step towards a light [voxels]: what throws no shadow is thinner than this.
    LEAST_STEP: f32 => f32 = 0.5;
    /// Narrowest distribution: a sharper highlight than this is missed between pixels.
    LEAST_WIDTH: f32 => f32 = 0.004;
    /// Longest step [s].
    LONGEST_STEP: f64 => f32 = 0.05;
    /// Surface looked at ahead of a step, where the contact may go next [voxels].
    LOOK_AHEAD: f64 => f32 = 3.0;
    /// Lines around the contact that a sheet holds in reserve.
    MARGIN: i32 => i32 = 3;
    /// Surface sought below the tool while it is in contact [voxels].
    NEAR_BELOW: f64 => f32 = 4.0;
    /// Part of the band over which a penumbra is drawn; beyond it φ is truncated and says nothing.
    PENUMBRA_BAND: f32 => f32 = 0.9;
    /// Relative change of depth over which the slope of the recession is taken.
    PROBE: f64 => f32 = 1e-3;
    /// Start of a shadow ray above the surface [voxels].
    SHADOW_START: f32 => f32 = 0.6;
    /// Area ratio up to which a column's whole band is written.
    STEEPEST: f64 => f32 = 2.0;
    /// Share of the setpoint that counts as touching the part.
    TOUCH: f64 => f32 = 0.15;
    /// Share of the band up to which a value is a distance and no bound.
    WITHIN_BAND: f64 => f32 = 0.999;
    /// Evaluations of the force before the best travel so far is taken.
    EVALUATIONS: usize => u32 = 40;
    /// Most steps of the inversion; each gains about one digit for the distortion of a real lens.
    INVERSION_STEPS: usize => i32 = 16;
    /// Steps towards a root: as many halvings of 3 cells' thirds are below the resolution of f32 in a large grid.
    CUBIC_STEPS: usize => i32 = 18;
    /// Step below which the root is found [thirds of a cell].
    CUBIC_RESOLUTION: f32 => f32 = 1e-5;
    /// Times that the clock of a device does not tell apart [s].
    DEVICE_CLOCK: f64 => f32 = 1e-7;
    /// Depth at which a law begins, as a share of the depth, below which it counts as one without a threshold: far above the roundings
    /// of a slope, and of no weight for what a square loses.
    NO_THRESHOLD: f64 => f32 = 1e-2;
}
