//! Placing a weld: proposals in stages, until one fits.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use sdf_bake::Mesh;
use sdf_bake::query::MeshQuery;
use serde::Serialize;
use thiserror::Error;

use crate::bead::BeadProfile;
use crate::curve::WeldCurve;
use crate::exposure::exposures;
use crate::propose::{Candidate, Proposals, Refused};
use crate::rejection::{Rejection, Tally};
use crate::request::{WIDTHS_PER_LENGTH, WeldRequest};
use crate::surface::Surface;

/// What is tried in turn when nothing fits: factors of the length and of the bead's width and height.
///
/// The length never falls below three widths. Without leave to shrink, only the first stage is tried.
pub const STAGES: [[f64; 2]; 8] =
    [[1.0, 1.0], [0.7, 1.0], [0.5, 1.0], [0.35, 1.0], [0.5, 0.7], [0.35, 0.7], [0.35, 0.5], [0.2, 0.35]];

/// Proposals judged side by side at most; the first that fits wins, so the number of threads changes nothing.
const LARGEST_BATCH: usize = 32;
/// Rays per point of a placed weld.
const MEASURING_RAYS: u32 = 256;
/// Exposure asked beyond the minimum, so that a finer measurement does not fall below it.
const EXPOSURE_MARGIN: f64 = 0.01;

/// A weld on a part, and how it came about.
#[derive(Clone, Debug, Serialize)]
pub struct Weld {
    /// The centreline.
    pub curve: WeldCurve,
    /// The bead: closed, normals outwards [m].
    #[serde(skip)]
    pub bead: Mesh,
    /// The bead's cross-section.
    pub profile: BeadProfile,
    /// Depth of the bead's flat bottom below the tangent plane [m].
    pub root_depth: f64,
    /// Length of the centreline [m].
    pub length: f64,
    /// Volume of the bead's mesh [m³], most of it above the surface.
    pub bead_volume: f64,
    /// Root mean square of the geodesic curvature [1/m].
    pub curvature_rms: f64,
    /// Smallest exposure along the curve, in [0, 1].
    pub min_exposure: f64,
    /// The seed it was placed with.
    pub seed: u64,
    /// What was asked.
    pub request: WeldRequest,
    /// Proposals dropped before this one.
    pub dropped: Tally,
    /// What was chosen and why, in sentences.
    pub reasons: Vec<String>,
}

/// Why no weld was placed.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlaceError {
    /// A dial is out of range.
    #[error("{0}")]
    Request(String),
    /// The part has no face with an area.
    #[error("the part has no surface to weld on: {0} triangles without area")]
    NoSurface(usize),
    /// Nothing fits.
    #[error(
        "no place for the weld in {} proposals (length {:.2} mm, width {:.3} mm at last; longest clear run {:.2} mm): \
         {tally}",
        tally.total(), 1e3 * length, 1e3 * width, 1e3 * longest_run
    )]
    Nowhere {
        /// Length of the last stage [m].
        length: f64,
        /// Width of the last stage [m].
        width: f64,
        /// Longest run met without an edge in the way [m].
        longest_run: f64,
        /// How many proposals failed for which reason.
        tally: Tally,
    },
}

/// Chooses a weld curve on a part and sweeps a bead along it.
///
/// - `query`: the same mesh, prepared
/// - `seed`: another seed gives another weld; the same one gives the same weld for any number of threads
///
/// For several welds on one part, prepare a [`Surface`] once and call [`place_weld_on`].
pub fn place_weld(part: &Mesh, query: &MeshQuery, request: &WeldRequest, seed: u64) -> Result<Weld, PlaceError> {
    place_weld_on(&Surface::new(part, query), request, seed)
}

/// As [`place_weld`], on a prepared part.
pub fn place_weld_on(surface: &Surface, request: &WeldRequest, seed: u64) -> Result<Weld, PlaceError> {
    if surface.area() == 0.0 {
        return Err(PlaceError::NoSurface(surface.part.triangles.len()));
    }
    if let Some(fault) = request.fault() {
        return Err(PlaceError::Request(fault));
    }
    let wanted = wanted_length(request, seed);
    let (mut tally, mut longest_run, mut last) = (Tally::default(), 0f64, (0.0, 0.0));
    for (stage, (length, profile)) in stages(request, wanted).into_iter().enumerate() {
        let proposals = Proposals {
            surface,
            length,
            profile,
            curvature_rms: request.curvature_rms,
            curvature_max: request.curvature_max,
            sharp_angle: request.sharp_angle,
            min_exposure: request.min_exposure,
            exposure_reach: request.exposure_reach,
        };
        let seed_here = mix(seed, stage);
        if let Some(candidate) = first_fit(&proposals, request.attempts, seed_here, &mut tally, &mut longest_run) {
            return Ok(finish(&proposals, candidate, request, (wanted, seed), tally));
        }
        last = (length, profile.width);
    }
    Err(PlaceError::Nowhere { length: last.0, width: last.1, longest_run, tally })
}

