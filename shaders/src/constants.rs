//! Numbers that Rust and WGSL must agree on, declared once here and written out into every kernel.

macro_rules! shared_constants {
    ($($(#[doc = $doc:literal])+ $name:ident = $value:expr;)+) => {
        $($(#[doc = $doc])+ pub const $name: u32 = $value;)+

        /// The WGSL text that declares every constant of this module.
        pub fn wgsl() -> String {
            let mut text = String::new();
            $(
                $(text.push_str(&format!("//{}\n", $doc));)+
                text.push_str(&format!("const {}: u32 = {}u;\n", stringify!($name), $name));
            )+
            text
        }
    };
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
