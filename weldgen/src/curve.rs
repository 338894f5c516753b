//! The weld curve: evenly spaced points on the surface, with frames.

use glam::DVec3;
use sdf_bake::Mesh;
use serde::Serialize;
use thiserror::Error;

use crate::curvature::CurvatureProfile;
use crate::trace::TracePoint;

/// A point of a weld's centreline.
///
/// `(tangent, side, normal)` is a right-handed orthonormal frame. `side = normal × tangent` points to the left of
/// travel, and a positive geodesic curvature turns the tangent towards it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CurvePoint {
    /// Position [m] on the surface: the barycentric combination of the corners of `face`.
    pub position: DVec3,
    /// Unit direction of travel, smoothed along the curve.
    pub tangent: DVec3,
    /// Unit normal out of the part, smoothed along the curve.
    pub normal: DVec3,
    /// Unit vector to the left: `normal × tangent`.
    pub side: DVec3,
    /// Arc length from the start of the weld [m].
    pub arc_length: f64,
    /// Geodesic curvature κ_g [1/m].
    pub geodesic_curvature: f64,
    /// Index of the triangle that contains the point.
    pub face: u32,
    /// Barycentric coordinates in that triangle.
    pub barycentric: [f64; 3],
    /// Exposure: cosine-weighted free share of the hemisphere, in [0, 1] (see [`crate::exposure`]).
    pub exposure: f64,
    /// Tool access: share of the tool's poses without collision, in [0, 1] (see [`crate::access`]).
    pub access: f64,
    /// Width of the bead here [m].
    pub width: f64,
    /// Height of the bead here [m].
    pub height: f64,
}

/// Sine of the angle below the horizon up to which a weld still counts as one on a vertical wall: 15°.
const OVERHEAD_LEAN: f64 = 0.26;

/// A weld's centreline on the part.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WeldCurve {
    /// Points in order of travel, evenly spaced in arc length.
    pub points: Vec<CurvePoint>,
}

/// Fault found by [`WeldCurve::validate`].
#[derive(Clone, Debug, Error, PartialEq)]
pub enum CurveError {
    /// Fewer than two points.
    #[error("the curve has {0} points; at least 2 are needed")]
    TooShort(usize),
    /// A point is not at the position given by its triangle and barycentric coordinates.
    #[error("point {index} is {off:e} m off triangle {face}; {allowed:e} m is allowed")]
    OffSurface {
        /// Index of the point.
        index: usize,
        /// Distance from the triangle [m].
        off: f64,
        /// Index of its triangle.
        face: u32,
        /// Distance allowed [m].
        allowed: f64,
    },
    /// A frame is not orthonormal and right-handed.
    #[error("the frame of point {0} is not orthonormal and right-handed to 1e-9")]
    Frame(usize),
    /// Arc lengths do not increase evenly, or a chord is longer than its arc.
    #[error(
        "arc length {found} m at point {index} does not follow from {previous} m by an even step that the chord fits"
    )]
    ArcLength {
        /// Index of the point.
        index: usize,
        /// Arc length of the point [m].
        found: f64,
        /// Arc length of the previous point [m].
        previous: f64,
    },
}

impl WeldCurve {
    /// Arc length [m] from the first point to the last.
    pub fn length(&self) -> f64 {
        match (self.points.first(), self.points.last()) {
            (Some(first), Some(last)) => last.arc_length - first.arc_length,
            _ => 0.0,
        }
    }

    /// Least exposure along the curve; 1 without points.
    pub fn min_exposure(&self) -> f64 {
        self.points.iter().fold(1.0, |min, point| point.exposure.min(min))
    }

    /// Mean tool access along the curve; 0 without points.
    pub fn mean_access(&self) -> f64 {
        self.points.iter().map(|point| point.access).sum::<f64>() / self.points.len().max(1) as f64
    }

    /// True if the mean normal points more than 15° below the horizon, z upwards: the weld would be made overhead.
    pub fn faces_down(&self) -> bool {
        let mean = self.points.iter().map(|point| point.normal.z).sum::<f64>() / self.points.len().max(1) as f64;
        mean < -OVERHEAD_LEAN
    }

    /// Root mean square of κ_g [1/m] over the arc length (trapezoidal rule).
    pub fn curvature_rms(&self) -> f64 {
        let squares = self.points.windows(2).map(|pair| {
            let [a, b] = [0, 1].map(|i| pair[i].geodesic_curvature);
            0.5 * (a * a + b * b)
        });
        (squares.sum::<f64>() / self.points.len().saturating_sub(1).max(1) as f64).sqrt()
    }

