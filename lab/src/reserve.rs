//! Reasons against naming an effect alone, however well it fits.

use effects::Rows;

use super::fit::Estimate;
use super::suspect::Suspect;
use crate::criteria::{INTERVAL_SIGMAS, NOT_IDENTIFIABLE_SHARE};

/// Reason against naming an effect alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reserve {
    /// The model with it has as many parameters as the data have conditions, so that no data test it.
    Saturated,
    /// It has a value for each pass: it describes the data and does not explain them, so it is no cause.
    ValuePerPass,
    /// It has a value for each scan, which no other data test.
    ValuePerScan,
    /// The data do not determine its size, or its interval contains the null.
    Undetermined,
    /// It raises the error of the held-out passes.
    PredictsWorse,
}

impl Reserve {
    /// - `spread`: standard deviation of the best model's whitened residuals
    /// - `conditions`: number of conditions that the data distinguish
    pub(super) fn of(suspect: &Suspect, spread: f64, conditions: usize) -> Option<Self> {
        if suspect.fit.coordinates.len() >= conditions {
            return Some(Self::Saturated);
        }
        let own = |estimate: &Estimate| estimate.coordinate.slot.owner == suspect.name();
        let estimates: Vec<Estimate> = suspect.fit.estimates(spread).into_iter().filter(own).collect();
        if !suspect.explains() {
            return Some(Self::ValuePerPass);
        }
        if estimates.iter().any(|estimate| estimate.coordinate.slot.per == Rows::Scan) {
            return Some(Self::ValuePerScan);
        }
        let sizes = || estimates.iter().filter(|estimate| estimate.coordinate.slot.null.is_some());
        let is_determined = sizes().all(is_finite) && sizes().any(excludes_null);
        (!is_determined).then_some(Self::Undetermined)
    }

    /// Reason in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Saturated => "the model with it has as many parameters as these data have conditions",
            Self::ValuePerPass => {
                "it has a value for each pass, so that it describes what happened and does not explain it"
            }
            Self::ValuePerScan => "it has a value for each scan, which no other data test",
            Self::Undetermined => "these data do not determine its size, or are compatible with its absence",
            Self::PredictsWorse => "it fits the calibration passes, but raises the error of the held-out passes",
        }
    }
}

/// Returns true if the interval is narrow compared with the library's range.
fn is_finite(estimate: &Estimate) -> bool {
    let [least, greatest] = estimate.coordinate.listed();
    INTERVAL_SIGMAS * estimate.sigma <= NOT_IDENTIFIABLE_SHARE * (greatest - least)
}

/// Returns true if the interval excludes the null.
fn excludes_null(estimate: &Estimate) -> bool {
    let coordinate = &estimate.coordinate;
    let away = |null: f64| (coordinate.from_value(estimate.value) - coordinate.from_value(null)).abs();
    coordinate.slot.null.is_some_and(|null| away(null) > INTERVAL_SIGMAS * estimate.sigma)
}
