//! The free parameters of a model, fitted to the calibration data.

use effects::{CompiledModel, Library, Model};
use rayon::prelude::*;

use super::begin::{other_starts, with_matched_rate};
use super::calibration::{Calibration, Order, uncalibrated};
use super::error::Result;
use super::evidence::EvidenceError;
use super::fit::{Fit, FitOptions};
use super::scans::ScanEvidence;
use super::totals::Totals;
use crate::criteria::{ROUGH_FIT_DERIVATIVES, ROUGH_FIT_STEPS};

/// Cost of a fit that only finds the place for the next.
const ROUGH: FitOptions = FitOptions { derivatives: ROUGH_FIT_DERIVATIVES, steps: ROUGH_FIT_STEPS };

/// Fits the free parameters of a base law to the calibration data. The fit begins where as much is removed in all as was
/// measured. A model that lacks something may leave a landscape of several valleys: where much is left, it is begun again
/// from both sides of where it ended and at ratios of other orders, on a coarser lattice where there is one, and the best is
/// fitted to the end.
///
/// # Errors
/// When it cannot be simulated.
pub(super) fn fit_law(evidence: &dyn Totals, model: &CompiledModel) -> std::result::Result<Fit, EvidenceError> {
    let coordinates = evidence.coordinates(model);
    let fitted = |model: &CompiledModel| Fit::new(evidence, model, coordinates.clone(), FitOptions::default());
    let first = fitted(&with_matched_rate(evidence, model)?)?;
    if !first.is_poor() {
        return Ok(first);
    }
    let quicker = evidence.quicker(&first.model)?;
    let quick: &dyn Totals = quicker.as_deref().unwrap_or(evidence);
    let again = |place: &Vec<f64>| first.begun_at(quick, place, FitOptions::default()).ok();
    let beside: Vec<Fit> = first.both_sides().par_iter().filter_map(again).collect();
    let start = |start: &CompiledModel| Fit::new(quick, start, coordinates.clone(), FitOptions::default()).ok();
    let others: Vec<Fit> = other_starts(quick, model).par_iter().filter_map(start).collect();
    let better = |best: Fit, other: Fit| if other.chi2 < best.chi2 { other } else { best };
    let Some(best) = beside.into_iter().chain(others).reduce(better).filter(|best| best.chi2 < first.chi2) else {
        return Ok(first);
    };
    let best = if quicker.is_some() { fitted(&best.model)? } else { best };
    Ok(Fit { begun: first.begun.clone(), ..better(first, best) })
}

/// A few steps of a fit, for what must be known near the best values before these can be found.
///
/// # Errors
/// When the model cannot be simulated.
pub fn fit_roughly(evidence: &dyn Totals, model: &CompiledModel) -> std::result::Result<Fit, EvidenceError> {
    let model = with_matched_rate(evidence, model)?;
    Fit::new(evidence, &model, evidence.coordinates(&model), ROUGH)
}

/// Calibrates a model, and the models that it grew from.
///
/// # Errors
/// When it cannot be simulated or compiled.
pub fn calibrate(evidence: &dyn Totals, model: &Model, library: &Library) -> Result<Calibration> {
    let start = uncalibrated(model, library, evidence)?;
    Calibration::new(evidence, (model, &start), library, (Order::Joint, &|_| {}))
}

/// Calibrates a model against scans, and the models that it grew from. The evidence then knows what the simulation's lattice
/// errs by near the best values, and gives up simulations that take far longer than the model's.
///
/// # Errors
/// When it cannot be simulated or compiled.
pub fn calibrate_scans(evidence: &mut ScanEvidence, model: &Model, library: &Library) -> Result<Calibration> {
    let start = uncalibrated(model, library, evidence)?;
    evidence.calibrated((model, &start), library, (Order::Joint, &|_| {}))
}
