//! Where the fit of a base law begins: at rates that remove what was removed in all, with ratios of several orders.

use effects::{CompiledModel, Scale};
use rayon::prelude::*;

use super::coordinates::{Coordinate, moved};
use super::evidence::EvidenceError;
use super::staged::{fit_rate, is_rate};
use super::totals::Totals;
use crate::criteria::{START_RATE_TOLERANCE, START_RATIO};

/// A model with the removal rate that removes as much in all as was measured, where it has such a rate.
///
/// # Errors
/// When the model cannot be simulated.
pub(super) fn with_matched_rate(evidence: &dyn Totals, model: &CompiledModel) -> Result<CompiledModel, EvidenceError> {
    let coordinates = evidence.coordinates(model);
    let quicker = evidence.quicker();
    let quick = quicker.as_deref().unwrap_or(evidence);
    match coordinates.iter().find(|coordinate| is_rate(model, coordinate)) {
        Some(rate) => Ok(fit_rate(quick, model, (rate.clone(), START_RATE_TOLERANCE))?.1),
        None => Ok(model.clone()),
    }
}

/// Other values of the laws from which to fit: every ratio but the rate a factor larger and smaller, for a fit does not
/// find its way from the valley of a soft contact to that of a stiff one. Places that cannot be simulated are left out.
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
