//! Cuts triangles where others intersect them, so that every piece is entirely inside another body or entirely outside.

use glam::DVec3;

use super::skin::Corners;

/// Intersection of two triangles: segments that lie in both.
///
/// - `tolerance`: points closer than this to a plane lie in it, in the unit of the corners
pub(super) fn meeting(t: &Corners, u: &Corners, tolerance: f64) -> Vec<[DVec3; 2]> {
    let over = |of: &Corners, base: &Corners| {
        let normal = normal(base)?;
        let height = |p: DVec3| Some(normal.dot(p - base[0])).filter(|h| h.abs() > tolerance).unwrap_or(0.0);
        Some((of.map(height), normal)).filter(|(heights, _)| !is_on_one_side(heights))
    };
    let Some((u_over_t, normal)) = over(u, t) else { return Vec::new() };
    let Some((t_over_u, _)) = over(t, u) else { return Vec::new() };
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

fn is_on_one_side(heights: &[f64; 3]) -> bool {
    heights.iter().all(|&height| height > 0.0) || heights.iter().all(|&height| height < 0.0)
}

fn normal([a, b, c]: &Corners) -> Option<DVec3> {
    (b - a).cross(c - a).try_normalize()
}

/// Intersection segment of a triangle with a plane, given the heights of its corners above the plane, not all 0.
fn in_plane(corners: &Corners, heights: [f64; 3]) -> Option<[DVec3; 2]> {
    let mut points = (0..3).flat_map(|i| {
        let (here, next) = (heights[i], heights[(i + 1) % 3]);
        let corner = (here == 0.0).then_some(corners[i]);
        let crossing = (here * next < 0.0).then(|| corners[i].lerp(corners[(i + 1) % 3], here / (here - next)));
        corner.into_iter().chain(crossing)
    });
    Some([points.next()?, points.next()?])
}

/// Part of a segment within a convex polygon in the same plane.
fn within([a, b]: [DVec3; 2], corners: &[DVec3], normal: DVec3, tolerance: f64) -> Option<[DVec3; 2]> {
    let (mut start, mut end) = (0.0f64, 1.0f64);
    for i in 0..corners.len() {
        let outward = (corners[(i + 1) % corners.len()] - corners[i]).cross(normal).normalize_or_zero();
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

/// Cuts a triangle along segments in it into pieces of the same orientation; `None` if it has no usable plane.
///
/// Each piece that a segment crosses is split along the segment's line, so that all pieces stay convex.
pub(super) fn pieces(corners: &Corners, segments: &[[DVec3; 2]], tolerance: f64) -> Option<Vec<Corners>> {
    let normal = normal(corners)?;
    let mut pieces = vec![corners.to_vec()];
    for &segment in segments {
        let aside = (segment[1] - segment[0]).cross(normal).normalize_or_zero();
        let mut halved = Vec::with_capacity(pieces.len() + 1);
        for piece in pieces {
            let heights: Vec<f64> = piece.iter().map(|&p| aside.dot(p - segment[0])).collect();
            let is_parted = heights.iter().any(|&h| h > tolerance) && heights.iter().any(|&h| h < -tolerance);
            if is_parted && within(segment, &piece, normal, tolerance).is_some() {
                halved.extend([half(&piece, &heights, 1.0), half(&piece, &heights, -1.0)]);
            } else {
                halved.push(piece);
            }
        }
        pieces = halved;
    }
    Some(pieces.iter().flat_map(|piece| fan(piece)).collect())
}

/// Part of a convex polygon on one side of a line, given its corners' heights above the line.
fn half(piece: &[DVec3], heights: &[f64], side: f64) -> Vec<DVec3> {
    let mut half = Vec::with_capacity(piece.len() + 1);
    for i in 0..piece.len() {
        let next = (i + 1) % piece.len();
        let (from, to) = (side * heights[i], side * heights[next]);
        if from >= 0.0 {
            half.push(piece[i]);
        }
        if from * to < 0.0 {
            half.push(piece[i].lerp(piece[next], from / (from - to)));
        }
    }
    half
}

fn fan(piece: &[DVec3]) -> Vec<Corners> {
    let corners = |i: usize| [piece[0], piece[i], piece[i + 1]];
    (1..piece.len().saturating_sub(1)).map(corners).filter(|corners| normal(corners).is_some()).collect()
}
