//! Finishing processes, and the facts that distinguish them.

use serde::{Deserialize, Serialize};

use super::variable::{Hook, Variable};

/// A finishing process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Process {
    /// The surface recedes.
    Grinding,
    /// A coating wears off.
    Sanding,
}

impl Process {
    /// All processes.
    pub const ALL: [Self; 2] = [Self::Grinding, Self::Sanding];

    fn facts(self) -> Facts {
        match self {
            Self::Grinding => Facts {
                name: "grinding",
                signal: Signal::Height,
                laws: ["winkler", "preston-threshold"],
                per_pressure: "if(rate > 0, grind_rate, 0)",
            },
            Self::Sanding => Facts {
                name: "sanding",
                signal: Signal::Dose,
                laws: ["winkler", "preston-sanding"],
                per_pressure: "sanding_rate * slip_speed",
            },
        }
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        self.facts().name
    }

    /// Returns the process of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|process| process.name() == name)
    }

    /// Signal that its law drives.
    pub fn signal(self) -> Signal {
        self.facts().signal
    }

    /// Names of its default laws.
    pub fn laws(self) -> [&'static str; 2] {
        self.facts().laws
    }

    /// Derivative of [`Signal::rate`] with respect to the pressure under the default laws, as a formula.
    pub fn rate_per_pressure(self) -> &'static str {
        self.facts().per_pressure
    }

    /// True if the process has this hook: one that drives heights has no dose and no exposure, the other no recession.
    pub fn has(self, place: Hook) -> bool {
        match self.signal() {
            Signal::Height => !matches!(place, Hook::Dose | Hook::Exposure),
            Signal::Dose => place != Hook::Rate,
        }
    }
}

/// Signal that the law of a process drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// The surface recedes; scans are maps of heights.
    Height,
    /// A dose wears a coating off; scans are masks of the substrate that shows.
    Dose,
}

impl Signal {
    /// The rate that the law states.
    pub fn rate(self) -> Variable {
        match self {
            Self::Height => Variable::Rate,
            Self::Dose => Variable::DoseRate,
        }
    }
}

/// Facts that distinguish a process.
struct Facts {
    name: &'static str,
    signal: Signal,
    laws: [&'static str; 2],
    per_pressure: &'static str,
}

/// A value for each process; usually both are equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ByProcess<T> {
    /// Value for grinding, and for other processes that drive heights.
    pub grinding: T,
    /// Value for sanding, and for other processes that drive doses.
    pub sanding: T,
}

impl<T: Copy> ByProcess<T> {
    /// Uses the same value for both processes.
    pub fn both(value: T) -> Self {
        Self { grinding: value, sanding: value }
    }

    /// The value for a process.
    pub fn of(&self, process: Process) -> T {
        match process.signal() {
            Signal::Height => self.grinding,
            Signal::Dose => self.sanding,
        }
    }
}
