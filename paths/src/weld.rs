//! A path along a weld's crown.

use glam::DVec3;

use super::{Leg, Plan, PlanError, Waypoint};

/// Along the crown of a weld from its first to its last point, the approach axis across the curve.
///
/// - `positions`, `normals`: of the weld's curve on the part [m, unit], as many of each
/// - `height`: of the crown above the curve [m]
///
/// # Errors
/// [`PlanError::BadCurve`] when the curve has fewer than two points, or a normal along the curve.
pub fn along_weld(positions: &[DVec3], normals: &[DVec3], height: f64) -> Result<Plan, PlanError> {
    let count = positions.len().min(normals.len());
    if count < 2 {
        return Err(PlanError::BadCurve { point: 0, found: format!("{count} points with a normal") });
    }
    let mut points: Vec<Waypoint> = Vec::with_capacity(count);
    for k in 0..count {
        let along = positions[(k + 1).min(count - 1)] - positions[k.saturating_sub(1)];
        let approach = across(normals[k], along)
            .ok_or_else(|| PlanError::BadCurve { point: k, found: format!("normal {} along {along}", normals[k]) })?;
        let contact = positions[k] + approach * height;
        if points.last().is_none_or(|last| last.contact.distance(contact) > 1e-9) {
            points.push(Waypoint { contact, approach });
        }
    }
    Ok(Plan { legs: vec![Leg { points, pressed: true }] })
}

/// The part of a normal across a direction, unit.
fn across(normal: DVec3, along: DVec3) -> Option<DVec3> {
    let along = along.try_normalize()?;
    normal.reject_from_normalized(along).try_normalize().filter(|axis| axis.is_finite())
}
