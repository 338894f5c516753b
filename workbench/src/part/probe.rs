//! Values at a clicked pixel.

use render::VisibleObject;
use serde_json::{Value, json};

use super::paint::place;
use super::picture::{PictureData, PictureRequest, SurfaceSource, frame};
use crate::bench::{Residuals, interpolated};
use crate::error::Refusal;

/// Returns position and values of the surface point at a pixel; lengths in millimetres and micrometres.
///
/// - `pixel`: column from the left and row from the top
///
/// # Errors
/// If the pixel does not show the part, or there is no surface yet.
pub(crate) fn probed(looked: &PictureData, asked: &PictureRequest, (x, y): (usize, usize)) -> Result<Value, Refusal> {
    let frame = frame(looked, asked)?;
    let at = y * frame.width + x;
    if x >= frame.width || y >= frame.height || frame.seen[at] != VisibleObject::Part {
        return Err(Refusal::missing("no part is there"));
    }
    let (position, here) = (frame.position[at].as_dvec3(), place(&frame, at));
    let trial = looked.trial(asked)?;
    let known = |value: f64, unit: f64| value.is_finite().then_some(value / unit);
    let before = interpolated(&trial.before.pixels, &trial.before.heights, here);
    let map = looked.map(asked);
    let left = map.and_then(|map| map.left_at(here));
    // With a model, the measured height is the registered scan (simulated height plus residual); otherwise the raw
    // scan.
    let measured = match left.filter(|_| asked.whose == SurfaceSource::Simulated) {
        Some(left) => position.z + left,
        None => trial.heights(asked.pass).map_or(f64::NAN, |map| interpolated(&map.pixels, &map.heights, here)),
    };
    let floor = map.and_then(|map| match map.residuals {
        Residuals::Heights { floor, .. } => Some(floor),
        Residuals::Exposure { .. } => None,
    });
    Ok(json!({
        "xMm": 1e3 * position.x,
        "yMm": 1e3 * position.y,
        "zMm": 1e3 * position.z,
        "removedUm": 1e6 * f64::from(frame.removed[at]),
        "dose": frame.dose[at],
        "measuredRemovedUm": known(before - measured, 1e-6),
        "deviationUm": left.map(|left| 1e6 * left),
        "deviationFloors": left.zip(floor).map(|(left, floor)| left / floor),
    }))
}
