//! Effects of the library as competing explanations of residuals that a wrong frame or clock would also leave.

use effects::{Library, Model, Signal, candidates};
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::estimate::FrameCause;
use crate::diagnose::with_values;
use crate::error::Result;
use crate::evidence::{Evidence, Split};
use crate::fit::Fit;
use crate::probe::Candidate;
use crate::scans::ScanEvidence;
use crate::totals::Totals;

/// Change of the calibration residuals, each scan whitened separately, by each effect of a library beside a fit of a
/// model, shape [data, sizes] each. Masks show only a border, which an effect of another than its typical shape may move
/// as an offset does; in scans, all shapes together would also explain a clock that is late. Effects that are equivalent to frame or clock are left out.
///
/// # Errors
/// If the fitted model cannot be simulated.
pub(super) fn rivals(
    evidence: &ScanEvidence,
    (model, fit): (&Model, &Fit),
    library: &Library,
) -> Result<Vec<DMatrix<f64>>> {
    let quicker = evidence.quicker();
    let quick: &dyn Totals = quicker.as_deref().unwrap_or(evidence);
    let usual = quick.residuals(&fit.model, Split::Calibration)?;
    let is_same = |name: &str| FrameCause::ALL.iter().any(|cause| cause.effect() == Some(name));
    let own = candidates(model, library).into_iter();
    let effects: Vec<_> = own.filter(|e| !is_same(&e.name) && evidence.is_blind_to(e).is_none()).collect();
    let model = with_values(model, fit);
    let changes = |effect: &&effects::Effect| -> Vec<Vec<f64>> {
        let Ok(candidate) = Candidate::new(evidence, &model, effect, library) else { return Vec::new() };
        let change = |values: &[f64]| -> Option<Vec<f64>> {
            let there = quick.residuals(&candidate.at(values), Split::Calibration).ok()?;
            Some(there.iter().zip(&usual).map(|(there, usual)| there - usual).collect())
        };
        let probes: Vec<_> = match evidence.process().signal() {
            Signal::Height => candidate.typical().collect(),
            Signal::Dose => candidate.of_each_shape().collect(),
        };
        probes.into_iter().filter_map(|probe| change(&probe.values)).collect()
    };
    let rivals: Vec<Vec<Vec<f64>>> = effects.par_iter().map(changes).collect();
    Ok(rivals
        .iter()
        .filter(|rival| !rival.is_empty())
        .map(|rival| evidence.free(rival.iter().map(Vec::as_slice)))
        .collect())
}
