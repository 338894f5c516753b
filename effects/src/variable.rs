//! The variables of formulas: one table, from which messages, documents and checks are made.

use std::fmt;

use super::dimension::Dimension;
use super::unit::Unit;

/// Point at which a formula is evaluated: the hooks in their fixed order, then the three kinds of state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Hook {
    /// Offset and tilt of the tool, once per step.
    Pose,
    /// Gap between tool and workpiece, per contact cell.
    Shape,
    /// Contact pressure, per contact cell.
    Pressure,
    /// Spindle speed, once per step.
    Spindle,
    /// Force reading that the controller receives, once per step.
    Force,
    /// Recession speed when grinding, per contact cell.
    Rate,
    /// Dose rate when sanding, per contact cell.
    Dose,
    /// Height that the scanner reports, per pixel.
    Height,
    /// Dose at which the scanner reports the substrate as exposed, once per scan.
    Exposure,
    /// A state of the whole tool, once per step.
    ToolState,
    /// A state of each tool cell.
    ToolCell,
    /// A state of each workpiece cell.
    WorkpieceCell,
}

use Hook::{Dose, Exposure, Force, Height, Pose, Pressure, Rate, Shape, Spindle, ToolCell, ToolState, WorkpieceCell};

impl Hook {
    /// The hooks in the order in which they act.
    pub const HOOKS: [Self; 9] = [Pose, Shape, Pressure, Spindle, Force, Rate, Dose, Height, Exposure];

    /// Name in messages and documents.
    pub fn name(self) -> &'static str {
        match self {
            Pose => "pose",
            Shape => "shape",
            Pressure => "pressure",
            Spindle => "spindle",
            Force => "force",
            Rate => "rate",
            Dose => "dose",
            Height => "height",
            Exposure => "exposure",
            ToolState => "state per tool",
            ToolCell => "state per tool cell",
            WorkpieceCell => "state per workpiece cell",
        }
    }

    /// True if formulas here run over many cells or pixels at once.
    pub fn is_per_lane(self) -> bool {
        matches!(self, Shape | Pressure | Rate | Dose | Height | ToolCell | WorkpieceCell)
    }

    /// True if the scanner acts here, after the process.
    pub fn is_scan(self) -> bool {
        matches!(self, Height | Exposure)
    }

    /// Values that formulas may modify here.
    pub fn values(self) -> &'static [Variable] {
        match self {
            Pose => &[Variable::OffsetX, Variable::OffsetY, Variable::OffsetZ, Variable::Roll, Variable::Pitch],
            Shape => &[Variable::Gap],
            Pressure => &[Variable::Pressure],
            Spindle => &[Variable::SpindleSpeed],
            Force => &[Variable::ForceReading],
            Rate => &[Variable::Rate],
            Dose => &[Variable::DoseRate],
            Height => &[Variable::Height],
            Exposure => &[Variable::ExposureThreshold],
            ToolState | ToolCell | WorkpieceCell => &[],
        }
    }
}

/// Granularity of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Per {
    /// Once per step of the simulation.
    Step,
    /// Once per contact cell; at a tool cell, the mean over its contact.
    Cell,
    /// Once per pixel of a scan.
    Pixel,
    /// Once per tool cell.
    ToolCell,
}

/// All hooks of the process.
const PROCESS: &[Hook] = &[Pose, Shape, Pressure, Spindle, Force, Rate, Dose, ToolState, ToolCell, WorkpieceCell];
/// Hooks of the process and of the scanner.
const EVERYWHERE: &[Hook] =
    &[Pose, Shape, Pressure, Spindle, Force, Rate, Dose, Height, Exposure, ToolState, ToolCell, WorkpieceCell];
/// Hooks over contact cells.
const CELL: &[Hook] = &[Shape, Pressure, Rate, Dose, WorkpieceCell];
/// Hooks over contact cells whose depth is known.
const CONTACT: &[Hook] = &[Pressure, Rate, Dose, WorkpieceCell];
/// Hooks over contact cells and pixels.
const CELL_PIXEL: &[Hook] = &[Shape, Pressure, Rate, Dose, WorkpieceCell, Height];
/// Hooks over contact cells and tool cells.
const CELL_TOOL: &[Hook] = &[Shape, Pressure, Rate, Dose, WorkpieceCell, ToolCell];

