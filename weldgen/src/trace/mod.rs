//! Traces curves of prescribed geodesic curvature over a polyhedral surface.
//!
//! Within a triangle the curve is planar and its heading turns by κ_g per arc length. At an edge the next triangle is
//! unfolded into the plane of the last one, so with κ_g = 0 the curve is the straightest geodesic of Polthier & Schmies
//! (1998). A curve that meets a vertex continues with equal angles on its left and right, as in their definition. All
//! computation is in planar coordinates: the result is exact to rounding on the polyhedron, even for long and thin
//! triangles.

mod arc;
mod face;
mod fan;
mod section;
mod strip;

use glam::{DVec2, DVec3};
use sdf_bake::Mesh;

use crate::curvature::CurvatureProfile;
use crate::topology::{EdgeNeighbour, Topology};
use arc::{Arc, LARGEST_TURN};
use face::FlatFace;
use fan::Fan;
pub use section::trace_section;
use strip::{Bounds, follow};

/// Start of a trace.
#[derive(Clone, Copy, Debug)]
pub struct TraceStart {
    /// Index of the triangle.
    pub face: u32,
    /// Barycentric coordinates; none negative, summing to 1.
    pub barycentric: [f64; 3],
    /// Direction of any length, projected to the triangle's plane.
    pub heading: DVec3,
}

/// Length, point spacing and stop criteria of a trace.
#[derive(Clone, Copy, Debug)]
pub struct TraceLimits {
    /// Arc length to trace [m].
    pub length: f64,
    /// Arc length between recorded points [m].
    pub spacing: f64,
    /// Edges whose normals differ by more than this [rad] are not crossed.
    pub sharp_angle: f64,
    /// Greatest number of arcs and edge crossings: a bound on the time for any mesh.
    pub max_steps: usize,
}

/// A point of a traced curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TracePoint {
    /// Index of the triangle.
    pub face: u32,
    /// Barycentric coordinates; none negative, summing to 1.
    pub barycentric: [f64; 3],
    /// Position [m] given by the barycentric coordinates.
    pub position: DVec3,
    /// Unit direction of travel, in the triangle's plane.
    pub tangent: DVec3,
    /// Unit normal of the triangle.
    pub normal: DVec3,
}

/// Reason why a trace stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum TraceEnd {
    /// The whole length was traced.
    Length,
    /// The surface ends.
    Boundary,
    /// An edge with more than two triangles, or with one of opposite orientation.
    NonManifold,
    /// An edge sharper than allowed.
    Sharp,
    /// A concave edge, where none is allowed.
    Hollow,
    /// A triangle without area, or an invalid start, limit or curvature.
    Degenerate,
    /// The step limit was reached.
    Steps,
}

/// A traced curve.
#[derive(Clone, Debug)]
pub struct Trace {
    /// Points at arc lengths 0, spacing, 2·spacing, ... [m] up to the end of the trace.
    pub points: Vec<TracePoint>,
    /// Arc length traced [m]; up to one spacing beyond the last point.
    pub length: f64,
    /// Number of edges crossed.
    pub crossings: usize,
    /// Reason why it stopped.
    pub end: TraceEnd,
}

/// Traces a curve of geodesic curvature `curvature.at(s)`, from `s = 0`.
pub fn trace(
    mesh: &Mesh,
    topology: &Topology,
    start: TraceStart,
    curvature: &CurvatureProfile,
    limits: TraceLimits,
) -> Trace {
    let mut trace = Trace { points: Vec::new(), length: 0.0, crossings: 0, end: TraceEnd::Degenerate };
    let face = ((start.face as usize) < mesh.triangles.len()).then(|| FlatFace::new(mesh, start.face)).flatten();
    let Some((face, heading)) = face.and_then(|face| Some((face, face.flatten(start.heading)?))) else {
        return trace;
    };
    let finite = limits.length.is_finite() && start.barycentric.iter().all(|w| w.is_finite()) && curvature.is_finite();
    if !(finite && limits.spacing > 0.0) {
        return trace;
    }
    let mut walker = Walker { mesh, topology, limits, face, point: face.lay(start.barycentric), heading };
    trace.points.push(walker.record());
    let mut arcs = 0;
    trace.end = loop {
        if trace.length >= limits.length {
            break TraceEnd::Length;
        }
        if arcs + trace.crossings >= limits.max_steps {
            break TraceEnd::Steps;
        }
        arcs += 1;
        if let Err(end) = walker.step(curvature, &mut trace) {
            break end;
        }
    };
    trace
}

struct Walker<'a> {
    mesh: &'a Mesh,
    topology: &'a Topology,
    limits: TraceLimits,
    face: FlatFace,
    point: DVec2,
    heading: DVec2,
}

