//! On what an effect that nobody has listed may act, and what a small change of it does to the removal with the contact as it
//! is: the first order of the base laws.

use effects::Process;

/// What a form changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// The rate, or the dose, by a factor.
    Rate,
    /// The pressure, by a factor. The force is held: what presses more elsewhere presses less here.
    Pressure,
    /// The tool's turn about its x.
    Roll,
    /// The tool's place along its y.
    Offset,
    /// The gap between tool and workpiece.
    Gap,
    /// The height that the scanner sees.
    Height,
}

pub(crate) const ACTIONS: [Action; 6] =
    [Action::Rate, Action::Pressure, Action::Roll, Action::Offset, Action::Gap, Action::Height];

/// Variables that have one value for the whole tool at a time.
const OF_TOOL: &[&str] = &[
    "worked-volume",
    "sliding-distance",
    "warmth",
    "slow-warmth",
    "path-position",
    "path-remaining",
    "contact-time",
    "trial-time",
];

impl Action {
    /// Name in files; the rate needs none.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Rate => "",
            Self::Pressure => "pressure-",
            Self::Roll => "roll-",
            Self::Offset => "offset-",
            Self::Gap => "gap-",
            Self::Height => "height-",
        }
    }

    /// For people, after "the".
    pub(crate) fn about(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Pressure => "pressure",
            Self::Roll => "tool's roll",
            Self::Offset => "tool's place across",
            Self::Gap => "gap under the tool",
            Self::Height => "height that the scanner sees",
        }
    }

    /// Whether it is a factor that changes.
    pub(crate) fn is_factor(self) -> bool {
        matches!(self, Self::Rate | Self::Pressure)
    }

    /// Unit of a size in files, a typical size in it, and the SI value of that.
    pub(crate) fn size(self) -> (&'static str, f64, f64) {
        match self {
            Self::Rate | Self::Pressure => ("1", 1.0, 1.0),
            Self::Roll => ("mrad", 20.0, 20e-3),
            Self::Offset => ("mm", 2.0, 2e-3),
            Self::Gap => ("um", 50.0, 50e-6),
            Self::Height => ("um", 20.0, 20e-6),
        }
    }

    /// Unit in which people see a change, and how much of it a typical size is.
    pub(crate) fn shown(self) -> (&'static str, f64) {
        match self.size() {
            _ if self.is_factor() => ("%", 100.0),
            (unit, typical, _) => (unit, typical),
        }
    }

    /// Whether it may be a function of a variable.
    pub(crate) fn takes(self, process: Process, variable: &str) -> bool {
        match self {
            Self::Rate => true,
            Self::Pressure | Self::Roll | Self::Offset => OF_TOOL.contains(&variable),
            Self::Gap => ["place-on-tool", "distance-from-tool-middle"].contains(&variable),
            Self::Height => process == Process::Grinding && ["place-along-x", "place-along-y"].contains(&variable),
        }
    }

    /// Change of the rate of removal per typical size, as a formula of a workpiece cell's state; `None` where it is not the
    /// contact that changes.
    pub(crate) fn sensitivity(self, process: Process) -> Option<String> {
        let (removal, of_pressure) = match process {
            Process::Grinding => ("rate", "if(rate > 0, grind_rate, 0)"),
            Process::Sanding => ("dose_rate", "sanding_rate * slip_speed"),
        };
        match self {
            Self::Rate => Some(removal.to_owned()),
            Self::Pressure => Some(format!("{of_pressure} * (pressure - pressure_mean)")),
            Self::Roll => Some(format!("-0.02 * {of_pressure} * stiffness * tool_y")),
            Self::Gap => Some(format!("-5e-5 [m] * {of_pressure} * stiffness")),
            Self::Offset | Self::Height => None,
        }
    }

    /// What the effect file modifies, where `gain` is the factor or what is added.
    pub(crate) fn modification(self) -> &'static str {
        match self {
            Self::Rate => "rate = \"rate * gain\"\ndose_rate = \"dose_rate * gain\"\n",
            Self::Pressure => "pressure = \"pressure * gain\"\n",
            Self::Roll => "roll = \"roll + gain\"\n",
            Self::Offset => "offset_y = \"offset_y + gain\"\n",
            Self::Gap => "gap = \"gap + gain\"\n",
            Self::Height => "height = \"height + gain\"\n",
        }
    }
}
