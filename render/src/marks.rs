//! Grinding marks along an abrasive's path: fine grooves that tilt the normal across it. Twin of `marks.wgsl`.

use glam::{DVec3, Vec3};
use shaders::constants::ELONGATION;

use super::lanes::{LANES, Lanes, Points, integer};
use super::swirl::arc;

/// Greatest number of path points that are kept: the direction of the marks varies slowly over their distance.
pub const MOST_POINTS: usize = 48;

/// Length of a pixel on the surface, relative to an orbit's radius, at which half of its arcs' common direction is left.
const LONG_PIXEL: f32 = 0.1;

/// A point on a tool's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MarkPoint {
    /// Position in the part's frame [m].
    pub point: Vec3,
    /// Unit direction of the abrasive's motion.
    pub along: Vec3,
    /// Length of the path up to this point [m].
    pub arc: f32,
}

/// Grinding marks: parallel to the path, with random depth across it.
#[derive(Clone, Debug, PartialEq)]
pub struct Marks {
    /// The path, in order; a single point gives parallel marks everywhere. Empty if there are no marks.
    pub path: Vec<MarkPoint>,
    /// Width of a groove [m].
    pub width: f32,
    /// Slope of the grooves' flanks [1].
    pub slope: f32,
    /// Anisotropy: reduction of roughness along the marks relative to across, 0 to 1 (Burley 2012).
    pub anisotropy: f32,
    /// Radius of an orbital pad's motion [m]: its arcs replace marks along the path. On the CPU only.
    pub orbit: Option<f32>,
}

impl Default for Marks {
    fn default() -> Self {
        Self { path: Vec::new(), width: 0.35e-3, slope: 0.22, anisotropy: 0.75, orbit: None }
    }
}

impl Marks {
    /// True if there are no marks.
    pub(crate) fn is_empty(&self) -> bool {
        self.path.is_empty() && self.orbit.is_none()
    }

    /// Parallel marks along a direction.
    pub fn parallel(along: DVec3) -> Self {
        let along = along.normalize_or(DVec3::X).as_vec3();
        Self { path: vec![MarkPoint { point: Vec3::ZERO, along, arc: 0.0 }], ..Self::default() }
    }

    /// Marks along a tool's path through `points` [m].
    pub fn along_path(points: &[DVec3]) -> Self {
        let mut arc = vec![0.0];
        arc.extend(points.windows(2).scan(0.0, |sum, pair| {
            *sum += pair[0].distance(pair[1]);
            Some(*sum)
        }));
        let stride = points.len().div_ceil(MOST_POINTS).max(1);
        let at = |i: usize| {
            let (before, after) = (points[i.saturating_sub(stride)], points[(i + stride).min(points.len() - 1)]);
            let along = (after - before).normalize_or(DVec3::X).as_vec3();
            MarkPoint { point: points[i].as_vec3(), along, arc: arc[i] as f32 }
        };
        Self { path: (0..points.len()).step_by(stride).map(at).collect(), ..Self::default() }
    }

    /// Directions of the marks at points [m] of a surface with unit normals, and tilts of the normal across them. The
    /// path's directions are interpolated with inverse fourth power weights of the distance (Shepard 1968).
    ///
    /// `footprints`: lengths of pixels on the surface [m]; finer grooves turn into roughness.
    #[inline(always)]
    pub(crate) fn grooves(&self, points: &Points, normals: &Points, footprints: &Lanes) -> Grooves {
        match self.orbit {
            None => self.along_the_path(points, normals, footprints),
            Some(orbit) => self.swirl(points, normals, (footprints, orbit)),
        }
    }

    /// Arcs of an orbit of radius `orbit` [m].
    #[inline(always)]
    fn swirl(&self, points: &Points, normals: &Points, (footprints, orbit): (&Lanes, f32)) -> Grooves {
        let mut grooves = Grooves { along: Points::ZERO, tilt: [0.0; LANES], share: [0.0; LANES] };
        for i in 0..LANES {
            let (point, normal) = (points.get(i), normals.get(i));
            let slope = self.slope * self.fade(footprints[i]);
            let none = Groove { along: any_tangent(normal), tilt: 0.0, share: 0.0 };
            let groove = arc(point, normal, orbit, (self.width, slope)).unwrap_or(none);
            grooves.along.set(i, groove.along);
            // In a pixel that holds many arcs their directions cancel.
            let pixel = footprints[i] / (LONG_PIXEL * orbit);
            let single = 1.0 / (1.0 + pixel * pixel);
            (grooves.tilt[i], grooves.share[i]) = (groove.tilt, groove.share * single);
        }
        grooves
    }

