//! Fit of a model's free parameters to the calibration data.

use effects::{CompiledModel, Library, Model};
use rayon::prelude::*;

use super::begin::{other_starts, with_matched_rate};
use super::calibration::{Calibration, Order, uncalibrated};
use super::coordinates::moved;
use super::error::Result;
use super::evidence::{Evidence, EvidenceError};
use super::fit::{Fit, FitOptions};
use super::scans::ScanEvidence;
use super::space_mapping::Surrogate;
use super::totals::Totals;
use crate::criteria::{MINIMUM_APART, RESTARTS_FITTED, ROUGH_FIT_DERIVATIVES, ROUGH_FIT_STEPS};

/// Cost of a rough fit that only provides starting values for the next.
const ROUGH: FitOptions = FitOptions { derivatives: ROUGH_FIT_DERIVATIVES, steps: ROUGH_FIT_STEPS };

/// Fits the free parameters of a base law to the calibration data. The fit starts at the rate that matches the measured
/// total removal. A model that lacks an effect may have several local minima: where the residual is large, the fit is
/// restarted on both sides of its result and at other orders of magnitude of the ratios, on a coarser lattice where
/// there is one. All restarts are fitted roughly, the best few until convergence.
///
/// # Errors
/// If it cannot be simulated.
pub(super) fn fit_law(evidence: &dyn Totals, model: &CompiledModel) -> std::result::Result<Fit, EvidenceError> {
    let coordinates = evidence.coordinates(model);
    let fitted = |model: &CompiledModel| Fit::new(evidence, model, coordinates.clone(), FitOptions::default());
    let first = fitted(&with_matched_rate(evidence, model)?)?;
    if !first.is_poor() {
        return Ok(first);
    }
    let quicker = evidence.quicker();
    let surrogate = quicker.as_deref().and_then(|quicker| Surrogate::at(quicker, &first));
    let quick: &dyn Totals = surrogate.as_ref().map_or(evidence, |surrogate| surrogate);
    let again = |place: &Vec<f64>| first.begun_at(quick, place, ROUGH).ok();
    let start = |start: &CompiledModel| Fit::new(quick, start, coordinates.clone(), ROUGH).ok();
    let mut others: Vec<Fit> = first.both_sides().par_iter().filter_map(again).collect();
    others.par_extend(other_starts(quick, model).par_iter().filter_map(start));
    others.sort_by(|a, b| a.chi2.total_cmp(&b.chi2));
    others.truncate(RESTARTS_FITTED);
    let to_the_end = others.into_par_iter().map(|fit| fit.finished(quick, FitOptions::default()));
    let better = |best: Fit, other: Fit| if other.chi2 < best.chi2 { other } else { best };
    let best = to_the_end.collect::<Vec<_>>().into_iter().reduce(better).filter(|best| best.chi2 < first.chi2);
    let Some(best) = best else { return Ok(first) };
    let best = if surrogate.is_some() { fitted(&best.model)? } else { best };
    Ok(Fit { begun: first.begun.clone(), ..better(first, best) })
}

impl Fit {
    /// Another local minimum: that near the starting values; `None` if the fit lies in it. A model that lacks something
    /// may have its least χ² where it hides best what it lacks.
    pub(super) fn other_minimum(&self, evidence: &dyn Evidence) -> Option<Self> {
        let start = moved(&self.model, &self.coordinates, &self.begun);
        let fit = Self::unfitted(evidence, &start, self.coordinates.clone()).ok()?;
        let there = fit.roughly_refined(evidence);
        let is_far = there.at.iter().zip(&self.at).any(|(there, here)| (there - here).abs() > MINIMUM_APART);
        is_far.then_some(there)
    }

    /// Takes a few steps, on the faster lattice if there is one.
    fn roughly_refined(self, evidence: &dyn Evidence) -> Self {
        match evidence.quicker() {
            Some(quicker) => self.mapped(evidence, &*quicker, ROUGH),
            None => self.finished(evidence, ROUGH),
        }
    }
}

/// Takes a few steps of a fit, for quantities that are needed near the best values before these can be found.
///
/// # Errors
/// If the model cannot be simulated.
pub fn fit_roughly(evidence: &dyn Totals, model: &CompiledModel) -> std::result::Result<Fit, EvidenceError> {
    let model = with_matched_rate(evidence, model)?;
    Ok(Fit::unfitted(evidence, &model, evidence.coordinates(&model))?.roughly_refined(evidence))
}

/// Calibrates a model and the smaller models on the way to it.
///
/// # Errors
/// If it cannot be simulated or compiled.
pub fn calibrate(evidence: &dyn Totals, model: &Model, library: &Library) -> Result<Calibration> {
    let start = uncalibrated(model, library, evidence)?;
    Calibration::new(evidence, (model, &start), library, (Order::Joint, &|_| {}))
}

/// Calibrates a model against scans, and the smaller models on the way to it. Afterwards the evidence holds the lattice
/// error near the best values, and abandons simulations that take far longer than the model's.
///
/// # Errors
/// If it cannot be simulated or compiled.
pub fn calibrate_scans(evidence: &mut ScanEvidence, model: &Model, library: &Library) -> Result<Calibration> {
    let start = uncalibrated(model, library, evidence)?;
    evidence.calibrated((model, &start), library, (Order::Joint, &|_| {}))
}
