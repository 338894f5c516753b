//! Checks of the ground truth against meshes and fields: the curve lies on the part, the labels hold the bead's volume.

use std::collections::BTreeSet;

use sdf_bake::query::MeshQuery;

use crate::asset::{
    AssetFields, Check, CurveTruth, MANIFEST_FILE, Manifest, Meshes, WELD_FILE, WELDS_FILE, WeldTruth, Welds,
};

/// Greatest distance of the centreline from the part's surface [m].
const ON_SURFACE: f64 = 1e-5;
/// Greatest relative difference between the volume of the labels and of the bead.
const VOLUME_TOLERANCE: f64 = 0.02;
/// Greatest relative difference between two copies of a number.
const ROUNDING: f64 = 1e-9;

pub(super) fn check(truth: &Welds, meshes: &Meshes, fields: &AssetFields) -> Vec<Check> {
    let query = MeshQuery::new(&meshes.part.mesh);
    let mut checks = Vec::new();
    for weld in &truth.welds {
        checks.push(check_numbers(weld));
        checks.push(check_figures(weld));
        checks.push(check_surface(weld, &query));
        checks.push(check_volume(weld, fields));
    }
    checks
}

/// Checks that ground truth, beads and labels name the same welds.
pub(super) fn check_ids(truth: &Welds, meshes: &Meshes, fields: &AssetFields) -> Check {
    let sorted = |mut ids: Vec<u16>| {
        ids.sort_unstable();
        ids
    };
    let stated = sorted(truth.welds.iter().map(|weld| weld.id).collect());
    let swept = sorted(meshes.beads().map(|bead| bead.weld_id).collect());
    let labelled: BTreeSet<u16> = fields.welded.label.iter().copied().filter(|&id| id != 0).collect();
    let one_each = !stated.is_empty() && stated.windows(2).all(|pair| pair[0] < pair[1]);
    let passed = one_each && stated == swept && labelled.iter().eq(&stated);
    let found = format!("weld ids: truth {stated:?}, beads {swept:?}, labels {labelled:?}");
    Check::new(WELDS_FILE, "truth, beads and labels name the same weld ids, each once", passed, found)
}

/// Checks that the manifest repeats the numbers of the ground truth.
pub(super) fn check_manifest(truth: &Welds, manifest: &Manifest) -> Vec<Check> {
    let sum = |figure: fn(&WeldTruth) -> f64| truth.welds.iter().map(figure).sum::<f64>();
    let figures = [("weld_volume_mm3", sum(|weld| weld.volume_mm3)), ("weld_length_mm", sum(|weld| weld.length_mm))];
    let check = |(name, expected): (&str, f64)| {
        let stated = manifest.checks.get(name).copied().unwrap_or(f64::NAN);
        let found = format!("{stated}, {expected} in {WELDS_FILE}");
        Check::new(MANIFEST_FILE, format!("{name} agrees with {WELDS_FILE}"), agree(stated, expected), found)
    };
    figures.map(check).into()
}

/// Returns true if two numbers are equal up to rounding.
fn agree(one: f64, two: f64) -> bool {
    (one - two).abs() <= ROUNDING * one.abs().max(two.abs()).max(ROUNDING)
}

/// Checks that the numbers of a weld follow from its centreline.
fn check_figures(weld: &WeldTruth) -> Check {
    let curve = &weld.curve;
    let count = curve.position.len().max(1) as f64;
    let length = curve.arc_length.last().copied().unwrap_or(f64::NAN);
    let halves = curve.geodesic_curvature.windows(2).map(|pair| 0.5 * (pair[0] * pair[0] + pair[1] * pair[1]));
    let squares = halves.sum::<f64>() / (count - 1.0).max(1.0);
    let largest = curve.geodesic_curvature.iter().map(|k| k.abs()).fold(0.0, f64::max);
    let figures = [
        ("length_mm", weld.length_mm, length * 1e3),
        ("exposure_mean", weld.exposure_mean, curve.exposure.iter().sum::<f64>() / count),
        ("exposure_min", weld.exposure_min, curve.exposure.iter().copied().fold(1.0, f64::min)),
        ("geodesic_curvature_rms_per_m", weld.geodesic_curvature_rms_per_m, squares.sqrt()),
        ("access_mean", weld.access_mean, curve.access.iter().sum::<f64>() / count),
        ("geodesic_curvature_max_per_m", weld.geodesic_curvature_max_per_m, largest),
    ];
    let wrong: Vec<String> = figures
        .iter()
        .filter(|&&(_, stated, follows)| !agree(stated, follows))
        .map(|(name, stated, follows)| format!("{name} is {stated}, and {follows} follows from the centreline"))
        .collect();
    let found = if wrong.is_empty() { "they do".to_owned() } else { wrong.join("; ") };
    Check::new(WELDS_FILE, format!("weld {}: its figures follow from its centreline", weld.id), wrong.is_empty(), found)
}

