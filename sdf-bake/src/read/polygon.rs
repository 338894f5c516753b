//! Polygons to triangles by ear clipping (Meisters 1975).
//!
//! A fan is wrong for a concave face: it folds over itself. Among the ears the fattest is clipped first, so that
//! corners in the middle of a straight side do not give triangles without area.

use glam::{DVec2, DVec3};

use super::{Format, ReadError};
use crate::Mesh;

/// More corners than a face of any sensible file has; the cost grows with their square.
const MAX_CORNERS: usize = 10_000;

/// Adds a face's triangles to a mesh; `face` holds valid indices into its positions.
pub(super) fn append_face(
    mesh: &mut Mesh,
    format: Format,
    face: impl ExactSizeIterator<Item = u32>,
) -> Result<(), ReadError> {
    if face.len() > MAX_CORNERS {
        let reason = format!("a face has {} corners; up to {MAX_CORNERS} are accepted", face.len());
        return Err(ReadError::malformed(format, reason));
    }
    let face: Vec<u32> = face.collect();
    if let [a, b, c] = face[..] {
        mesh.triangles.push([a, b, c]);
        return Ok(());
    }
    let corners: Vec<_> = face.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
    mesh.triangles.extend(triangulate(&corners).into_iter().map(|t| t.map(|corner| face[corner])));
    Ok(())
}

/// Splits a polygon into triangles of the same orientation.
///
/// `corners`: positions in order. Returns indices into them; empty for fewer than three corners.
/// A polygon that crosses itself, or is flat to a line, still gives `corners.len() - 2` triangles.
fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    match corners.len() {
        0..3 => Vec::new(),
        3 => vec![[0, 1, 2]],
        _ => EarClipping::new(corners).run(),
    }
}

struct EarClipping {
    points: Vec<DVec2>,
    previous: Vec<usize>,
    next: Vec<usize>,
    /// Shape of the ear at each corner, larger is better; `None` where there is no ear.
    quality: Vec<Option<f64>>,
}

impl EarClipping {
    fn new(corners: &[DVec3]) -> Self {
        let n = corners.len();
        let normal = newell_normal(corners);
        let (u, v) = normal.any_orthonormal_pair();
        let points: Vec<_> = corners.iter().map(|&p| p - corners[0]).map(|p| DVec2::new(p.dot(u), p.dot(v))).collect();
        let mut clipping = Self {
            points,
            previous: (0..n).map(|i| (i + n - 1) % n).collect(),
            next: (0..n).map(|i| (i + 1) % n).collect(),
            quality: vec![None; n],
        };
        for corner in 0..n {
            clipping.quality[corner] = clipping.ear(corner, n);
        }
        clipping
    }

    fn run(mut self) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(self.points.len() - 2);
        let mut first = 0;
        for left in (3..=self.points.len()).rev() {
            let tip = self.best(first, left);
            let (before, after) = (self.previous[tip], self.next[tip]);
            triangles.push([before, tip, after]);
            self.next[before] = after;
            self.previous[after] = before;
            first = before;
            self.quality[before] = self.ear(before, left - 1);
            self.quality[after] = self.ear(after, left - 1);
        }
        triangles
    }

    /// The corner with the fattest ear; where a bad polygon has none, any corner, so that the loop ends.
    fn best(&self, first: usize, left: usize) -> usize {
        let mut best = first;
        let mut corner = first;
        for _ in 0..left {
            if self.quality[corner].unwrap_or(-1.0) > self.quality[best].unwrap_or(-1.0) {
                best = corner;
            }
            corner = self.next[corner];
        }
        best
    }

    /// Doubled area over the square of the longest side, if the triangle at `tip` is convex and holds no other corner.
    fn ear(&self, tip: usize, left: usize) -> Option<f64> {
        let [ia, ic] = [self.previous[tip], self.next[tip]];
        let [a, b, c] = [ia, tip, ic].map(|i| self.points[i]);
        let area = (b - a).perp_dot(c - a);
        if area.is_nan() || area < 0.0 {
            return None;
        }
        let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
        let mut other = self.next[ic];
        for _ in 3..left {
            let p = self.points[other];
            let inside = [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| (to - from).perp_dot(p - from) >= 0.0);
            if inside && p != a && p != b && p != c {
                return None;
            }
            other = self.next[other];
        }
        Some(if longest > 0.0 { area / longest } else { 0.0 })
    }
}

/// Normal of a polygon, also of a slightly bent one (Newell's method, Sutherland et al. 1974).
fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let origin = corners[0];
    let mut sum = DVec3::ZERO;
    for (i, &p) in corners.iter().enumerate() {
        sum += (p - origin).cross(corners[(i + 1) % corners.len()] - origin);
    }
    sum.try_normalize().unwrap_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(corners: &[DVec3]) -> Vec<f64> {
        let normal = newell_normal(corners);
        let area = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(normal) / 2.0;
        triangulate(corners).into_iter().map(area).collect()
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        let arrow = [(0.0, 0.0), (2.0, -1.0), (0.5, 0.0), (2.0, 1.0)];
        let corners = arrow.map(|(x, y)| DVec3::new(x, 3.0, -y));
        for turn in 0..4 {
            let mut turned = corners;
            turned.rotate_left(turn);
            let areas = areas(&turned);
            assert!(areas.iter().all(|&a| a > 0.1), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - 0.5).abs() < 1e-12, "{areas:?}");
        }
    }

    #[test]
    fn corners_on_a_straight_side_give_no_empty_triangle() {
        let square = [(0., 0.), (1., 0.), (2., 0.), (2., 1.), (2., 2.), (1., 2.), (0., 2.), (0., 1.)];
        let corners = square.map(|(x, y)| DVec3::new(x, y, 0.0));
        let areas = areas(&corners);
        assert_eq!(areas.len(), 6);
        assert!(areas.iter().all(|&a| a > 0.4), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 4.0).abs() < 1e-12);
    }
}
