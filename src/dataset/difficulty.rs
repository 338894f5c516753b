//! How hard an item is, from what was measured along its welds.

use serde::{Deserialize, Serialize};

use crate::asset::WeldTruth;

/// Least exposure of an easy and of a medium weld.
const EXPOSURE: [f64; 2] = [0.9, 0.7];
/// Largest turn over one bead width, |κ_g|·w [rad], of an easy and of a medium weld.
const TURN: [f64; 2] = [0.15, 0.3];

/// Class of an item: that of its hardest weld under its harder dial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Difficulty {
    /// Open to every side and nearly straight.
    Easy,
    /// Somewhat hidden or bent.
    Medium,
    /// Hidden or bent.
    Hard,
}

/// Largest turn of a weld over one bead width, |κ_g|·w [rad].
pub(super) fn turn(weld: &WeldTruth) -> f64 {
    weld.geodesic_curvature_max_per_m * 1e-3 * weld.width_mm
}

impl Difficulty {
    /// Names in order.
    pub const ALL: [Self; 3] = [Self::Easy, Self::Medium, Self::Hard];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Easy => "easy",
            Self::Medium => "medium",
            Self::Hard => "hard",
        }
    }

    /// The class of an item with these welds.
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

    /// What the class means, for people.
    pub fn rule() -> String {
        format!(
            "easy: exposure {} or more everywhere and a turn of {} rad or less over one bead width; medium: {} and {}; \
             hard: the rest",
            EXPOSURE[0], TURN[0], EXPOSURE[1], TURN[1]
        )
    }
}