/// One row of [`TABLE`].
#[derive(Clone, Copy, Debug)]
pub struct VariableRow {
    /// Name in formulas.
    pub name: &'static str,
    /// SI unit.
    pub unit: &'static str,
    /// Granularity.
    pub per: Per,
    /// Hooks at which formulas may use it.
    pub places: &'static [Hook],
    /// Least and greatest plausible value [SI], from which checks draw their inputs.
    pub probe: [f64; 2],
    /// Description.
    pub about: &'static str,
}

macro_rules! variables {
    ($($id:ident $name:literal [$unit:literal] $per:ident $places:expr, $low:literal .. $high:literal, $about:literal;)*) => {
        /// A variable of the formulas; [`TABLE`] describes each.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(u8)]
        pub enum Variable { $(#[doc = $about] $id,)* }

        /// Every variable, in the order of [`Variable`].
        pub const TABLE: &[VariableRow] = &[$(VariableRow {
            name: $name, unit: $unit, per: Per::$per, places: $places, probe: [$low, $high], about: $about,
        },)*];

        impl Variable {
            /// Every variable, in the order of [`TABLE`].
            pub const ALL: &[Self] = &[$(Self::$id,)*];
        }
    };
}

variables! {
    Time "time" ["s"] Step PROCESS, 0.0..30.0, "time since the pass began";
    ContactTime "contact_time" ["s"] Step PROCESS, 0.0..30.0, "time since the first contact in this pass";
    TrialTime "trial_time" ["s"] Step PROCESS, 0.0..3600.0, "time since the trial's first pass began, pauses included";
    PassNumber "pass_number" ["1"] Step EVERYWHERE, 1.0..4.0, "number of the pass in its trial, from 1";
    PathPosition "path_position" ["m"] Step PROCESS, 0.0..0.15, "way along the path since the first contact in this pass";
    PathRemaining "path_remaining" ["m"] Step PROCESS, 0.0..0.15, "way along the path that is left in this pass";
    FeedSpeed "feed_speed" ["m/s"] Step PROCESS, 0.0..0.02, "speed of the tool along its path";
    FeedX "feed_x" ["1"] Step PROCESS, -1.0..1.0, "x of the unit feed direction in the workpiece frame";
    FeedY "feed_y" ["1"] Step PROCESS, -1.0..1.0, "y of the unit feed direction in the workpiece frame";
    FeedAlong "feed_along" ["1"] Step PROCESS, -1.0..1.0, "x of the unit feed direction in the tool's frame";
    FeedAcross "feed_across" ["1"] Step PROCESS, -1.0..1.0, "y of the unit feed direction in the tool's frame";
    CuttingDirection "cutting_direction" ["1"] Step PROCESS, -1.0..1.0,
        "+1 where feed and the tool's surface at the contact run the same way, -1 against each other, 0 at rest";
    LiftSpeed "lift_speed" ["m/s"] Step PROCESS, -0.01..0.01, "speed of the tool along its approach axis, away from the workpiece";
    LiftAcceleration "lift_acceleration" ["m/s^2"] Step PROCESS, -1.0..1.0, "change of lift_speed per time";
    Force "force" ["N"] Step PROCESS, 0.0..60.0, "true normal force of the previous step; of this step for states";
    ForceSetpoint "force_setpoint" ["N"] Step PROCESS, 1.0..60.0, "force setpoint of the controller";
    ContactArea "contact_area" ["m^2"] Step PROCESS, 0.0..1e-3, "area of the contact patch, as force";
    PressureMean "pressure_mean" ["Pa"] Step PROCESS, 0.0..5e6, "force per contact area, as force";
    PatchWidth "patch_width" ["m"] Step PROCESS, 0.0..0.02, "extent of the contact patch across the tool (y), as force";
    RemovalRate "removal_rate" ["m^3/s"] Step PROCESS, 0.0..5e-8, "ground volume per time, as force";
    DoseVolumeRate "dose_volume_rate" ["m^3/s"] Step PROCESS, 0.0..5e-8, "volume of coating removed per time, as force";
    SpindleSetpoint "spindle_setpoint" ["rad/s"] Step PROCESS, -1000.0..1000.0, "set or logged spindle speed";
    SpindleSpeed "spindle_speed" ["rad/s"] Step PROCESS, -1000.0..1000.0, "speed of the spindle";
    SlidingSpeed "sliding_speed" ["m/s"] Step PROCESS, 0.0..60.0, "speed of the tool's rim, spindle_speed times tool_radius";
    ToolRadius "tool_radius" ["m"] Step PROCESS, 0.005..0.1, "radius of the wheel or the pad";
    ToolWidth "tool_width" ["m"] Step PROCESS, 0.005..0.1, "width of the wheel, diameter of the pad";
    TemperatureLogged "temperature_logged" ["K"] Step PROCESS, 280.0..400.0, "temperature that the log gives; 293.15 K without one";

    X "x" ["m"] Cell CELL_PIXEL, -0.1..0.1, "place in the workpiece frame";
    Y "y" ["m"] Cell CELL_PIXEL, -0.05..0.05, "place in the workpiece frame";
    Z "z" ["m"] Cell CELL, -0.01..0.01, "place in the workpiece frame";
    ToolX "tool_x" ["m"] Cell CELL, -0.02..0.02, "place in the tool's frame";
    ToolY "tool_y" ["m"] Cell CELL_TOOL, -0.02..0.02, "place in the tool's frame; of a tool cell, its centre's";
    Depth "depth" ["m"] Cell CONTACT, 0.0..1e-3, "depth of the workpiece's surface in the tool, gap subtracted";
    DepthRate "depth_rate" ["m/s"] Cell CONTACT, -1e-2..1e-2, "change of depth per time at this place of the workpiece";
    DepthLaplacian "depth_laplacian" ["1/m"] Cell CONTACT, -10.0..10.0, "second derivatives of depth along x and y, summed";
    SlipSpeed "slip_speed" ["m/s"] Cell &[Pressure, Rate, Dose, WorkpieceCell, ToolCell], 0.0..60.0,
        "speed of the tool's surface over the workpiece";
    RemovedDepth "removed_depth" ["m"] Cell CELL_PIXEL, 0.0..1e-3, "depth below the surface as it was before the trial";
    Dose "dose" ["1"] Cell CELL_PIXEL, 0.0..2.0, "sanding dose D; the coating is gone at 1";
    CoatingRemoved "coating_removed" ["m"] Cell CELL, 0.0..1e-4, "thickness of coating that is gone";
    EdgeDistance "edge_distance" ["m"] Cell CELL, 0.0..0.05, "distance to the workpiece's nearest free edge";
    Slope "slope" ["1"] Cell CELL, 0.0..1.0, "tangent of the angle between surface and tool face";
    Label "label" ["1"] Cell CELL_PIXEL, 0.0..2.0, "material: 0 base metal, 1 weld metal, 2 heat-affected zone";

    CellRemovalRate "cell_removal_rate" ["m^3/s"] ToolCell &[ToolCell], 0.0..1e-8, "volume ground per time under this tool cell";
    CellDoseVolumeRate "cell_dose_volume_rate" ["m^3/s"] ToolCell &[ToolCell], 0.0..1e-8,
        "volume of coating removed per time under this tool cell";
    CellFaceArea "cell_face_area" ["m^2"] ToolCell &[ToolCell], 1e-5..1e-3, "working surface of the tool in this cell";
    ToolFaceArea "tool_face_area" ["m^2"] Step PROCESS, 1e-4..1e-2, "working surface of the tool";

    SlopeX "slope_x" ["1"] Pixel &[Height], -1.0..1.0, "derivative of height along x";
    SlopeY "slope_y" ["1"] Pixel &[Height], -1.0..1.0, "derivative of height along y";
    HeightLaplacian "height_laplacian" ["1/m"] Pixel &[Height], -200.0..200.0, "second derivatives of height along x and y, summed";

    OffsetX "offset_x" ["m"] Step &[Pose], -1e-3..1e-3, "shift of the tool along its x";
    OffsetY "offset_y" ["m"] Step &[Pose], -1e-3..1e-3, "shift of the tool along its y";
    OffsetZ "offset_z" ["m"] Step &[Pose], -1e-3..1e-3, "shift of the tool along its z, away from the workpiece";
    Roll "roll" ["rad"] Step &[Pose], -0.03..0.03, "turn of the tool about its x, right-handed";
    Pitch "pitch" ["rad"] Step &[Pose], -0.03..0.03, "turn of the tool about its y, right-handed";
    Gap "gap" ["m"] Cell &[Shape], -1e-4..1e-4, "distance added between tool and workpiece";
    Pressure "pressure" ["Pa"] Cell &[Pressure, Rate, Dose, WorkpieceCell, ToolCell], 0.0..5e6, "contact pressure";
    ForceReading "force_reading" ["N"] Step &[Force], 0.0..60.0, "force reading of the controller";
    Rate "rate" ["m/s"] Cell &[Rate, WorkpieceCell, ToolCell], 0.0..5e-3, "recession speed along the surface's normal";
    DoseRate "dose_rate" ["1/s"] Cell &[Dose, WorkpieceCell, ToolCell], 0.0..10.0, "change of dose per time";
    Height "height" ["m"] Pixel &[Height], -1e-3..5e-3, "height that the scanner measures";
    ExposureThreshold "exposure_threshold" ["1"] Step &[Exposure], 0.5..1.5, "dose from which the scanner calls the substrate exposed; 1 for a perfect one";
}

impl Variable {
    /// Number of variables.
    pub const COUNT: usize = TABLE.len();

    /// Row of [`TABLE`].
    pub fn row(self) -> &'static VariableRow {
        &TABLE[self as usize]
    }

    /// Name in formulas.
    pub fn name(self) -> &'static str {
        self.row().name
    }

    /// Physical dimension.
    pub fn dimension(self) -> Dimension {
        Unit::parse(self.row().unit).map(|unit| unit.dimension).unwrap_or(Dimension::NONE)
    }

    /// Initial value of a value that formulas modify, before any law or effect; `None` if the simulator supplies it.
    pub(super) fn start(self) -> Option<f64> {
        match self {
            Self::SpindleSpeed | Self::ForceReading | Self::Height => None,
            Self::ExposureThreshold => Some(1.0),
            _ => Some(0.0),
        }
    }

    /// True if it has one value per cell or pixel at `place`.
    pub fn is_lane_at(self, place: Hook) -> bool {
        place.is_per_lane() && self.row().per != Per::Step
    }

    /// Returns the variable of this name that formulas at `place` may use.
    pub fn find(name: &str, place: Hook) -> Option<Self> {
        Self::at(place).find(|variable| variable.name() == name)
    }

    /// Variables that formulas at `place` may use, in the order of the table.
    pub fn at(place: Hook) -> impl Iterator<Item = Self> {
        Self::ALL.iter().copied().filter(move |variable| variable.row().places.contains(&place))
    }

    /// Returns the hook that modifies the value of this name. A hook with a single value is also found by its own name.
    pub fn modified_by(name: &str) -> Option<(Hook, Self)> {
        Hook::HOOKS.into_iter().find_map(|hook| {
            let values = hook.values();
            let single = (values.len() == 1 && hook.name() == name).then(|| values[0]);
            let value = single.or_else(|| values.iter().copied().find(|value| value.name() == name))?;
            Some((hook, value))
        })
    }
}

impl fmt::Display for Variable {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} [{}]", self.name(), self.row().unit)
    }
}

impl fmt::Display for Hook {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}
