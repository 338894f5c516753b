//! The free parameters of a model, fitted to the calibration data.

use effects::{CompiledModel, Library, Model};
use rayon::prelude::*;

use super::error::Result;
use super::evidence::Evidence;
use super::fit::{Fit, FitOptions};
use super::scans::ScanEvidence;
use crate::criteria::RESTART_CHI2_PER_DATUM;

/// Fits the free parameters of a model to the calibration data. A model that lacks something may leave a landscape of several
/// valleys: where much is left, the fit is begun again from both sides of where it ended, and the best is taken.
///
/// # Errors
/// When it cannot be simulated or compiled.
pub fn calibrate(evidence: &dyn Evidence, model: &Model, library: &Library) -> Result<Fit> {
    let compiled = CompiledModel::new(model, library, evidence.rows())?;
    let coordinates = evidence.coordinates(&compiled);
    let first = Fit::new(evidence, &compiled, coordinates, FitOptions::default())?;
    if first.chi2 <= RESTART_CHI2_PER_DATUM * first.residuals.len() as f64 {
        return Ok(first);
    }
    let again = |place: &Vec<f64>| first.begun_at(evidence, place, FitOptions::default()).ok();
    let others: Vec<Fit> = first.both_sides().par_iter().filter_map(again).collect();
    Ok(others.into_iter().fold(first, |best, other| if other.chi2 < best.chi2 { other } else { best }))
}

/// As [`calibrate`]; from then on the evidence gives up simulations that take far longer than the model's.
///
/// # Errors
/// When it cannot be simulated or compiled.
pub fn calibrate_scans(evidence: &mut ScanEvidence, model: &Model, library: &Library) -> Result<Fit> {
    evidence.limit_steps(&CompiledModel::new(model, library, evidence.rows())?)?;
    calibrate(evidence, model, library)
}
