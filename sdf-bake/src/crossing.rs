//! Crossing of a triangle with a column along z: one rule for all counts of crossings.
//!
//! A triangle's outline crosses a line of constant y at two points, and the triangle crosses the columns x of that line
//! with `left.x <= x < right.x`. Each point depends on its edge alone, not on the triangle or the edge's direction. So
//! the triangles at an edge partition the columns between them: each column of a closed surface is crossed equally
//! often upwards and downwards, whatever the rounding. Comparisons are between the numbers themselves, never between
//! differences: −1e-17 minus −8 is 8 in f64, and a crossing compared after such a subtraction could belong to no brick
//! or to two.

use glam::DVec3;

/// Part of a triangle on a line of constant y.
pub(crate) struct Span {
    /// Ends; columns with `left.x <= x < right.x` are crossed.
    pub(crate) left: DVec3,
    pub(crate) right: DVec3,
    /// Sign of the z of the triangle's normal.
    pub(crate) sign: i32,
}

impl Span {
    /// Span of a triangle at `y`; `None` if the line misses it.
    #[inline(always)]
    pub(crate) fn at(corners: &[DVec3; 3], y: f64) -> Option<Self> {
        let (mut up, mut down) = (None, None);
        for i in 0..3 {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            if (from.y <= y) != (to.y <= y) {
                let at = point_of_edge(from, to, y);
                if from.y <= y { up = Some(at) } else { down = Some(at) }
            }
        }
        let (up, down) = (up?, down?);
        Some(if up.x > down.x {
            Self { left: down, right: up, sign: 1 }
        } else {
            Self { left: up, right: down, sign: -1 }
        })
    }

    /// Height at a crossed column, between the heights of the ends.
    #[inline(always)]
    pub(crate) fn height(&self, x: f64) -> f64 {
        let Self { left, right, .. } = self;
        let share = (x - left.x) / (right.x - left.x);
        (left.z + share * (right.z - left.z)).max(left.z.min(right.z)).min(left.z.max(right.z))
    }
}

/// Crossing of an edge with `y`: computed from its lower end, so that both triangles at it get the same bits, and
/// clamped to its box, so that no triangle crosses a column beyond its own bounds.
#[inline(always)]
fn point_of_edge(from: DVec3, to: DVec3, y: f64) -> DVec3 {
    let (low, high) = if from.y < to.y { (from, to) } else { (to, from) };
    let at = low + (high - low) * ((y - low.y) / (high.y - low.y));
    at.max(low.min(high)).min(low.max(high))
}

/// Sign of the z of a triangle's normal if the upward ray from a point crosses it, otherwise 0.
#[inline]
pub(crate) fn crossing_above(corners: &[DVec3; 3], point: DVec3) -> i32 {
    match Span::at(corners, point.y) {
        Some(span) if span.left.x <= point.x && point.x < span.right.x && span.height(point.x) > point.z => span.sign,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of crossings of a column with two upward triangles over a square.
    fn crossings([a, b, c, d]: [DVec3; 4], x: f64, y: f64) -> i32 {
        let point = DVec3::new(x, y, -1e9);
        crossing_above(&[a, b, c], point) + crossing_above(&[a, c, d], point)
    }

    #[test]
    fn a_column_an_ulp_beside_an_edge_belongs_to_one_side() {
        let ulps = [-1e-17, -f64::MIN_POSITIVE, 0.0, f64::MIN_POSITIVE, 1e-17];
        for edge in ulps {
            // One square left of x = edge, one right of it.
            let square = |low: f64, high: f64| {
                [(low, -3.0), (high, -3.0), (high, 3.0), (low, 3.0)].map(|(x, y)| DVec3::new(x, y, 0.1 * x))
            };
            for x in ulps.into_iter().chain([-4.0, 4.0]) {
                let sides = [crossings(square(-5.0, edge), x, 0.0), crossings(square(edge, 5.0), x, 0.0)];
                assert_eq!(sides, if x < edge { [1, 0] } else { [0, 1] }, "column {x:e}, edge at {edge:e}");
            }
        }
    }

    #[test]
    fn no_point_of_an_edge_is_beyond_its_ends() {
        let (low, high) = (DVec3::new(-1e10 / 3.0, -1.0, 7.0), DVec3::new(1e-17, 2.0, 7.0 + 1e-15));
        for i in -10..=20 {
            let y = f64::from(i) / 10.0;
            let at = point_of_edge(low, high, y);
            assert!(at.x <= high.x && at.z >= low.z && at.z <= high.z, "{at} at {y}");
        }
    }
}
