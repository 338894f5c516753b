//! Judging proposals: the first that fits, those that a welder can lay from above before those overhead.

use rayon::prelude::*;

use crate::access::access;
use crate::bead::BeadProfile;
use crate::exposure::exposures;
use crate::propose::{Candidate, Proposals, Refused};
use crate::rejection::{Rejection, Tally};

/// Proposals judged side by side at most; the first that fits wins, so the number of threads changes nothing.
const LARGEST_BATCH: usize = 32;
/// Proposals judged after one that fits and faces down, for one that does not. Where a twentieth of the proposals fit
/// otherwise, one in thirty such searches finds none.
const UPRIGHT_ATTEMPTS: usize = 64;
/// Rays per point of a placed weld.
const MEASURING_RAYS: u32 = 256;
/// Distance kept from the ends of the range of exposure, so that a finer measurement does not fall out of it.
const EXPOSURE_MARGIN: f64 = 0.01;

/// The first proposal in order that fits and does not face down; one that does where no other is found soon. The dropped
/// ones before it are counted.
///
/// Batches start small and double: on most parts one of the first few fits.
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

/// Measures what the curve's points record; exposure and access are now known well enough to hold them against the dials.
fn measure(proposals: &Proposals, mut candidate: Candidate) -> Result<Candidate, Refused> {
    let refuse = |why| Err(Refused { why, run: proposals.wanted.length });
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

/// A range of exposure without its ends, but for 0 and 1, which nothing passes.
fn within([low, high]: [f64; 2]) -> [f64; 2] {
    let margin = EXPOSURE_MARGIN.min(0.25 * (high - low));
    [if low > 0.0 { low + margin } else { low }, if high < 1.0 { high - margin } else { high }]
}
