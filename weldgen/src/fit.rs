//! Examines proposals and chooses the first that fits; welds from above are preferred to overhead ones.

use rayon::prelude::*;

use crate::access::access;
use crate::bead::BeadProfile;
use crate::exposure::exposures;
use crate::propose::{Candidate, Proposals, RejectedProposal};
use crate::rejection::{Rejection, Tally};

/// Greatest number of proposals examined in parallel; the first that fits is taken, so the result is independent of the
/// number of threads.
const LARGEST_BATCH: usize = 32;
/// Number of further proposals examined after the first one that fits and faces down, to find one that does not. If a
/// twentieth of the proposals fit otherwise, one in thirty such searches finds none.
const UPRIGHT_ATTEMPTS: usize = 64;
/// Rays per point of a placed weld.
const MEASURING_RAYS: u32 = 256;
/// Margin at the ends of the exposure range, so that a finer measurement does not leave the range.
const EXPOSURE_MARGIN: f64 = 0.01;

/// Returns the first proposal in order that fits and does not face down, or one that does if no other is found soon.
/// Rejected proposals before it are counted.
///
/// Batches start small and double: on most parts one of the first few proposals fits.
pub(crate) fn first_fit(
    proposals: &Proposals,
    attempts: usize,
    seed: u64,
    tally: &mut Tally,
    longest_run: &mut f64,
) -> Option<Candidate> {
    let (mut next, mut batch, mut end) = (0, 4, attempts);
    let mut overhead: Option<(Candidate, Tally)> = None;
    while next < end {
        let ids = next..(next + batch).min(end);
        (next, batch) = (ids.end, (2 * batch).min(LARGEST_BATCH));
        let judged: Vec<_> = ids.clone().into_par_iter().map(|i| proposals.propose(seed, i)).collect();
        for (id, outcome) in ids.zip(judged) {
            match outcome.and_then(|candidate| measure(proposals, candidate)) {
                Ok(candidate) if !candidate.curve.faces_down() => return Some(candidate),
                Ok(candidate) => {
                    if overhead.is_none() {
                        overhead = Some((candidate, tally.clone()));
                        end = end.min(id + 1 + UPRIGHT_ATTEMPTS);
                    }
                    tally.count(Rejection::Overhead);
                }
                Err(refused) => {
                    tally.count(refused.why);
                    *longest_run = longest_run.max(refused.run);
                }
            }
        }
    }
    let (candidate, before) = overhead?;
    *tally = before;
    Some(candidate)
}

/// Measures the properties recorded at the curve's points. Exposure and access are then accurate enough to compare with
/// the dials.
fn measure(proposals: &Proposals, mut candidate: Candidate) -> Result<Candidate, RejectedProposal> {
    let refuse = |why| Err(RejectedProposal { why, run: proposals.wanted.length });
    let BeadProfile { width, height, .. } = candidate.profile;
    let places: Vec<_> = candidate.curve.points.iter().map(|point| (point.position, point.normal)).collect();
    let measured = exposures(proposals.search.surface.query, &places, proposals.rays(MEASURING_RAYS));
    for (point, exposure) in candidate.curve.points.iter_mut().zip(measured) {
        point.exposure = exposure;
        point.width = width * candidate.form.width_factor(point.arc_length);
        point.height = height * candidate.form.height_factor(point.arc_length);
    }
    let [low, high] = within(proposals.wanted.exposure);
    match candidate.curve.min_exposure() {
        least if least < low => return refuse(Rejection::Exposure),
        least if least > high => return refuse(Rejection::TooOpen),
        _ => {}
    }
    let shares =
        access(proposals.search.surface.query, &candidate.curve, proposals.search.request.tool, [width, height]);
    for (point, access) in candidate.curve.points.iter_mut().zip(shares) {
        point.access = access;
    }
    if candidate.curve.mean_access() < proposals.search.request.min_access {
        return refuse(Rejection::Access);
    }
    Ok(candidate)
}

/// Shrinks a range of exposure by the margin, except at 0 and 1, which no exposure exceeds.
fn within([low, high]: [f64; 2]) -> [f64; 2] {
    let margin = EXPOSURE_MARGIN.min(0.25 * (high - low));
    [if low > 0.0 { low + margin } else { low }, if high < 1.0 { high - margin } else { high }]
}
