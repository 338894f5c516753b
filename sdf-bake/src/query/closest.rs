//! Closest point of the mesh: depth-first traversal, nearer child first.

use glam::DVec3;
use obvhs::aabb::Aabb;

use super::{MeshQuery, closest_on_triangle};

/// The point of a mesh nearest to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// The nearest point of the surface [m].
    pub point: DVec3,
    /// Unsigned distance to it [m]; infinite if the mesh has no triangles.
    pub distance: f64,
    /// Index of the triangle that contains it; the lowest one if there are several.
    pub triangle: u32,
    /// Barycentric coordinates of `point`; they sum to 1.
    pub barycentric: [f64; 3],
}

impl MeshQuery {
    /// Returns the point of the surface nearest to `point` [m].
    ///
    /// If there are no triangles, or the point is not finite, the distance is infinite and the triangle `u32::MAX`.
    pub fn closest(&self, point: DVec3) -> Closest {
        self.closest_within(point, f64::INFINITY).unwrap_or(Closest {
            point,
            distance: f64::INFINITY,
            triangle: u32::MAX,
            barycentric: [1.0, 0.0, 0.0],
        })
    }

    /// Returns the point of the surface nearest to `point` [m], if it is within `reach` [m].
    pub fn closest_within(&self, point: DVec3, reach: f64) -> Option<Closest> {
        let local = point - self.centre;
        if self.corners.is_empty() || !local.is_finite() || reach.is_nan() {
            return None;
        }
        let mut best = Best { squared: reach * reach, triangle: u32::MAX, leaf: 0, weights: [1.0, 0.0, 0.0] };
        let mut stack = Vec::with_capacity(64);
        stack.push((0u32, squared_distance_to_box(self.bvh.nodes[0].aabb(), local)));
        while let Some((index, bound)) = stack.pop() {
            if bound > best.squared {
                continue;
            }
            let node = &self.bvh.nodes[index as usize];
            if node.is_leaf() {
                for leaf in node.first_index..node.first_index + node.prim_count {
                    self.improve(&mut best, leaf as usize, local);
                }
                continue;
            }
            let children = [node.first_index, node.first_index + 1];
            let [near, far] = children.map(|i| (i, squared_distance_to_box(self.bvh.nodes[i as usize].aabb(), local)));
            let (near, far) = if far.1 < near.1 { (far, near) } else { (near, far) };
            stack.extend([far, near]);
        }
        (best.triangle != u32::MAX).then(|| self.answer(best))
    }

    fn improve(&self, best: &mut Best, leaf: usize, local: DVec3) {
        let (weights, squared) = closest_on_triangle(self.corners[leaf], local);
        let triangle = self.triangles[leaf];
        if squared < best.squared || (squared == best.squared && triangle < best.triangle) {
            *best = Best { squared, triangle, leaf, weights };
        }
    }

    fn answer(&self, best: Best) -> Closest {
        let [a, b, c] = self.corners[best.leaf];
        let [u, v, w] = best.weights;
        Closest {
            point: u * a + v * b + w * c + self.centre,
            distance: best.squared.sqrt(),
            triangle: best.triangle,
            barycentric: best.weights,
        }
    }
}

struct Best {
    squared: f64,
    triangle: u32,
    leaf: usize,
    weights: [f64; 3],
}

/// Squared distance [m²] from a point to a box; never more than to the contents of the box.
fn squared_distance_to_box(bounds: &Aabb, point: DVec3) -> f64 {
    let (low, high) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let squared = (low - point).max(point - high).max(DVec3::ZERO).length_squared();
    // One part in 10^14 covers the rounding of the sum of squares here and of the distance to the triangle.
    squared * (1.0 - 1e-14)
}
