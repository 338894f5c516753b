//! Neighbouring rays of a camera: what one in their middle passes at a distance, none of them meets.
//!
//! ```text
//!          ╱ ╱ ╱     the middle ray goes on by φ less the distance of the others from it, as cones of rays do
//!    ◉ ━━ ━ ━ ━ ━    (Bálint & Valasek 2018); the others start where it stops
//!          ╲ ╲ ╲
//! ```

use glam::{DVec3, Vec3A};

use super::camera::Ray;
use super::field::Field;
use super::shadow::STEEPEST;
use super::walk::{Line, indexed_size, nudge};

/// Step below which the middle ray stops [voxels].
const SHORTEST: f32 = 0.3;

/// Length from the start of each ray on which none of them meets the metal [m]; infinite if none ever does.
pub(crate) fn common_clear_length(field: &Field, rays: &[Ray]) -> f64 {
    let count = rays.len().max(1) as f64;
    let origin = rays.iter().map(|ray| ray.origin).sum::<DVec3>() / count;
    let direction = (rays.iter().map(|ray| ray.direction).sum::<DVec3>() / count).normalize_or_zero();
    let farthest = |of: &dyn Fn(&Ray) -> f64| rays.iter().map(of).fold(0.0, f64::max);
    let apart = farthest(&|ray| ray.origin.distance_squared(origin)).sqrt() * field.per_metre;
    let spread = farthest(&|ray| ray.direction.distance_squared(direction)).sqrt();
    let start = origin * field.per_metre - field.lowest;
    let (line, size) = (Line::new(direction.as_vec3a()), Vec3A::from(indexed_size(field)));
    // Distances are counted from the point nearest to the box's middle, where single precision is good enough.
    let from = (0.5 * size.as_dvec3() - start).dot(direction).max(0.0);
    let near = (start + direction * from).as_vec3a();
    let doubt = |t: f32| STEEPEST * ((from + f64::from(t)) * spread + apart) as f32;
    let most = doubt(size.length());
    let (mut t, end) = line.span(near, (Vec3A::splat(-most), size + most), -from as f32);
    let band = field.grid.band * field.per_metre as f32;
    while t < end {
        let at = near + line.direction * t;
        // Metal may be cut off at the last voxels.
        let within = at.clamp(Vec3A::ZERO, size - 1.0);
        let step = match field.clearance(&line, within) {
            Err(free) if within == at && doubt(t + line.length_in_free(at, free)) < band => {
                line.length_in_free(at, free) + nudge(field)
            }
            Err(_) => (band - at.distance(within) - doubt(t)) / (STEEPEST + spread as f32),
            Ok(phi) => (phi - at.distance(within) - doubt(t)) / (STEEPEST + spread as f32),
        };
        let goes_on = step > SHORTEST;
        if !goes_on {
            return (from + f64::from(t)).max(0.0) / field.per_metre;
        }
        t += step;
    }
    f64::INFINITY
}