    #[inline(always)]
    fn along_the_path(&self, points: &Points, normals: &Points, footprints: &Lanes) -> Grooves {
        let (mut along, mut centre, mut arc, mut weights) = (Points::ZERO, Points::ZERO, [0.0; LANES], [0.0; LANES]);
        for mark in &self.path {
            for i in 0..LANES {
                let away = points.get(i) - mark.point;
                // The offset of 0.1 mm keeps the weight finite.
                let near = 1.0 / (away.dot(away) + 1e-8);
                let weight = near * near;
                along.set(i, along.get(i) + mark.along * weight);
                centre.set(i, centre.get(i) + mark.point * weight);
                arc[i] += (mark.arc + mark.along.dot(away)) * weight;
                weights[i] += weight;
            }
        }
        let mut grooves = Grooves { along: Points::ZERO, tilt: [0.0; LANES], share: [0.0; LANES] };
        for i in 0..LANES {
            let mix = Mix { along: along.get(i), centre: centre.get(i), arc: arc[i], weights: weights[i] };
            let groove = self.groove(&mix, points.get(i), normals.get(i), footprints[i]);
            grooves.along.set(i, groove.along);
            (grooves.tilt[i], grooves.share[i]) = (groove.tilt, groove.share);
        }
        grooves
    }

    /// Share of a groove's slope that is visible in a pixel of this length on the surface [m].
    #[inline(always)]
    fn fade(&self, footprint: f32) -> f32 {
        1.0 - ((footprint / self.width - 0.4) / 0.8).clamp(0.0, 1.0)
    }

    #[inline(always)]
    fn groove(&self, mix: &Mix, point: Vec3, normal: Vec3, footprint: f32) -> Groove {
        let along = mix.along - normal * normal.dot(mix.along);
        let length = along.length();
        let has_direction = length > 1e-6 * mix.weights;
        let along = along / length;
        let across = normal.cross(along).dot(point - mix.centre / mix.weights) / self.width;
        let down = mix.arc / mix.weights / (self.width * ELONGATION);
        let slope = noise_slope(across, down) + 0.6 * noise_slope(2.7 * across + 11.3, 1.3 * down);
        Groove {
            along: if has_direction { along } else { any_tangent(normal) },
            tilt: if has_direction { self.slope * self.fade(footprint) * slope } else { 0.0 },
            share: if has_direction { 1.0 } else { 0.0 },
        }
    }
}

/// Sums over a path, weighted by proximity to a point.
struct Mix {
    along: Vec3,
    centre: Vec3,
    arc: f32,
    weights: f32,
}

/// The marks at the samples of a tile; values as in [`Groove`].
pub(crate) struct Grooves {
    pub(crate) along: Points,
    pub(crate) tilt: Lanes,
    pub(crate) share: Lanes,
}

/// The marks at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Groove {
    /// Unit tangent along the marks.
    pub(crate) along: Vec3,
    /// Slope of the surface across them [1].
    pub(crate) tilt: f32,
    /// 1 if there is a mark, else 0.
    pub(crate) share: f32,
}

/// Returns a unit vector perpendicular to a unit vector (Duff et al. 2017).
#[inline(always)]
pub(crate) fn any_tangent(normal: Vec3) -> Vec3 {
    let sign = 1f32.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    Vec3::new(1.0 + sign * normal.x * normal.x * a, sign * normal.x * normal.y * a, -sign * normal.x)
}

