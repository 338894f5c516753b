//! The dials of a weld, measured again with more rays than in its placement.

use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::query::MeshQuery;
use weldgen::exposure::{ExposureRays, exposures};

use crate::asset::{Check, WELDS_FILE, WeldTruth, Welds};

/// Rays at each point: 16 times as many as in the placement of the weld.
const RAYS: u32 = 16 * 256;
/// Greatest number of points measured again, the least exposed first.
const POINTS: usize = 16;
/// Height of the rays' origins above the surface [heights of a bead on a face].
const LIFT: f64 = 0.05;

pub(super) fn check(truth: &Welds, part: &Mesh) -> Vec<Check> {
    let query = MeshQuery::new(part);
    truth.welds.iter().map(|weld| check_exposure(weld, &query)).collect()
}

/// Checks that the least exposure along a weld lies within the requested range, unless the range was relaxed.
fn check_exposure(weld: &WeldTruth, query: &MeshQuery) -> Check {
    let [low, high] = weld.requested.exposure;
    let rule = format!("weld {}: {RAYS} rays find its exposure within {low} to {high}", weld.id);
    let stated = weld.exposure_min;
    if !(low..=high).contains(&stated) {
        return Check::new(WELDS_FILE, rule, true, format!("the range was relaxed: {WELDS_FILE} states {stated}"));
    }
    let height = weld.width_mm * weld.requested.height_mm / weld.requested.width_mm;
    let (reach, lift) = (1e-3 * weld.requested.exposure_reach_mm, 1e-3 * LIFT * height);
    let curve = &weld.curve;
    let mut places: Vec<(f64, (DVec3, DVec3))> =
        curve.exposure.iter().copied().zip(curve.position.iter().copied().zip(curve.normal.iter().copied())).collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let darkest: Vec<(DVec3, DVec3)> = places.into_iter().take(POINTS).map(|(_, place)| place).collect();
    let found = exposures(query, &darkest, ExposureRays { reach, lift, rays: RAYS });
    let least = found.into_iter().fold(1.0, f64::min);
    Check::new(WELDS_FILE, rule, (low..=high).contains(&least), format!("{least:.4}; {WELDS_FILE} states {stated:.4}"))
}
