//! Placing a weld: proposals in stages, until one fits.

use std::sync::Arc;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::Mesh;
use sdf_bake::query::MeshQuery;
use serde::Serialize;

use crate::bead::defect::Ground;
use crate::bead::{BeadProfile, Defect};
use crate::curve::WeldCurve;
use crate::fit::first_fit;
use crate::offers::offers;
pub use crate::place_error::PlaceError;
use crate::propose::{Candidate, OccupiedArea, Proposals, mix};
use crate::rejection::Tally;
use crate::request::{Joint, Placement, WIDTHS_PER_LENGTH, WeldRequest};
use crate::stitch::stitched;
use crate::strata::ExposureField;
use crate::surface::Surface;

/// Stages tried in turn if no weld of the requested lengths fits: factors on the length, and on the bead's width and
/// height.
///
/// The length stays at least three widths. Without permission to shrink, no stage is tried.
pub const STAGES: [[f64; 2]; 8] =
    [[1.0, 1.0], [0.7, 1.0], [0.5, 1.0], [0.35, 1.0], [0.5, 0.7], [0.35, 0.7], [0.35, 0.5], [0.2, 0.35]];

/// A weld on a part, and how it was chosen.
#[derive(Clone, Debug, Serialize)]
pub struct Weld {
    /// The centreline.
    pub curve: WeldCurve,
    /// The bead's closed mesh, normals outwards [m]; drops of spatter are closed bodies beside it.
    #[serde(skip)]
    pub bead: Mesh,
    /// Closed bodies [m] that imperfections remove from bead and part, normals outwards.
    #[serde(skip)]
    pub cuts: Mesh,
    /// Kind of joint.
    pub joint: Joint,
    /// The bead's cross-section.
    pub profile: BeadProfile,
    /// Depth of the bead's flat bottom below the tangent plane [m].
    pub root_depth: f64,
    /// Length of the centreline [m].
    pub length: f64,
    /// Volume of the bead's mesh [m³] without spatter, most of it above the surface.
    pub bead_volume: f64,
    /// Root mean square of the geodesic curvature [1/m].
    pub curvature_rms: f64,
    /// Smallest exposure along the curve, in [0, 1].
    pub min_exposure: f64,
    /// Mean tool access along the curve, in [0, 1].
    pub mean_access: f64,
    /// Requested imperfections, with their actual sizes.
    pub defects: Vec<Defect>,
    /// Index of its curve; the beads of an intermittent weld share one.
    pub run: usize,
    /// Seed of its placement.
    pub seed: u64,
    /// Request that it was placed for.
    pub request: WeldRequest,
    /// Dials drawn for this weld.
    pub wanted: DrawnDials,
    /// Proposals rejected before this one.
    pub dropped: Tally,
    /// Choices made, with reasons, as sentences.
    pub reasons: Vec<String>,
}

impl Weld {
    /// Area [m²] between the toes in the tangent planes, including both round ends: ∫ w ds + π w²/4.
    pub fn footprint_area(&self) -> f64 {
        let between = self
            .curve
            .points
            .windows(2)
            .map(|pair| 0.5 * (pair[0].width + pair[1].width) * (pair[1].arc_length - pair[0].arc_length));
        let ends = [self.curve.points.first(), self.curve.points.last()];
        let half_discs = ends.iter().flatten().map(|end| 0.125 * std::f64::consts::PI * end.width * end.width);
        between.sum::<f64>() + half_discs.sum::<f64>()
    }
}

/// Dials of one weld, drawn with the seed from the request's ranges; the length may be a smaller one of its range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DrawnDials {
    /// Length of the centreline [m].
    pub length: f64,
    /// Root mean square of the geodesic curvature [1/m].
    pub curvature_rms: f64,
    /// Range of the least exposure along the curve.
    pub exposure: [f64; 2],
}

/// Chooses a weld curve on a part and sweeps a bead along it.
///
/// - `query`: the same mesh, prepared
/// - `seed`: different seeds give different welds; equal seeds give equal welds for any number of threads
///
/// For several welds on one part, prepare a [`Surface`] once and call [`place_weld_on`].
pub fn place_weld(part: &Mesh, query: &MeshQuery, request: &WeldRequest, seed: u64) -> Result<Weld, PlaceError> {
    place_weld_on(&Surface::new(part, query), request, seed)
}

/// [`place_weld`] on a prepared part.
pub fn place_weld_on(surface: &Surface, request: &WeldRequest, seed: u64) -> Result<Weld, PlaceError> {
    place_beside(surface, request, &[], seed)
}