/// Derivative along u of value noise on the integer lattice (u, v), within ±2.
#[inline(always)]
pub(crate) fn noise_slope(u: f32, v: f32) -> f32 {
    let (low_u, low_v) = (u.floor(), v.floor());
    let (fu, fv) = (u - low_u, v - low_v);
    let (iu, iv) = (integer(low_u), integer(low_v));
    let smooth = fv * fv * (3.0 - 2.0 * fv);
    let row = |iv: i32| lattice_value(iu.wrapping_add(1), iv) - lattice_value(iu, iv);
    let (here, next) = (row(iv), row(iv.wrapping_add(1)));
    (here + (next - here) * smooth) * (6.0 * fu * (1.0 - fu))
}

/// Pseudorandom number from 0 to 1 for a lattice point: the first component of PCG2D (Jarzynski & Olano 2020).
#[inline(always)]
fn lattice_value(u: i32, v: i32) -> f32 {
    let x = (u as u32).wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let y = (v as u32).wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let x = x.wrapping_add(y.wrapping_mul(1_664_525));
    let y = y.wrapping_add(x.wrapping_mul(1_664_525));
    let (x, y) = (x ^ x >> 16, y ^ y >> 16);
    let x = x.wrapping_add(y.wrapping_mul(1_664_525));
    ((x ^ x >> 16) >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn groove_at(marks: &Marks, point: Vec3, normal: Vec3, footprint: f32) -> Groove {
        let [mut points, mut normals] = [Points::ZERO; 2];
        points.set(5, point);
        normals.set(5, normal);
        let grooves = marks.grooves(&points, &normals, &[footprint; LANES]);
        Groove { along: grooves.along.get(5), tilt: grooves.tilt[5], share: grooves.share[5] }
    }

    #[test]
    fn marks_follow_a_bent_path_and_lie_in_the_surface() {
        let arc = |i: usize| {
            let angle = i as f64 / 300.0 * std::f64::consts::FRAC_PI_2;
            DVec3::new(angle.sin(), 1.0 - angle.cos(), 0.0) * 0.05
        };
        let points: Vec<DVec3> = (0..=300).map(arc).collect();
        let marks = Marks::along_path(&points);
        assert!(marks.path.len() <= MOST_POINTS && marks.path.len() > 20);
        let length = marks.path.last().unwrap().arc;
        assert!((length - 0.05 * std::f32::consts::FRAC_PI_2).abs() < 0.003, "{length}");
        for i in [20, 100, 150, 200, 280] {
            let at = points[i].as_vec3() + Vec3::Z * 0.001;
            let groove = groove_at(&marks, at, Vec3::Z, 0.0);
            let tangent = (points[i + 1] - points[i - 1]).normalize().as_vec3();
            assert!(groove.along.dot(tangent) > 0.999 && groove.along.z.abs() < 1e-6, "{groove:?}");
        }
    }

    #[test]
    fn grooves_are_long_along_the_path_and_fade_below_a_pixel() {
        let marks = Marks::parallel(DVec3::X);
        let tilt = |x: f32, y: f32, footprint: f32| groove_at(&marks, Vec3::new(x, y, 0.0), Vec3::Z, footprint).tilt;
        let spread = |tilts: &[f32]| tilts.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f32>();
        let step = 2e-5;
        let across: Vec<f32> = (0..500).map(|i| tilt(0.001, i as f32 * step, 0.0)).collect();
        let along: Vec<f32> = (0..500).map(|i| tilt(i as f32 * step, 0.001, 0.0)).collect();
        assert!(spread(&across) > 20.0 * spread(&along), "{} and {}", spread(&across), spread(&along));
        assert!(across.iter().all(|tilt| tilt.abs() <= 2.0 * 3.0 * marks.slope));
        assert_eq!(tilt(0.001, 0.0007, 2.0 * marks.width), 0.0);
    }

    #[test]
    fn without_a_direction_there_are_no_marks() {
        for marks in [Marks::default(), Marks::parallel(DVec3::Z)] {
            let groove = groove_at(&marks, Vec3::splat(0.01), Vec3::Z, 0.0);
            assert_eq!((groove.tilt, groove.share), (0.0, 0.0));
            assert!(groove.along.is_finite() && groove.along.dot(Vec3::Z).abs() < 1e-6);
        }
    }
}