/// The first proposal in order that fits; the dropped ones before it are counted.
///
/// Batches start small and double: on most parts one of the first few fits.
fn first_fit(
    proposals: &Proposals,
    attempts: usize,
    seed: u64,
    tally: &mut Tally,
    longest_run: &mut f64,
) -> Option<Candidate> {
    let (mut next, mut batch) = (0, 4);
    while next < attempts {
        let ids = next..(next + batch).min(attempts);
        (next, batch) = (ids.end, (2 * batch).min(LARGEST_BATCH));
        let judged: Vec<_> = ids.into_par_iter().map(|i| proposals.propose(mix(seed, i))).collect();
        for outcome in judged {
            match outcome.and_then(|candidate| measure(proposals, candidate)) {
                Ok(candidate) => return Some(candidate),
                Err(refused) => {
                    tally.count(refused.why);
                    *longest_run = longest_run.max(refused.run);
                }
            }
        }
    }
    None
}

/// Measures what the curve's points record; the exposure is now known well enough to hold it against the minimum.
fn measure(proposals: &Proposals, mut candidate: Candidate) -> Result<Candidate, Refused> {
    let places: Vec<_> = candidate.curve.points.iter().map(|point| (point.position, point.normal)).collect();
    let measured = exposures(proposals.surface.query, &places, proposals.rays(MEASURING_RAYS));
    for (point, exposure) in candidate.curve.points.iter_mut().zip(measured) {
        point.exposure = exposure;
        point.width = proposals.profile.width;
        point.height = proposals.profile.height;
    }
    let least = proposals.min_exposure;
    let asked = if least > 0.0 { (least + EXPOSURE_MARGIN).min(1.0) } else { 0.0 };
    match candidate.curve.min_exposure() >= asked {
        true => Ok(candidate),
        false => Err(Refused { why: Rejection::Exposure, run: proposals.length }),
    }
}

fn finish(
    proposals: &Proposals,
    Candidate { curve, bead, root_depth }: Candidate,
    request: &WeldRequest,
    (wanted, seed): (f64, u64),
    dropped: Tally,
) -> Weld {
    let mut reasons = request.reasons.clone();
    let (length, width) = (curve.length(), proposals.profile.width);
    if length < wanted * (1.0 - 1e-9) {
        reasons.push(format!("length {:.2} mm instead of {:.2} mm: nothing longer fitted", 1e3 * length, 1e3 * wanted));
    }
    if width < request.width {
        let (now, asked) = (1e3 * width, 1e3 * request.width);
        reasons.push(format!("bead width {now:.3} mm instead of {asked:.3} mm: nothing wider fitted"));
    }
    reasons.push(format!("placed with seed {seed} after {} dropped proposals", dropped.total()));
    Weld {
        length,
        bead_volume: bead.volume(),
        curvature_rms: curve.curvature_rms(),
        min_exposure: curve.min_exposure(),
        curve,
        bead,
        profile: proposals.profile,
        root_depth,
        seed,
        request: request.clone(),
        dropped,
        reasons,
    }
}

/// Lengths and sections to try in turn, without repeats.
fn stages(request: &WeldRequest, wanted: f64) -> Vec<(f64, BeadProfile)> {
    let count = if request.may_shrink { STAGES.len() } else { 1 };
    let mut stages: Vec<(f64, BeadProfile)> = Vec::new();
    for [length, bead] in &STAGES[..count] {
        let profile = BeadProfile::parabolic(bead * request.width, bead * request.height);
        let stage = ((length * wanted).max(wanted.min(WIDTHS_PER_LENGTH * profile.width)), profile);
        if !stages.contains(&stage) {
            stages.push(stage);
        }
    }
    stages
}

fn wanted_length(request: &WeldRequest, seed: u64) -> f64 {
    let [low, high] = request.length_range;
    let share: f64 = Pcg64Mcg::seed_from_u64(seed).random();
    request.length.unwrap_or(low + share * (high - low))
}

/// A seed from a seed and a number (splitmix64's finaliser).
fn mix(seed: u64, number: usize) -> u64 {
    let z = seed.wrapping_add((number as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
