//! Costs, whose fall is the reward, and the ends of an episode.

use effects::Signal;

use crate::strip::Strip;
use crate::task::Task;

/// Cost of volume below the target, relative to volume above it [1].
const GOUGE: f64 = 5.0;
/// Cost of an oversanded point, relative to an unsanded point [1].
const OVERSANDED: f64 = 0.5;
/// Dose at which the coating is gone [1].
pub(crate) const SANDED: f32 = 1.0;
/// Dose from which a point is oversanded [1].
pub(crate) const OVERSANDED_DOSE: f32 = 4.0;
/// Remaining share of the bead, or of the coated strip, at which a task is done.
const DONE: f64 = 0.03;
/// Depth below the target at which an episode ends [m].
const DEEPEST: f64 = 1e-3;

/// Returns the cost: the remaining share, plus the weighted share of gouges or oversanding.
pub(crate) fn cost(task: &Task, strip: &Strip) -> f64 {
    match task.process.signal() {
        Signal::Height => {
            let [above, below] = strip.volumes();
            (above + GOUGE * below) / task.volume
        }
        Signal::Dose => 1.0 - strip.share_dosed(SANDED) + OVERSANDED * strip.share_dosed(OVERSANDED_DOSE),
    }
}

/// Returns the remaining share of the bead or of the coated strip.
pub(crate) fn left(task: &Task, strip: &Strip) -> f64 {
    match task.process.signal() {
        Signal::Height => strip.volumes()[0] / task.volume,
        Signal::Dose => 1.0 - strip.share_dosed(SANDED),
    }
}

/// Returns true if the task is done.
pub(crate) fn is_done(task: &Task, strip: &Strip) -> bool {
    left(task, strip) <= DONE
}

/// Returns true if the part is spoilt.
pub(crate) fn is_spoilt(strip: &Strip) -> bool {
    strip.deepest() >= DEEPEST
}
