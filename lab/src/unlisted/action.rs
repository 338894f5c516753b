//! Quantities that an unlisted effect may change, and the first-order response of the base laws to each: the change of
//! the removal at unchanged contact.

use effects::{Process, Signal, Unit};

use super::variables::{Scope, Variable};

/// A quantity that a form changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    /// The rate, or the dose, by a factor.
    Rate,
    /// The pressure, by a factor. The force is held, so that more pressure in one place means less in another.
    Pressure,
    /// Rotation of the tool about its x axis.
    Roll,
    /// Displacement of the tool along its y axis.
    Offset,
    /// The gap between tool and workpiece.
    Gap,
    /// The height that the scanner reads.
    Height,
}

pub(crate) const ACTIONS: [Action; 6] =
    [Action::Rate, Action::Pressure, Action::Roll, Action::Offset, Action::Gap, Action::Height];

impl Action {
    /// Name in files; empty for the rate.
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

    /// Display name, after "the".
    pub(crate) fn about(self) -> &'static str {
        match self {
            Self::Rate => "rate",
            Self::Pressure => "pressure",
            Self::Roll => "tool's roll",
            Self::Offset => "tool's place across",
            Self::Gap => "gap under the tool",
            Self::Height => "height that the scanner measures",
        }
    }

    /// True if a form is a factor of it, false if a form is added to it.
    pub(crate) fn is_factor(self) -> bool {
        matches!(self, Self::Rate | Self::Pressure)
    }

    /// Unit of a size in files, and a typical size in it.
    pub(crate) fn size(self) -> (&'static str, f64) {
        match self {
            Self::Rate | Self::Pressure => ("1", 1.0),
            Self::Roll => ("mrad", 20.0),
            Self::Offset => ("mm", 2.0),
            Self::Gap => ("µm", 50.0),
            Self::Height => ("µm", 20.0),
        }
    }

    /// A typical size [SI].
    pub(crate) fn typical(self) -> f64 {
        let (unit, typical) = self.size();
        Unit::parse(unit).map_or(typical, |unit| unit.to_si(typical))
    }

    /// Unit in which changes are displayed, and the value of a typical size in it.
    pub(crate) fn shown(self) -> (&'static str, f64) {
        match self.size() {
            _ if self.is_factor() => ("%", 100.0),
            size => size,
        }
    }

    /// True if it may depend on a variable.
    pub(crate) fn takes(self, process: Process, variable: &Variable) -> bool {
        match self {
            Self::Rate => true,
            Self::Pressure | Self::Roll | Self::Offset => variable.scope == Scope::Tool,
            Self::Gap => variable.scope == Scope::Face,
            Self::Height => process.signal() == Signal::Height && variable.scope == Scope::Part,
        }
    }

    /// Change of the removal rate per typical size, as a formula of a workpiece cell's state; `None` if the change is
    /// not one of the contact.
    pub(crate) fn sensitivity(self, process: Process) -> Option<String> {
        let (removal, of_pressure) = (process.signal().rate().name(), process.rate_per_pressure());
        match self {
            Self::Rate => Some(removal.to_owned()),
            Self::Pressure => Some(format!("{of_pressure} * (pressure - pressure_mean)")),
            Self::Roll => Some(format!("-{} * {of_pressure} * stiffness * tool_y", self.typical())),
            Self::Gap => Some(format!("-{} [m] * {of_pressure} * stiffness", self.typical())),
            Self::Offset | Self::Height => None,
        }
    }

    /// Lines of the `[modify]` section of an effect file, in which `gain` is the factor or the summand.
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
