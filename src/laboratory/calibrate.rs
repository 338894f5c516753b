//! The free parameters of a model, fitted to the calibration data.

use sim::effect::{CompiledModel, Library, Model};

use super::evidence::Evidence;
use super::fit::{Fit, FitOptions};
use super::scans::ScanEvidence;

/// Fits the free parameters of a model to the calibration data.
///
/// # Errors
/// When it cannot be simulated or compiled.
pub fn calibrate(evidence: &dyn Evidence, model: &Model, library: &Library) -> anyhow::Result<Fit> {
    let compiled = CompiledModel::new(model, library, evidence.rows())?;
    let coordinates = evidence.coordinates(&compiled);
    Ok(Fit::new(evidence, &compiled, coordinates, FitOptions::default())?)
}

/// As [`calibrate`]; from then on the evidence gives up simulations that take far longer than the model's.
///
/// # Errors
/// When it cannot be simulated or compiled.
pub fn calibrate_scans(evidence: &mut ScanEvidence, model: &Model, library: &Library) -> anyhow::Result<Fit> {
    evidence.limit_steps(&CompiledModel::new(model, library, evidence.rows())?)?;
    calibrate(evidence, model, library)
}