fn check_numbers(weld: &WeldTruth) -> Check {
    let rule = format!("weld {} has finite numbers, unit frames, growing arc length, one entry per point", weld.id);
    let sizes = [weld.width_mm, weld.height_mm, weld.length_mm, weld.volume_mm3];
    let shares = weld.curve.exposure.iter().chain(&weld.curve.access).all(|share| (0.0..=1.0).contains(share));
    let grows = weld.curve.arc_length.windows(2).all(|pair| pair[0] < pair[1]);
    let steps = weld.curve.arc_length.windows(2).zip(weld.curve.position.windows(2));
    let reached = steps.into_iter().all(|(s, p)| p[0].distance(p[1]) <= (s[1] - s[0]) * (1.0 + 1e-6) + 1e-12);
    let positive = sizes.iter().all(|&size| size > 0.0 && size.is_finite());
    let passed = positive && shares && grows && reached && is_complete(&weld.curve) && is_framed(&weld.curve);
    Check::new(WELDS_FILE, rule, passed, format!("{} points", weld.curve.position.len()))
}

fn is_complete(curve: &CurveTruth) -> bool {
    let count = curve.position.len();
    let vectors = [&curve.position, &curve.tangent, &curve.normal, &curve.side];
    let scalars =
        [&curve.arc_length, &curve.geodesic_curvature, &curve.exposure, &curve.access, &curve.width, &curve.height];
    count >= 2
        && vectors.iter().all(|list| list.len() == count && list.iter().all(|v| v.is_finite()))
        && scalars.iter().all(|list| list.len() == count && list.iter().all(|x| x.is_finite()))
}

/// Checks that the axes are unit vectors with side = normal × tangent.
fn is_framed(curve: &CurveTruth) -> bool {
    let axes = curve.tangent.iter().zip(&curve.normal).zip(&curve.side);
    axes.into_iter().all(|((tangent, normal), side)| {
        (tangent.length() - 1.0).abs() < 1e-6
            && (normal.length() - 1.0).abs() < 1e-6
            && normal.cross(*tangent).distance(*side) < 1e-6
    })
}

fn check_surface(weld: &WeldTruth, query: &MeshQuery) -> Check {
    let off = weld.curve.position.iter().map(|&p| query.closest(p).distance).fold(0.0, f64::max);
    let rule = format!("weld {}: the curve lies on the part within {} mm", weld.id, ON_SURFACE * 1e3);
    Check::new(WELDS_FILE, rule, off <= ON_SURFACE, format!("at most {:.2e} mm off", off * 1e3))
}

fn check_volume(weld: &WeldTruth, fields: &AssetFields) -> Check {
    let voxels: f64 = fields
        .share
        .iter()
        .zip(&fields.welded.label)
        .filter(|&(_, &id)| id == weld.id)
        .map(|(&share, _)| f64::from(share))
        .sum();
    let labelled = voxels * fields.welded.voxel.powi(3) * 1e9;
    let apart = (labelled / weld.volume_mm3 - 1.0).abs();
    let rule = format!("weld {}: the labels hold the bead's volume within {} %", weld.id, 100.0 * VOLUME_TOLERANCE);
    let found = format!("{labelled:.3} mm³ labelled, bead {:.3} mm³: {:.2} % apart", weld.volume_mm3, 100.0 * apart);
    Check::new(WELD_FILE, rule, apart <= VOLUME_TOLERANCE, found)
}