impl Walker<'_> {
    /// Advances by one arc within the triangle, or to its edge and across it.
    fn step(&mut self, curvature: &CurvatureProfile, trace: &mut Trace) -> Result<(), TraceEnd> {
        let stretch = curvature.stretch(trace.length);
        let mark = trace.points.len() as f64 * self.limits.spacing;
        // A last point that rounding puts beyond the end is still recorded.
        let is_mark = mark <= self.limits.length + 1e-9 * self.limits.spacing;
        let target = mark.min(self.limits.length);
        let to_target = target - trace.length;
        let step = to_target.min(stretch.left).min(one_way(stretch.value, stretch.slope));
        let arc = Arc { start: self.point, heading: self.heading, curvature: stretch.value, slope: stretch.slope };
        if let Some((length, edge)) = self.exit(&arc, step) {
            trace.length += length;
            (self.point, self.heading) = (arc.point(length), arc.heading_at(length));
            trace.crossings += 1;
            let corner = self.face.corner_at(edge, self.point);
            let back = corner.and_then(|corner| Some((corner, self.face.angle_within(corner, -self.heading)?)));
            if let Some((corner, back)) = back {
                return self.pass(corner, back);
            }
            let entered = self.cross(edge)?;
            let reach = to_target.min(stretch.left) - length;
            return if arc.is_straight() { self.follow(entered, reach, trace) } else { Ok(()) };
        }
        (self.point, self.heading) = (arc.point(step), arc.heading_at(step));
        trace.length = if step == to_target { target } else { (trace.length + step).min(target) };
        if trace.length == target && is_mark {
            trace.points.push(self.record());
        }
        Ok(())
    }

    fn exit(&self, arc: &Arc, step: f64) -> Option<(f64, usize)> {
        let leaves = |edge: usize| arc.leaves(self.face.start(edge), self.face.along[edge], step, self.face.slack);
        (0..3).filter_map(|edge| Some((leaves(edge)?, edge))).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Crosses an edge; returns the index of the edge in the next triangle.
    fn cross(&mut self, edge: usize) -> Result<usize, TraceEnd> {
        let (next, next_edge) = match self.topology.across[self.face.face as usize][edge] {
            EdgeNeighbour::Boundary => return Err(TraceEnd::Boundary),
            EdgeNeighbour::NonManifold => return Err(TraceEnd::NonManifold),
            EdgeNeighbour::Face { turn, .. } if turn.abs() > self.limits.sharp_angle => return Err(TraceEnd::Sharp),
            EdgeNeighbour::Face { face, edge, .. } => (face, usize::from(edge)),
        };
        let next = FlatFace::new(self.mesh, next).ok_or(TraceEnd::Degenerate)?;
        (self.point, self.heading) = self.face.unfold(edge, self.point, self.heading, &next, next_edge);
        self.face = next;
        Ok(next_edge)
    }

    /// Continues straight from an edge that was just crossed, over whole triangles.
    fn follow(&mut self, edge: usize, reach: f64, trace: &mut Trace) -> Result<(), TraceEnd> {
        let most = self.limits.max_steps.saturating_sub(trace.crossings);
        let entry = self.face.entry(edge, self.point, self.heading);
        let bounds = Bounds { reach, sharp_angle: self.limits.sharp_angle, most };
        let followed = follow((self.mesh, self.topology), entry, &bounds);
        if followed.crossings > 0 {
            trace.length += followed.length;
            trace.crossings += followed.crossings;
            self.face = FlatFace::new(self.mesh, followed.entry.face).ok_or(TraceEnd::Degenerate)?;
            (self.point, self.heading) = self.face.at_entry(followed.entry);
        }
        Ok(())
    }

    /// Continues through a corner of the triangle; `back` is the incoming direction's angle from the edge that starts
    /// there.
    fn pass(&mut self, corner: usize, back: f64) -> Result<(), TraceEnd> {
        let fan = Fan::around(self.mesh, self.topology, self.face.face, corner)?;
        let way = fan.opposite(back, self.limits.sharp_angle).ok_or(TraceEnd::Sharp)?;
        self.face = FlatFace::new(self.mesh, way.face).ok_or(TraceEnd::Degenerate)?;
        (self.point, self.heading) = self.face.ray_from(way.corner, way.angle);
        Ok(())
    }

    fn record(&self) -> TracePoint {
        let [x, y, normal] = self.face.axes();
        let barycentric = self.face.barycentric(self.point);
        TracePoint {
            face: self.face.face,
            barycentric,
            position: self.face.position(barycentric),
            tangent: self.heading.x * x + self.heading.y * y,
            normal,
        }
    }
}

/// Arc length [m] over which the curvature keeps its sign and the heading changes by less than [`LARGEST_TURN`].
fn one_way(curvature: f64, slope: f64) -> f64 {
    // The heading change |κ|σ + |κ'|σ²/2 stays below the limit if each term stays below half of it.
    let turn = (0.5 * LARGEST_TURN / curvature.abs()).min((LARGEST_TURN / slope.abs()).sqrt());
    let to_zero = -curvature / slope;
    // A zero within rounding of this position has just been reached.
    if to_zero > 1e-9 * turn { turn.min(to_zero) } else { turn }
}
