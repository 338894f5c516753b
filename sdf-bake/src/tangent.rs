//! What a voxel near the surface knows of it: the tangent plane at its closest surface point.

use glam::{DVec3, IVec3, Vec3};

use crate::grid::BrickGrid;

/// Slopes farther than this from 1 do not come from one face.
const CLEAN: f32 = 0.1;
/// The same for first differences, which are exact on a plane.
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
    /// What a voxel knows of the surface, its foot relative to the voxel, or `None` where its slopes are not those of one
    /// face. `phi` gives φ [m] at an offset [voxels] from the voxel, up to two along each axis.
    pub(crate) fn tangent_of(&self, phi: impl Fn(IVec3) -> f32) -> Option<Tangent> {
        let here = phi(IVec3::ZERO);
        let gradient = self.face_gradient(phi)?;
        let slope = gradient.length();
        let normal = (gradient / slope).as_dvec3();
        let known = here.abs() < self.band;
        known.then(|| Tangent { foot: -normal * f64::from(here / (self.voxel as f32 * slope)), normal })
    }

    /// Gradient of φ at a voxel [1] that is that of one face even next to an edge, or `None` if that cannot be told.
    ///
    /// Along each axis it is taken from the side on which the field is smoother (Harten et al. 1987, essentially
    /// non-oscillatory). Between two edges no side is smooth, but a face that is plane shows in two neighbours whose
    /// differences have the length 1.
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
    /// To the voxel before and the one after.
    sides: [f32; 2],
}

impl Slopes {
    /// From five values around a voxel; beyond `band` their bend is not known.
    fn of([a, b, c, d, e]: [f32; 5], band: f32) -> Self {
        let known = |value: f32, bend: f32| if value.abs() < band { bend } else { 0.0 };
        let (before, here, after) = (known(a, a - 2.0 * b + c), b - 2.0 * c + d, known(e, c - 2.0 * d + e));
        let smoother = |p: f32, q: f32| if p.abs() < q.abs() { p } else { q };
        let (left, right) = (smoother(before, here), smoother(here, after));
        let smooth = if left.abs() < right.abs() { c - b + 0.5 * left } else { d - c - 0.5 * right };
        Self { smooth, sides: [c - b, d - c] }
    }
}
