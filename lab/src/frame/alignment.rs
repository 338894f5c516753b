//! Logs that lie far from where the scans show the tool are moved there before any fit: what is left is small enough for
//! every fit to take it as a degree of freedom.

use effects::{CompiledModel, Library, Model, Process};
use nalgebra::DVector;
use trials::trial::Trial;

use super::estimate::{Arms, Judged};
use super::posterior::Linear;
use super::{FrameFreedom, FrameValues, QUANTITIES, frame_offset, middle};
use crate::calibrate::fit_roughly;
use crate::criteria::{COARSE_VOXEL_RATIO, FRAME_REACH, FRAME_SETTLED};
use crate::error::Result;
use crate::evidence::Evidence;
use crate::scans::ScanEvidence;

/// Most times that logs are moved.
const MOST_MOVES: usize = 6;

/// The trials of a campaign with their logs moved to where the scans show the tool; `None` where they are near enough.
///
/// # Errors
/// When the model cannot be simulated.
pub fn aligned(trials: &[Trial], model: &Model, library: &Library) -> Result<Option<Vec<Trial>>> {
    let arms = Arms::of(&trials.iter().collect::<Vec<_>>());
    let (mut place, mut placed) = ([0.0; QUANTITIES], trials.to_vec());
    for _ in 0..MOST_MOVES {
        let shown = shown(&placed, model, library)?;
        let by = std::array::from_fn(|k| shown[k] - place[k]);
        if arms.way(by) <= if place == [0.0; QUANTITIES] { FRAME_REACH } else { FRAME_SETTLED } {
            break;
        }
        place = shown;
        let frame_offset = frame_offset(place, middle(&trials[0]));
        placed = trials.iter().map(|trial| frame_offset.of_trial(trial)).collect();
    }
    Ok((arms.way(place) > FRAME_REACH).then_some(placed))
}

/// Where the scans show the logs, which may be moved already, beside a rough fit of a model and any smooth change of its
/// removal.
fn shown(trials: &[Trial], model: &Model, library: &Library) -> Result<FrameValues> {
    let evidence = coarse(trials)?;
    let model = CompiledModel::new(model, library, evidence.rows())?;
    let fit = fit_roughly(&evidence, &model)?;
    let fitted = &fit.model;
    let columns = FrameFreedom::new(&evidence, fitted)?.columns;
    let residuals = DVector::from_vec(evidence.as_logged(fitted)?);
    let linear = Linear { residuals, columns, beside: evidence.beside_frame(&fit) };
    Ok(Judged::new(linear, evidence.logs_moved(), &trials.iter().collect::<Vec<_>>()).place)
}

/// Scans with a simulation on voxels that are coarse, where the tool allows them: a place needs no finer ones.
fn coarse(trials: &[Trial]) -> Result<ScanEvidence<'_>> {
    let voxel = COARSE_VOXEL_RATIO * trials[0].scans.before.pixels.pitch;
    let grinds = trials[0].process == Process::Grinding;
    let usual = |_| ScanEvidence::new(trials, None);
    Ok(ScanEvidence::new(trials, grinds.then_some(voxel)).or_else(usual)?)
}
