//! A path along a weld's crown.

use glam::DVec3;

use super::{Leg, Plan, PlanError, Waypoint};

/// Plans a path along the crown of a weld from its first to its last point, with the approach axis normal to the curve.
///
/// - `positions` [m], `normals` [unit]: of the weld's curve on the part, equal in number
/// - `height`: of the crown above the curve [m]
///
/// # Errors
/// [`PlanError::BadCurve`] if the curve has fewer than two points, or a normal lies along the curve.
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

/// Returns the component of a normal perpendicular to a direction, as a unit vector.
fn across(normal: DVec3, along: DVec3) -> Option<DVec3> {
    let along = along.try_normalize()?;
    normal.reject_from_normalized(along).try_normalize().filter(|axis| axis.is_finite())
}