/// Places several welds on one part that keep `request.gap` from each other; the first is that of [`place_weld_on`].
///
/// # Errors
/// If one of them does not fit beside the previous ones.
pub fn place_welds_on(
    surface: &Surface,
    request: &WeldRequest,
    count: usize,
    seed: u64,
) -> Result<Vec<Weld>, PlaceError> {
    let (mut welds, mut taken) = (Vec::new(), Vec::new());
    for number in 0..count {
        let seed = if number == 0 { seed } else { mix(seed, usize::MAX - number) };
        let weld = place_beside(surface, request, &taken, seed)?;
        taken.push(OccupiedArea::by(&weld));
        match request.stitch {
            None => welds.push(Weld { run: number, ..weld }),
            Some(stitch) => welds.extend(stitched(&Weld { run: number, ..weld }, stitch, surface)?),
        }
    }
    Ok(welds)
}

fn place_beside(
    surface: &Surface,
    request: &WeldRequest,
    taken: &[OccupiedArea],
    seed: u64,
) -> Result<Weld, PlaceError> {
    let (field, offered) = admit(surface, request)?;
    let wanted = draw(request, seed);
    let mut refused = PlaceError::Exposure { asked: request.exposure, offered, reach: request.exposure_reach };
    let tries = ways(request, seed).into_iter().flat_map(|way| exposures_to_try(request).map(move |e| (way, e)));
    for (along_seams, exposure) in tries {
        if along_seams && surface.seams().is_empty() {
            refused = PlaceError::NoSeam;
            continue;
        }
        let starts = field.starts(exposure);
        if starts.is_empty() && !along_seams {
            continue;
        }
        let search = Search { surface, request, taken, field: &field, starts: &starts, along_seams };
        match search.place(&DrawnDials { exposure, ..wanted }, seed) {
            Err(error) => refused = error,
            Ok(mut weld) => {
                if exposure != request.exposure {
                    weld.reasons.push(other_exposure(&weld, offered));
                }
                return Ok(Weld { wanted: DrawnDials { exposure: wanted.exposure, ..weld.wanted }, ..weld });
            }
        }
    }
    Err(refused)
}

/// Rejects impossible requests. Returns the part's exposure field and its range.
fn admit(surface: &Surface, request: &WeldRequest) -> Result<(Arc<ExposureField>, [f64; 2]), PlaceError> {
    if surface.area() == 0.0 {
        return Err(PlaceError::NoSurface(surface.part.triangles.len()));
    }
    request.check()?;
    let field = surface.exposure_field(request.exposure_reach);
    let offered = field.range().ok_or(PlaceError::Hidden)?;
    Ok((field, offered))
}

/// The requested exposure range, and the full range if relaxing is allowed.
fn exposures_to_try(request: &WeldRequest) -> impl Iterator<Item = [f64; 2]> + use<> {
    let any = [0.0, 1.0];
    let second = (request.may_shrink && request.exposure != any).then_some(any);
    std::iter::once(request.exposure).chain(second)
}

fn other_exposure(weld: &Weld, [least, most]: [f64; 2]) -> String {
    let [low, high] = weld.request.exposure;
    format!(
        "exposure {:.2} instead of {low:.2} to {high:.2}: the part offers {least:.2} to {most:.2}, and nothing within fitted",
        weld.min_exposure
    )
}

/// A request on a part, and the possible starts of its welds.
pub(crate) struct Search<'a> {
    pub(crate) surface: &'a Surface<'a>,
    pub(crate) request: &'a WeldRequest,
    /// Welds already placed.
    pub(crate) taken: &'a [OccupiedArea],
    pub(crate) field: &'a ExposureField,
    /// Strata in which welds may start.
    pub(crate) starts: &'a [u32],
    /// True if the welds follow seams.
    pub(crate) along_seams: bool,
}

impl Search<'_> {
    /// Tries the stages in order.
    fn place(&self, wanted: &DrawnDials, seed: u64) -> Result<Weld, PlaceError> {
        let (mut tally, mut longest_run) = (Tally::default(), 0f64);
        let stages = stages(self.request, wanted.length);
        for (stage, &(length, profile)) in stages.iter().enumerate() {
            let proposals = self.proposals(&DrawnDials { length, ..*wanted }, profile);
            let seed_here = mix(seed, stage);
            let (attempts, run) = (self.request.attempts, &mut longest_run);
            if let Some(candidate) = first_fit(&proposals, attempts, seed_here, &mut tally, run) {
                return Ok(finish(&proposals, candidate, (wanted, seed), tally));
            }
        }
        let (length, profile) = stages[stages.len() - 1];
        let offers = offers(self, &DrawnDials { length, ..*wanted }, profile, seed);
        Err(PlaceError::Nowhere { length, width: profile.width, longest_run, tally, offers })
    }

    pub(crate) fn proposals(&self, wanted: &DrawnDials, profile: BeadProfile) -> Proposals<'_> {
        Proposals { search: self, wanted: *wanted, profile }
    }
}

