//! Cutting triangles where others meet them, so that every piece is wholly inside another body or wholly outside.

use glam::{DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::skin::Corners;

/// Below this, spade takes no coordinate but zero.
const LEAST_COORDINATE: f64 = 1e-140;

/// Two corners of a piece closer than this many tolerances make it no piece.
const LEAST_PIECE: f64 = 1e-3;

/// Where one triangle meets another: segments that lie in both.
///
/// - `tolerance`: points closer than this to a plane lie in it, in the unit of the corners
pub(super) fn meeting(t: &Corners, u: &Corners, tolerance: f64) -> Vec<[DVec3; 2]> {
    let (Some(normal), Some(other)) = (normal(t), normal(u)) else { return Vec::new() };
    let heights = |of: &Corners, corner: DVec3, normal: DVec3| {
        of.map(|p| Some(normal.dot(p - corner)).filter(|height| height.abs() > tolerance).unwrap_or(0.0))
    };
    let (u_over_t, t_over_u) = (heights(u, t[0], normal), heights(t, u[0], other));
    if u_over_t == [0.0; 3] || t_over_u == [0.0; 3] {
        return (0..3).map(|i| [u[i], u[(i + 1) % 3]]).filter_map(|edge| within(edge, t, normal, tolerance)).collect();
    }
    let (Some(in_t), Some(in_u)) = (in_plane(u, u_over_t), in_plane(t, t_over_u)) else { return Vec::new() };
    let line = (in_t[1] - in_t[0]).normalize_or_zero();
    let sorted = |[a, b]: [DVec3; 2]| if line.dot(a) <= line.dot(b) { [a, b] } else { [b, a] };
    let ([a, b], [c, d]) = (sorted(in_t), sorted(in_u));
    let first = if line.dot(a) >= line.dot(c) { a } else { c };
    let last = if line.dot(b) <= line.dot(d) { b } else { d };
    if line.dot(last - first) > tolerance { vec![[first, last]] } else { Vec::new() }
}

fn normal([a, b, c]: &Corners) -> Option<DVec3> {
    (b - a).cross(c - a).try_normalize()
}

/// The segment of a triangle in a plane over which its corners have the given heights.
fn in_plane(corners: &Corners, heights: [f64; 3]) -> Option<[DVec3; 2]> {
    let mut points = Vec::with_capacity(3);
    for i in 0..3 {
        let (here, next) = (heights[i], heights[(i + 1) % 3]);
        if here == 0.0 {
            points.push(corners[i]);
        }
        if here * next < 0.0 {
            points.push(corners[i].lerp(corners[(i + 1) % 3], here / (here - next)));
        }
    }
    match points[..] {
        [a, b] => Some([a, b]),
        _ => None,
    }
}

/// The part of a segment over a triangle of whose plane it is.
fn within([a, b]: [DVec3; 2], corners: &Corners, normal: DVec3, tolerance: f64) -> Option<[DVec3; 2]> {
    let (mut start, mut end) = (0.0f64, 1.0f64);
    for i in 0..3 {
        let outward = (corners[(i + 1) % 3] - corners[i]).cross(normal).normalize_or_zero();
        let (from, to) = (outward.dot(a - corners[i]), outward.dot(b - corners[i]));
        if from > tolerance && to > tolerance {
            return None;
        }
        if from > tolerance {
            start = start.max(from / (from - to));
        } else if to > tolerance {
            end = end.min(from / (from - to));
        }
    }
    ((end - start) * a.distance(b) > tolerance).then(|| [a.lerp(b, start), a.lerp(b, end)])
}

/// The pieces of a triangle between segments in it, turned as it is; `None` if it cannot be cut.
pub(super) fn pieces(corners: &Corners, segments: &[[DVec3; 2]], tolerance: f64) -> Option<Vec<Corners>> {
    let normal = normal(corners)?;
    let along = (corners[1] - corners[0]).try_normalize()?;
    let across = normal.cross(along);
    let flat = |p: DVec3| DVec2::new(along.dot(p - corners[0]), across.dot(p - corners[0]));
    let mut plane = Plane { triangulation: ConstrainedDelaunayTriangulation::new(), tolerance };
    let outline = corners.map(flat);
    for corner in outline {
        plane.vertex(corner)?;
    }
    for segment in segments {
        let [from, to] = segment.map(|p| snapped(flat(p), &outline, tolerance));
        let (from, to) = (plane.vertex(from)?, plane.vertex(to)?);
        if from != to {
            plane.triangulation.add_constraint_and_split(from, to, |point| point);
        }
    }
    let solid = |p: Point2<f64>| corners[0] + p.x * along + p.y * across;
    let faces = plane.triangulation.inner_faces().map(|face| face.vertices().map(|vertex| solid(vertex.position())));
    Some(faces.filter(|[a, b, c]| (b - a).cross(c - a).length() > LEAST_PIECE * tolerance * tolerance).collect())
}

/// A point drawn onto the outline if it is closer than the tolerance, so that pieces do not reach beyond it.
fn snapped(point: DVec2, outline: &[DVec2; 3], tolerance: f64) -> DVec2 {
    let mut nearest = (tolerance, point);
    for i in 0..3 {
        let (from, edge) = (outline[i], outline[(i + 1) % 3] - outline[i]);
        let foot = from + edge * ((point - from).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        if foot.distance(point) < nearest.0 {
            nearest = (foot.distance(point), foot);
        }
    }
    nearest.1
}

struct Plane {
    triangulation: ConstrainedDelaunayTriangulation<Point2<f64>>,
    tolerance: f64,
}

impl Plane {
    /// The vertex at a point; one within the tolerance serves. `None` if the point is no number.
    fn vertex(&mut self, point: DVec2) -> Option<spade::handles::FixedVertexHandle> {
        let near = self.triangulation.vertices().find(|vertex| {
            let at = vertex.position();
            DVec2::new(at.x, at.y).distance(point) < self.tolerance
        });
        if let Some(vertex) = near.map(|vertex| vertex.fix()) {
            return Some(vertex);
        }
        let [x, y] = point.to_array().map(|number| if number.abs() < LEAST_COORDINATE { 0.0 } else { number });
        self.triangulation.insert(Point2::new(x, y)).ok()
    }
}
