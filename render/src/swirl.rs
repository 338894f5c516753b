//! Swirl marks of an orbital pad: short arcs of its orbit, one over the other. On the CPU only.

use glam::Vec3;

use super::marks::{Groove, noise_slope};
use super::texture::{cell, unit};

/// Distance between neighbouring centres of arcs, relative to the orbit's radius.
const SPACING: f32 = 0.9;

/// Groove of the uppermost arc at a point [m] of a surface; `orbit`: radius of the pad's orbit [m], `width` of a groove
/// [m], `slope` of its flanks. Arcs have centres in the cells of a lattice, each at a random place with a random rank.
#[inline(always)]
pub(crate) fn arc(point: Vec3, normal: Vec3, orbit: f32, (width, slope): (f32, f32)) -> Option<Groove> {
    let spacing = SPACING * orbit;
    let low = (point / spacing - 0.5).floor();
    let mut uppermost = (-1.0, Vec3::ZERO, 0.0);
    for i in 0..8 {
        let at = low + Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let [x, y, z] = cell(at);
        let centre = (at + Vec3::new(unit(x), unit(y), unit(z))) * spacing;
        let away = point - centre;
        let away = away - normal * normal.dot(away);
        let rank = unit(x ^ z.rotate_left(13));
        let radius = away.length();
        if radius < orbit && radius > 0.1 * orbit && rank > uppermost.0 {
            uppermost = (rank, away / radius, radius);
        }
    }
    let (rank, outward, radius) = uppermost;
    (rank >= 0.0).then(|| Groove {
        along: normal.cross(outward),
        tilt: slope * noise_slope(radius / width + 97.0 * rank, 0.5),
        share: 1.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arcs_lie_in_the_surface_and_turn_within_an_orbit() {
        let orbit = 4e-3;
        let at = |i: usize| arc(Vec3::new(1e-4 * i as f32, 2.3e-3, 1e-3), Vec3::Z, orbit, (2e-4, 0.2));
        let arcs: Vec<Groove> = (0..1000).filter_map(at).collect();
        assert!(arcs.len() > 900, "{} of 1000 points lie on an arc", arcs.len());
        assert!(arcs.iter().all(|arc| arc.along.z.abs() < 1e-6 && (arc.along.length() - 1.0).abs() < 1e-4));
        // No direction is preferred: the mean of exp(2 i angle) is small.
        let twice = |arc: &Groove| 2.0 * arc.along.y.atan2(arc.along.x);
        let count = arcs.len() as f32;
        let (sine, cosine) =
            arcs.iter().fold((0.0, 0.0), |sum, arc| (sum.0 + twice(arc).sin(), sum.1 + twice(arc).cos()));
        assert!((sine / count).hypot(cosine / count) < 0.2);
    }
}
