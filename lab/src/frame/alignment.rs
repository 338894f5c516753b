//! Alignment of logs that lie far from where the scans show the tool. They are moved before any fit, so that every fit
//! can treat the remaining offset as a degree of freedom.

use effects::{CompiledModel, Library, Model, Signal};
use nalgebra::DVector;
use trials::trial::Trial;

use super::estimate::{Arms, Judged};
use super::posterior::Linear;
use super::rivals::rivals;
use super::{FrameFreedom, FrameValues, QUANTITIES, frame_offset, middle};
use crate::calibrate::fit_roughly;
use crate::criteria::{COARSE_VOXEL_RATIO, FRAME_REACH, FRAME_SETTLED};
use crate::diagnose::with_values;
use crate::error::Result;
use crate::evidence::Evidence;
use crate::scans::ScanEvidence;

/// Most iterations of the alignment.
const MOST_MOVES: usize = 6;

/// Returns the trials of a campaign with their logs moved to where the scans show the tool; `None` where they are near
/// enough. The offset is sought on coarse voxels and confirmed on the usual ones.
///
/// # Errors
/// If the model cannot be simulated.
pub fn aligned(trials: &[Trial], model: &Model, library: &Library) -> Result<Option<Vec<Trial>>> {
    let arms = Arms::of(&trials.iter().collect::<Vec<_>>());
    let mut search = Search { trials, model: model.clone(), library, arms };
    let voxel = COARSE_VOXEL_RATIO * trials[0].scans.before.pixels.pitch;
    let mut place = [0.0; QUANTITIES];
    if trials[0].process.signal() == Signal::Height {
        place = search.settled(place, Some(voxel))?;
        if !search.is_far(place) {
            return Ok(None);
        }
    }
    let place = search.settled(place, None)?;
    Ok(search.is_far(place).then(|| search.placed(place)))
}

/// Search for the frame offset of a campaign.
struct Search<'a> {
    trials: &'a [Trial],
    /// The model with the values of the latest fit, at which the next one starts: a small move of the logs changes them
    /// little.
    model: Model,
    library: &'a Library,
    arms: Arms,
}

impl Search<'_> {
    fn is_far(&self, place: FrameValues) -> bool {
        self.arms.way(place) > FRAME_REACH
    }

    fn placed(&self, place: FrameValues) -> Vec<Trial> {
        let frame_offset = frame_offset(place, middle(&self.trials[0]));
        self.trials.iter().map(|trial| frame_offset.of_trial(trial)).collect()
    }

    /// Root mean square displacement of the pressing tool from one offset to another [m].
    fn way_between(&self, from: FrameValues, to: FrameValues) -> f64 {
        let by = std::array::from_fn(|k| to[k] - from[k]);
        let logs = self.trials.iter().flat_map(|trial| &trial.passes).map(|pass| &pass.log);
        frame_offset(by, middle(&self.trials[0])).displacement(logs)
    }

    /// Moves the logs until the offset converges. On coarse voxels it need only come within reach of the search on the
    /// usual ones, and the last offset is returned if it does not; there, zero offset is.
    ///
    /// - `voxel`: voxel of the simulation; `None` takes the usual one
    fn settled(&mut self, mut place: FrameValues, voxel: Option<f64>) -> Result<FrameValues> {
        let is_rough = voxel.is_some();
        let near = if is_rough { FRAME_REACH } else { FRAME_SETTLED };
        let mut ways = Vec::new();
        while ways.len() < MOST_MOVES && (is_rough || may_settle(&ways, near)) {
            let shown = self.shown(&self.placed(place), voxel)?;
            ways.push(self.way_between(place, shown));
            if ways[ways.len() - 1] <= near || !(self.is_far(place) || self.is_far(shown)) {
                return Ok(shown);
            }
            place = shown;
        }
        Ok(if is_rough { place } else { [0.0; QUANTITIES] })
    }

    /// Offset of the logs, which may have been moved already, given the scans, beside a rough fit of the model, each
    /// effect of the library and any smooth change of the removal.
    ///
    /// - `voxel`: voxel of the simulation; `None` takes the usual one
    fn shown(&mut self, trials: &[Trial], voxel: Option<f64>) -> Result<FrameValues> {
        let usual = |_| ScanEvidence::new(trials, None);
        let mut evidence = ScanEvidence::new(trials, voxel).or_else(usual)?;
        let model = CompiledModel::new(&self.model, self.library, evidence.rows())?;
        if voxel.is_none() {
            evidence.limit_steps(&model)?;
        }
        let fit = fit_roughly(&evidence, &model)?;
        self.model = with_values(&self.model, &fit);
        let columns = FrameFreedom::new(&evidence, &fit.model)?.columns;
        let residuals = DVector::from_vec(evidence.as_logged(&fit.model)?);
        let linear = Linear { residuals, columns, beside: evidence.beside_frame(&fit) };
        let trials: Vec<&Trial> = trials.iter().collect();
        let logs_moved = evidence.logs_moved();
        let judged = |rivals: &[_]| Judged::new(linear.clone(), rivals, (logs_moved, &trials));
        // Rivals can only weaken the evidence for an offset.
        let without = judged(&[]).place;
        if without == [0.0; QUANTITIES] {
            return Ok(without);
        }
        // A rough fit may pass through models that take more steps than a rival is given.
        evidence.abandon_longer(&fit.model)?;
        Ok(judged(&rivals(&evidence, (&self.model, &fit), self.library)?).place)
    }
}

/// True if moves of these lengths may come to one of at most `near` [m] within [`MOST_MOVES`]: each further one shortens
/// them at least as much as the best so far. Two moves do not tell yet.
fn may_settle(ways: &[f64], near: f64) -> bool {
    let [.., _, _, last] = ways else { return true };
    let best = ways.windows(2).map(|pair| pair[1] / pair[0]).fold(1.0, f64::min);
    last * best.powi((MOST_MOVES - ways.len()) as i32) <= near
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moves_that_hardly_shorten_are_given_up() {
        let near = 0.05e-3;
        assert!(may_settle(&[1e-3, 0.9e-3], near), "two do not tell");
        assert!(!may_settle(&[1e-3, 0.62e-3, 0.61e-3], near), "by the sixth they are still 0.15 mm long");
        assert!(may_settle(&[1e-3, 0.3e-3, 0.2e-3], near));
        assert!(may_settle(&[1e-3, 1.2e-3, 0.3e-3, 0.1e-3], near), "they may grow at first");
    }
}
