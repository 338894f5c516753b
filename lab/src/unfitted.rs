//! Effects that a search looked at and did not weigh, with the reasons.

use serde::Serialize;

use super::round::Round;
use super::screen::Screened;
use super::suspect::by_promise;
use crate::criteria::{EFFECTS_FITTED, FITTED_DELTA_CHI2};

/// An effect that a search looked at and did not weigh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Unfitted {
    /// Name in the library.
    pub name: String,
    /// Title in the library.
    pub title: String,
    /// Number of the search, from 1.
    pub search: usize,
    /// Reason for not weighing it.
    pub reason: String,
}

impl Round {
    /// Effects that could be simulated and are not among the findings, most promising first, each with the reason.
    pub fn unfitted(&self) -> Vec<(&str, String)> {
        let is_weighed = |name: &str| self.findings.iter().any(|finding| finding.suspect.name() == name);
        let order = by_promise(self.screened.iter().filter(|screened| screened.is_simulated()));
        let ranked = order.into_iter().enumerate();
        let left = ranked.filter(|(_, screened)| !is_weighed(&screened.candidate.name));
        left.map(|(rank, screened)| (screened.candidate.name.as_str(), reason(rank, screened))).collect()
    }
}

/// Reason for not weighing an effect, given its rank by expected Δχ².
fn reason(rank: usize, screened: &Screened) -> String {
    let delta_chi2 = screened.delta_chi2;
    if delta_chi2 <= FITTED_DELTA_CHI2 {
        return format!("no fall of χ²: the first look predicts {delta_chi2:.1}, and {FITTED_DELTA_CHI2} are needed");
    }
    if rank >= EFFECTS_FITTED {
        return format!(
            "not fitted: a fall of χ² by {delta_chi2:.1} at first look, and {EFFECTS_FITTED} others are predicted to \
             give more"
        );
    }
    "no fall of χ²: no fit of it is better than the model without it".to_owned()
}
