//! Starting values of a fit of a base law: rates that match the total removal, and ratios over orders of magnitude.

use effects::{CompiledModel, Scale};
use rayon::prelude::*;

use super::coordinates::{Coordinate, moved};
use super::evidence::EvidenceError;
use super::staged::{fit_rate, is_rate};
use super::totals::Totals;
use crate::criteria::{START_RATE_TOLERANCE, START_RATIO};

/// Returns the model with the rate that reproduces the measured total removal; unchanged if it has no such rate.
///
/// # Errors
/// If the model cannot be simulated.
pub(super) fn with_matched_rate(evidence: &dyn Totals, model: &CompiledModel) -> Result<CompiledModel, EvidenceError> {
    let coordinates = evidence.coordinates(model);
    let quicker = evidence.quicker();
    let quick = quicker.as_deref().unwrap_or(evidence);
    match coordinates.iter().find(|coordinate| is_rate(model, coordinate)) {
        Some(rate) => Ok(fit_rate(quick, model, (rate.clone(), START_RATE_TOLERANCE))?.1),
        None => Ok(model.clone()),
    }
}

/// Returns further starting models: each ratio but the rate is multiplied and divided by a factor, because a fit does
/// not find its way from the minimum of a soft contact to that of a stiff one. Starts without a simulation are omitted.
pub(super) fn other_starts(evidence: &dyn Totals, model: &CompiledModel) -> Vec<CompiledModel> {
    let coordinates = evidence.coordinates(model);
    let is_ratio = |c: &&Coordinate| c.slot.is_law && c.slot.scale == Scale::Log && !is_rate(model, c);
    let beside = coordinates.iter().filter(is_ratio).flat_map(|coordinate| {
        [START_RATIO, START_RATIO.recip()].map(|ratio| {
            let at = coordinate.clamped(coordinate.from_value(ratio * model.value(coordinate.index)));
            moved(model, std::slice::from_ref(coordinate), &[at])
        })
    });
    let starts: Vec<CompiledModel> = beside.collect();
    starts.into_par_iter().filter_map(|start| with_matched_rate(evidence, &start).ok()).collect()
}
