//! The truth file against meshes and fields: the curve is on the part, the labels hold the bead's volume.

use sdf_bake::query::MeshQuery;

use super::Check;
use super::meshes::Meshes;
use crate::asset::{AssetFields, CurveTruth, WELD_FILE, WELDS_FILE, WeldTruth, Welds};

/// Largest distance of the centreline from the part's surface [m].
const ON_SURFACE: f64 = 1e-5;
/// Largest relative difference between the volume of the labels and of the bead.
const VOLUME_TOLERANCE: f64 = 0.02;

pub(super) fn check(truth: &Welds, meshes: &Meshes, fields: &AssetFields) -> Vec<Check> {
    let query = MeshQuery::new(&meshes.part.mesh);
    let mut checks = Vec::new();
    for weld in &truth.welds {
        checks.push(check_numbers(weld));
        checks.push(check_surface(weld, &query));
        checks.push(check_volume(weld, fields));
        let known = meshes.beads().any(|bead| bead.weld_id == weld.id);
        let found = if known { "present" } else { "absent" };
        checks.push(Check::new(WELDS_FILE, format!("weld {} has a bead in welded.glb", weld.id), known, found));
    }
    checks
}

fn check_numbers(weld: &WeldTruth) -> Check {
    let rule = format!("weld {} has finite numbers, unit frames and one entry per point", weld.id);
    let sizes = [weld.width_mm, weld.height_mm, weld.length_mm, weld.volume_mm3];
    let positive = sizes.iter().all(|&size| size > 0.0 && size.is_finite());
    let passed = positive && is_complete(&weld.curve) && is_framed(&weld.curve);
    Check::new(WELDS_FILE, rule, passed, format!("{} points", weld.curve.position.len()))
}

fn is_complete(curve: &CurveTruth) -> bool {
    let count = curve.position.len();
    let vectors = [&curve.position, &curve.tangent, &curve.normal, &curve.side];
    let scalars = [&curve.arc_length, &curve.geodesic_curvature, &curve.exposure];
    count >= 2
        && vectors.iter().all(|list| list.len() == count && list.iter().all(|v| v.is_finite()))
        && scalars.iter().all(|list| list.len() == count && list.iter().all(|x| x.is_finite()))
}

/// Unit axes with side = normal × tangent.
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