fn finish(
    proposals: &Proposals,
    Candidate { curve, mut bead, root_depth, profile, form, cuts }: Candidate,
    (wanted, seed): (&DrawnDials, u64),
    dropped: Tally,
) -> Weld {
    let request = proposals.search.request;
    let (length, width) = (curve.length(), profile.width);
    let mut reasons = request.reasons.clone();
    // Any length within the range is as requested.
    let asked = if length >= request.length[0] * (1.0 - 1e-9) { length } else { wanted.length };
    if asked < wanted.length * (1.0 - 1e-9) {
        let (now, drawn) = (1e3 * length, 1e3 * wanted.length);
        reasons.push(format!("length {now:.2} mm: the {drawn:.2} mm drawn first from the range asked did not fit"));
    }
    reasons.extend(shrunk([length, width], [asked, request.width]));
    if curve.faces_down() {
        reasons.push("faces down: no other proposal of this size fitted from above or from the side".to_owned());
    }
    reasons.push(format!("placed with seed {seed} after {} dropped proposals", dropped.total()));
    let bead_volume = bead.volume();
    let base = request.form.half_reach(profile.half_width_at(root_depth));
    let Surface { query, part, .. } = proposals.search.surface;
    let ground = Ground { curve: &curve, query, part, width, clear: base };
    let mut rng = Pcg64Mcg::seed_from_u64(mix(seed, usize::MAX));
    let (spattered, drops) = ground.spatter(request.form.spatter, &mut rng);
    bead.append(&drops);
    let defects = [&form.made_defects()[..], &spattered, &cuts.defects].concat();
    Weld {
        cuts: cuts.bodies,
        joint: proposals.joint(),
        length,
        bead_volume,
        curvature_rms: curve.curvature_rms(),
        min_exposure: curve.min_exposure(),
        mean_access: curve.mean_access(),
        curve,
        bead,
        profile,
        root_depth,
        defects,
        run: 0,
        seed,
        request: request.clone(),
        wanted: DrawnDials { length: asked, ..*wanted },
        dropped,
        reasons,
    }
}

/// Sentences for a length and width [m] below the requested ones.
fn shrunk([length, width]: [f64; 2], [long, wide]: [f64; 2]) -> Vec<String> {
    let mut reasons = Vec::new();
    if length < long * (1.0 - 1e-9) {
        let (now, asked) = (1e3 * length, 1e3 * long);
        reasons.push(format!("length {now:.2} mm instead of {asked:.2} mm: nothing longer fitted"));
    }
    if width < wide {
        let (now, asked) = (1e3 * width, 1e3 * wide);
        reasons.push(format!("bead width {now:.3} mm instead of {asked:.3} mm: nothing wider fitted"));
    }
    reasons
}

/// Lengths and sections to try in order, without repeats: first down to the least requested length, then below the
/// request.
fn stages(request: &WeldRequest, wanted: f64) -> Vec<(f64, BeadProfile)> {
    let section = |factor: f64| BeadProfile::on_face(request.shape, factor * request.width, factor * request.height);
    let least = request.length[0];
    let asked = [wanted, 0.5 * (wanted + least), least].map(|length| (length, section(1.0)));
    let smaller = |[length, bead]: &[f64; 2]| {
        let profile = section(*bead);
        ((length * wanted).max(wanted.min(WIDTHS_PER_LENGTH * profile.width)), profile)
    };
    let known = |(length, profile): &(f64, BeadProfile)| *length >= least && *profile == section(1.0);
    let relaxed = STAGES.iter().map(smaller).filter(|stage| request.may_shrink && !known(stage));
    let mut stages: Vec<(f64, BeadProfile)> = Vec::new();
    for stage in asked.into_iter().chain(relaxed) {
        if !stages.contains(&stage) {
            stages.push(stage);
        }
    }
    stages
}

/// Placements to try, in order; true for along seams.
fn ways(request: &WeldRequest, seed: u64) -> Vec<bool> {
    match request.placement {
        Placement::Surface | Placement::Butt => vec![false],
        Placement::Seam => vec![true],
        Placement::Mixed if mix(seed, 0).is_multiple_of(2) => vec![true, false],
        Placement::Mixed => vec![false, true],
    }
}

fn draw(request: &WeldRequest, seed: u64) -> DrawnDials {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let mut from = |[low, high]: [f64; 2]| low + rng.random::<f64>() * (high - low);
    DrawnDials { length: from(request.length), curvature_rms: from(request.curvature_rms), exposure: request.exposure }
}
