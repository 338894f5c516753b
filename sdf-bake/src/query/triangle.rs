//! The point of one triangle nearest to a given point.

use glam::DVec3;

/// Barycentric coordinates of the point of a triangle nearest to `point`, and its squared distance [m²].
///
/// The foot on the plane is used if its coordinates are all positive; otherwise the best of the three edges. On slivers
/// the foot's coordinates are ill-conditioned, so a candidate's distance is always measured to the point that the
/// clamped coordinates give: the result may be too far by rounding, but never nearer than the triangle.
pub fn closest_on_triangle([a, b, c]: [DVec3; 3], point: DVec3) -> ([f64; 3], f64) {
    let normal = (b - a).cross(c - a);
    let squared = normal.length_squared();
    let v = (point - a).cross(c - a).dot(normal) / squared;
    let w = (b - a).cross(point - a).dot(normal) / squared;
    let u = 1.0 - v - w;
    if u > FACE_MARGIN && v > FACE_MARGIN && w > FACE_MARGIN {
        return ([u, v, w], measure([a, b, c], [u, v, w], point));
    }
    let (s, t, r) = (on_segment(a, b, point), on_segment(b, c, point), on_segment(c, a, point));
    let edges = [[1.0 - s, s, 0.0], [0.0, 1.0 - t, t], [r, 0.0, 1.0 - r]];
    let face = (u >= 0.0 && v >= 0.0 && w >= 0.0).then_some([u, v, w]);
    let mut best = ([1.0, 0.0, 0.0], f64::INFINITY);
    for weights in edges.into_iter().chain(face) {
        let distance = measure([a, b, c], weights, point);
        if distance < best.1 {
            best = (weights, distance);
        }
    }
    best
}

/// Coordinates above this are certainly inside, within the rounding of an ordinary triangle.
const FACE_MARGIN: f64 = 1e-9;

/// Position along the segment from `a` to `b`, 0 to 1, of the point nearest to `point`; 0 for a segment of zero length.
fn on_segment(a: DVec3, b: DVec3, point: DVec3) -> f64 {
    let along = b - a;
    let share = (point - a).dot(along) / along.length_squared();
    if share > 0.0 { share.min(1.0) } else { 0.0 }
}

fn measure([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3], point: DVec3) -> f64 {
    (u * (a - point) + v * (b - point) + w * (c - point)).length_squared()
}
