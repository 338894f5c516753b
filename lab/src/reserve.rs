//! Why an effect cannot be named alone, however much better than the others it fits.

use super::fit::Estimate;
use super::suspect::Suspect;
use crate::criteria::{INTERVAL_SIGMAS, NOT_IDENTIFIABLE_SHARE};

/// What keeps an effect from being named alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reserve {
    /// The model with it has as many parameters as the data have conditions: nothing tests it.
    Saturated,
    /// It has a value for each pass or scan: it describes what happened and does not explain it.
    EachItsOwn,
    /// The data do not fix its size, or the interval holds the size at which it does nothing.
    Undetermined,
}

impl Reserve {
    /// - `spread`: standard deviation of what the best model leaves, whitened
    /// - `conditions`: that the data tell apart
    pub(super) fn of(suspect: &Suspect, spread: f64, conditions: usize) -> Option<Self> {
        if suspect.fit.coordinates.len() >= conditions {
            return Some(Self::Saturated);
        }
        let own = |estimate: &Estimate| estimate.coordinate.slot.owner == suspect.name();
        let estimates: Vec<Estimate> = suspect.fit.estimates(spread).into_iter().filter(own).collect();
        if estimates.iter().any(|estimate| estimate.coordinate.slot.row.is_some()) {
            return Some(Self::EachItsOwn);
        }
        let sizes = || estimates.iter().filter(|estimate| estimate.coordinate.slot.null.is_some());
        let is_sound = sizes().all(is_finite) && sizes().any(excludes_null);
        (!is_sound).then_some(Self::Undetermined)
    }

    /// For people.
    pub fn words(self) -> &'static str {
        match self {
            Self::Saturated => "the model with it has as many parameters as these data have conditions",
            Self::EachItsOwn => {
                "it has a value for each pass, so that it describes what happened and does not explain it"
            }
            Self::Undetermined => "these data do not fix its size, or allow that it does nothing",
        }
    }
}

/// Whether the interval is narrower than a good part of what the library lists.
fn is_finite(estimate: &Estimate) -> bool {
    let [least, greatest] = estimate.coordinate.listed();
    INTERVAL_SIGMAS * estimate.sigma <= NOT_IDENTIFIABLE_SHARE * (greatest - least)
}

/// Whether the interval leaves out the size at which the effect does nothing.
fn excludes_null(estimate: &Estimate) -> bool {
    let coordinate = &estimate.coordinate;
    let away = |null: f64| (coordinate.from_value(estimate.value) - coordinate.from_value(null)).abs();
    coordinate.slot.null.is_some_and(|null| away(null) > INTERVAL_SIGMAS * estimate.sigma)
}
