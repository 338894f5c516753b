//! Packets of neighbouring camera rays: a clearance of the central ray that exceeds their distance holds for all.
//!
//! ```text
//!          ╱ ╱ ╱     the central ray advances by φ minus the distance of the others from it, as in cone marching
//!    ◉ ━━ ━ ━ ━ ━    (Bálint & Valasek 2018); the others start where it stops
//!          ╲ ╲ ╲
//! ```

use glam::Vec3A;

use super::field::Field;
use super::index::{BEYOND, Entry};
use super::rays::Rays;
use super::shadow::STEEPEST;
use super::walk::{BRICK_SHIFT, Line, free_cube, integers, nudge};

/// Factor on the distance of the corner rays from the central ray; covers rays between them that lens distortion bends
/// outwards.
const BULGE: f32 = 1.02;
/// Step below which the central ray stops [voxels].
const SHORTEST: f32 = 0.5;

/// Length from the ray starts on which none of the rays, nor any ray between them, meets metal [m]; infinite if none
/// ever does. `known`: such a length that is already known [m].
#[inline(always)]
pub(crate) fn common_clear_length(field: &Field, rays: &Rays, known: f64) -> f64 {
    if known == f64::INFINITY {
        return known;
    }
    let (origin, direction) = rays.middle();
    let (apart, spread) = (rays.farthest(&rays.origins, origin), rays.farthest(&rays.directions, direction));
    let apart = apart * field.per_metre;
    let start = origin * field.per_metre - field.lowest;
    let (line, (low, high)) = (Line::new(direction.as_vec3a()), field.metal_box);
    let (low, high) = (Vec3A::from(low), Vec3A::from(high));
    // Distances are counted from the point nearest to the box's centre, where single precision suffices.
    let from = ((0.5 * (low + high)).as_dvec3() - start).dot(direction).max(0.0);
    let near = (start + direction * from).as_vec3a();
    let (apart, spread) = (BULGE * STEEPEST * (from * spread + apart) as f32, BULGE * STEEPEST * spread as f32);
    let doubt = |t: f32| t * spread + apart;
    let most = doubt((high - low).length());
    let (mut t, end) = line.span(near, (low - most, high + most), -from as f32);
    t = t.max((known * field.per_metre - from) as f32);
    let (per_step, nudge) = ((STEEPEST + spread).recip(), nudge(field));
    while t < end {
        let at = near + line.direction * t;
        let nearest = at.clamp(low, high);
        let (free, phi) = field.around(&line, nearest);
        // The nearest point of the box lies between this point and all metal, at an angle of at least 90°.
        let clearance = (phi.max(0.0) * phi + at.distance_squared(nearest)).sqrt();
        let by_phi = (clearance - doubt(t)) * per_step;
        let by_cube = free.map_or(0.0, |(low, side)| {
            let margin = Vec3A::splat(doubt(t + line.length_in(at, low, side)));
            let (least, most) = (low + margin, low + side - margin);
            if at.cmpge(least).all() && at.cmple(most).all() {
                line.length_in(at, least, most.x - least.x)
            } else {
                0.0
            }
        });
        let step = by_phi.max(by_cube);
        let goes_on = step > SHORTEST;
        if !goes_on {
            return (from + f64::from(t)).max(0.0) / field.per_metre;
        }
        t += step + nudge;
    }
    f64::INFINITY
}

impl Field<'_> {
    /// Surroundings of a point: lowest corner and side of a cube of bricks without metal, if there is one, and φ
    /// [voxels].
    fn around(&self, line: &Line, at: Vec3A) -> (Option<(Vec3A, f32)>, f32) {
        let low = line.corner(at);
        let corner = integers(low);
        let brick = corner >> BRICK_SHIFT;
        let place = self.index.place(brick);
        let Entry { to_metal, to_brick, .. } = place.map_or(BEYOND, |place| self.index.at(place));
        let free = (to_metal > 0).then(|| free_cube(brick, to_metal));
        let phi = match place {
            Some(place) if to_brick == 0 => self.padded().phi(place, corner, (at - low).into()),
            _ => self.grid.band,
        };
        (free.map(|(low, side)| (low.as_vec3a(), side as f32)), phi * self.per_metre as f32)
    }
}
