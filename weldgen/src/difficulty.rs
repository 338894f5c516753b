//! Difficulty of a weld: a preset before it is made, a class by measurements afterwards.

use serde::{Deserialize, Serialize};

/// Least exposure for an easy and for a medium weld.
const EXPOSURE: [f64; 2] = [0.9, 0.7];
/// Greatest turn over one bead width, |κ_g|·w [rad], for an easy and for a medium weld.
const TURN: [f64; 2] = [0.15, 0.3];

/// Difficulty of finishing a weld: a preset of all dials, and a class of the finished weld.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Difficulty {
    /// Short, nearly straight, freely accessible.
    Easy,
    /// The preset of [`WeldRequest::for_part`].
    #[default]
    Medium,
    /// Long and winding, with low exposure if the part has any such place.
    Hard,
}

impl Difficulty {
    /// Ranges of length [diagonals], RMS of κ_g [1/diagonal] and exposure, and the greatest κ_g [1/diagonal].
    pub(crate) fn dials(self) -> ([[f64; 2]; 3], f64) {
        match self {
            Self::Easy => ([[0.15, 0.3], [0.0, 1.0], [0.8, 1.0]], 3.0),
            Self::Medium => ([[0.25, 0.5], [2.0, 4.0], [0.5, 1.0]], 8.0),
            Self::Hard => ([[0.5, 0.9], [4.0, 7.0], [0.2, 0.8]], 16.0),
        }
    }
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

    /// Returns the class of a weld by the harder of two measures.
    ///
    /// - `exposure`: least exposure along it, 0 to 1
    /// - `turn`: greatest turn over one bead width, |κ_g|·w [rad]
    pub fn measured(exposure: f64, turn: f64) -> Self {
        let within = |class: usize| exposure >= EXPOSURE[class] && turn <= TURN[class];
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
