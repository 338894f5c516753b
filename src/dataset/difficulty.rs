//! Difficulty of an item, from measurements along its welds.

use serde::{Deserialize, Serialize};

use crate::asset::WeldTruth;

/// Least exposure for an easy and for a medium weld.
const EXPOSURE: [f64; 2] = [0.9, 0.7];
/// Greatest turn over one bead width, |κ_g|·w [rad], for an easy and for a medium weld.
const TURN: [f64; 2] = [0.15, 0.3];

/// Difficulty of an item: that of its hardest weld by the harder of two measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Difficulty {
    /// Free to all sides and nearly straight.
    Easy,
    /// Partly shaded or bent.
    Medium,
    /// Shaded or bent.
    Hard,
}

/// Returns the greatest turn of a weld over one bead width, |κ_g|·w [rad].
pub(super) fn turn(weld: &WeldTruth) -> f64 {
    weld.geodesic_curvature_max_per_m * 1e-3 * weld.width_mm
}

impl Difficulty {
    /// All classes in order.
    pub const ALL: [Self; 3] = [Self::Easy, Self::Medium, Self::Hard];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Easy => "easy",
            Self::Medium => "medium",
            Self::Hard => "hard",
        }
    }

    /// Returns the class of an item with these welds.
    pub fn of(welds: &[WeldTruth]) -> Self {
        welds.iter().map(Self::of_weld).max().unwrap_or(Self::Easy)
    }

    fn of_weld(weld: &WeldTruth) -> Self {
        let within = |class: usize| weld.exposure_min >= EXPOSURE[class] && turn(weld) <= TURN[class];
        match (within(0), within(1)) {
            (true, _) => Self::Easy,
            (_, true) => Self::Medium,
            _ => Self::Hard,
        }
    }

    /// Describes the rule of the classes for people.
    pub fn rule() -> String {
        format!(
            "easy: exposure {} or more everywhere and a turn of {} rad or less over one bead width; medium: {} and {}; \
             hard: the rest",
            EXPOSURE[0], TURN[0], EXPOSURE[1], TURN[1]
        )
    }
}
