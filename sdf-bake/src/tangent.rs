//! Tangent plane of a voxel near the surface, at its closest surface point.

use glam::{DVec3, IVec3, Vec3};

use crate::grid::BrickGrid;

/// Greatest deviation of a slope from 1 on a single face.
const CLEAN: f32 = 0.1;
/// [`CLEAN`] for first differences, which are exact on a plane.
const CLEAN_PLANE: f32 = 0.005;

/// The tangent plane of the surface at the point closest to a voxel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tangent {
    /// Closest surface point [voxels].
    pub(crate) foot: DVec3,
    /// Outward unit normal there.
    pub(crate) normal: DVec3,
}

impl BrickGrid {
    /// Tangent at a voxel, with its foot relative to the voxel; `None` if its slopes are not those of a single face.
    /// `phi` gives φ [m] at an offset [voxels] from the voxel, up to two along each axis.
    pub(crate) fn tangent_of(&self, phi: impl Fn(IVec3) -> f32) -> Option<Tangent> {
        let here = phi(IVec3::ZERO);
        let gradient = self.face_gradient(phi)?;
        let slope = gradient.length();
        let normal = (gradient / slope).as_dvec3();
        let known = here.abs() < self.band;
        known.then(|| Tangent { foot: -normal * f64::from(here / (self.voxel as f32 * slope)), normal })
    }

    /// Gradient of φ at a voxel [1], that of a single face even next to an edge; `None` if it is ambiguous.
    ///
    /// Along each axis it is taken from the side on which the field is smoother (Harten et al. 1987, essentially
    /// non-oscillatory). Between two edges no side is smooth, but a plane face is recognised by two neighbours whose
    /// differences have length 1.
    fn face_gradient(&self, phi: impl Fn(IVec3) -> f32) -> Option<Vec3> {
        let axes = IVec3::AXES.map(|axis| Slopes::of([-2, -1, 0, 1, 2].map(|i| phi(axis * i)), self.band));
        let voxel = self.voxel as f32;
        let smooth = Vec3::from_array(axes.each_ref().map(|slopes| slopes.smooth)) / voxel;
        let off = |gradient: Vec3| (gradient.length() - 1.0).abs();
        if off(smooth) < CLEAN {
            return Some(smooth);
        }
        let side = |i: usize| Vec3::from_array(std::array::from_fn(|axis| axes[axis].sides[i >> axis & 1])) / voxel;
        (0..8).map(side).min_by(|a, b| off(*a).total_cmp(&off(*b))).filter(|&gradient| off(gradient) < CLEAN_PLANE)
    }
}

/// Differences of φ at a voxel along an axis [m].
struct Slopes {
    /// Second order, from the smoother side.
    smooth: f32,
    /// First differences to the previous voxel and to the next one.
    sides: [f32; 2],
}

impl Slopes {
    /// Slopes from five values around a voxel; beyond `band` second differences are unknown.
    fn of([a, b, c, d, e]: [f32; 5], band: f32) -> Self {
        let known = |value: f32, bend: f32| if value.abs() < band { bend } else { 0.0 };
        let (before, here, after) = (known(a, a - 2.0 * b + c), b - 2.0 * c + d, known(e, c - 2.0 * d + e));
        let smoother = |p: f32, q: f32| if p.abs() < q.abs() { p } else { q };
        let (left, right) = (smoother(before, here), smoother(here, after));
        let smooth = if left.abs() < right.abs() { c - b + 0.5 * left } else { d - c - 0.5 * right };
        Self { smooth, sides: [c - b, d - c] }
    }
}