    /// Sets κ_g to the rate at which the smoothed tangents turn to the left (central differences).
    pub(crate) fn measure_curvature(&mut self) {
        let last = self.points.len().saturating_sub(1);
        let turned: Vec<f64> = (0..=last)
            .map(|i| {
                let [before, after] = [i.saturating_sub(1), (i + 1).min(last)].map(|i| &self.points[i]);
                let step = after.arc_length - before.arc_length;
                (after.tangent - before.tangent).dot(self.points[i].side) / step
            })
            .collect();
        for (point, curvature) in self.points.iter_mut().zip(turned) {
            point.geodesic_curvature = curvature;
        }
    }

    /// Checks that every point lies on the surface to 1e-6 of the part's diagonal, that frames are orthonormal and
    /// right-handed and that arc lengths are even and agree with the positions.
    pub fn validate(&self, mesh: &Mesh) -> Result<(), CurveError> {
        if self.points.len() < 2 {
            return Err(CurveError::TooShort(self.points.len()));
        }
        let allowed = 1e-6 * mesh.diagonal();
        let step = self.length() / (self.points.len() - 1) as f64;
        for (index, point) in self.points.iter().enumerate() {
            let off = off_surface(mesh, point);
            let on = off <= allowed;
            if !on {
                return Err(CurveError::OffSurface { index, off, face: point.face, allowed });
            }
            let right_handed = (point.normal.cross(point.tangent) - point.side).length();
            let unit = (point.normal.length() - 1.0).abs() + (point.tangent.length() - 1.0).abs();
            let orthonormal = right_handed + unit + point.normal.dot(point.tangent).abs() < 1e-9;
            if !orthonormal {
                return Err(CurveError::Frame(index));
            }
            let Some(before) = index.checked_sub(1).map(|i| self.points[i]) else { continue };
            let even = (point.arc_length - before.arc_length - step).abs() <= 1e-9 * self.length();
            let fits = point.position.distance(before.position) <= step * (1.0 + 1e-6) + allowed;
            if !(even && fits) {
                let (found, previous) = (point.arc_length, before.arc_length);
                return Err(CurveError::ArcLength { index, found, previous });
            }
        }
        Ok(())
    }

    /// Builds frames on a stretch of a traced curve: points `first..=last`, evenly `spacing` [m] apart.
    ///
    /// Normals and tangents are averaged over `half_window` points to both sides (weights falling linearly to 0), so
    /// that the facets of a tessellated surface do not cause kinks in the swept bead. Near the ends the window is
    /// shortened on both sides, which keeps it centred.
    pub(crate) fn frame(points: &[TracePoint], stretch: Stretch, curvature: &CurvatureProfile) -> Self {
        let Stretch { first, last, spacing, half_window, start } = stretch;
        let framed = |index: usize| {
            let reach = half_window.min(index).min(points.len() - 1 - index);
            let mean = |of: fn(&TracePoint) -> DVec3| {
                let weigh = |i: usize| (reach + 1 - i.abs_diff(index)) as f64 * of(&points[i]);
                (index - reach..=index + reach).map(weigh).sum::<DVec3>()
            };
            let here = &points[index];
            let normal = mean(|p| p.normal).try_normalize().unwrap_or(here.normal);
            let tangent = mean(|p| p.tangent).reject_from_normalized(normal);
            let tangent = tangent.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
            CurvePoint {
                position: here.position,
                tangent,
                normal,
                side: normal.cross(tangent),
                arc_length: (index - first) as f64 * spacing,
                geodesic_curvature: curvature.at(start + (index - first) as f64 * spacing),
                face: here.face,
                barycentric: here.barycentric,
                exposure: 1.0,
                access: 1.0,
                width: 0.0,
                height: 0.0,
            }
        };
        Self { points: (first..=last).map(framed).collect() }
    }
}

/// Part of a trace that becomes a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stretch {
    pub(crate) first: usize,
    pub(crate) last: usize,
    /// Arc length between points [m].
    pub(crate) spacing: f64,
    pub(crate) half_window: usize,
    /// Arc length of the first point in the curvature profile [m].
    pub(crate) start: f64,
}

fn off_surface(mesh: &Mesh, point: &CurvePoint) -> f64 {
    let Some(corners) = mesh.triangles.get(point.face as usize) else {
        return f64::INFINITY;
    };
    let inside = point.barycentric.iter().all(|w| *w >= -1e-9);
    let whole = (point.barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-9;
    if !(inside && whole) {
        return f64::INFINITY;
    }
    let weighted = corners.iter().zip(point.barycentric).map(|(v, w)| w * mesh.positions[*v as usize]);
    weighted.sum::<DVec3>().distance(point.position)
}
