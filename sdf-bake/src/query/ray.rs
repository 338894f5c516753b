//! First hit and occlusion test of a ray, watertight across shared edges.

use glam::DVec3;
use obvhs::aabb::Aabb;

use super::MeshQuery;

/// First hit of a ray with the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance from the ray's origin [m].
    pub distance: f64,
    /// Index of the triangle; the lowest one if several are hit at the same distance.
    pub triangle: u32,
}

impl MeshQuery {
    /// Returns the first triangle, of either side, hit within `reach` [m] along `direction` (of any length).
    ///
    /// A ray through a shared edge or vertex hits a triangle there: nothing slips between. A triangle whose plane
    /// contains the ray is not hit; its neighbours are.
    pub fn ray(&self, origin: DVec3, direction: DVec3, reach: f64) -> Option<Hit> {
        let ray = Ray::new(origin - self.centre, direction)?;
        let mut best = Hit { distance: reach, triangle: u32::MAX };
        self.walk(&ray, |bound, leaf| {
            if let Some((triangle, distance)) = leaf.map(|i| (self.triangles[i], ray.meet(self.corners[i])))
                && (distance < best.distance || (distance == best.distance && triangle < best.triangle))
            {
                best = Hit { distance, triangle };
            }
            bound <= best.distance
        });
        (best.triangle != u32::MAX).then_some(best)
    }

    /// True if anything is hit within `reach` [m] along `direction`, including at the origin.
    ///
    /// To test from a point of the surface, start slightly above it.
    pub fn occluded(&self, origin: DVec3, direction: DVec3, reach: f64) -> bool {
        let Some(ray) = Ray::new(origin - self.centre, direction) else {
            return false;
        };
        let mut met = false;
        self.walk(&ray, |bound, leaf| {
            met = met || leaf.is_some_and(|i| ray.meet(self.corners[i]) <= reach);
            !met && bound <= reach
        });
        met
    }

    /// Visits nodes front to back. `visit` gets a node's entry distance [m], or a leaf triangle, and returns true if
    /// the node must be entered.
    fn walk(&self, ray: &Ray, mut visit: impl FnMut(f64, Option<usize>) -> bool) {
        if self.corners.is_empty() {
            return;
        }
        let mut stack = Vec::with_capacity(64);
        stack.push((0u32, ray.enter(self.bvh.nodes[0].aabb())));
        while let Some((index, entry)) = stack.pop() {
            if entry == f64::INFINITY || !visit(entry, None) {
                continue;
            }
            let node = &self.bvh.nodes[index as usize];
            if node.is_leaf() {
                for leaf in node.first_index..node.first_index + node.prim_count {
                    visit(entry, Some(leaf as usize));
                }
                continue;
            }
            let children = [node.first_index, node.first_index + 1];
            let [near, far] = children.map(|i| (i, ray.enter(self.bvh.nodes[i as usize].aabb())));
            let (near, far) = if far.1 < near.1 { (far, near) } else { (near, far) };
            stack.extend([far, near]);
        }
    }
}

struct Ray {
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
}

impl Ray {
    /// `None` unless the origin is finite and the direction has nonzero length.
    fn new(origin: DVec3, direction: DVec3) -> Option<Self> {
        let direction = direction.try_normalize().filter(|_| origin.is_finite())?;
        // A huge number in place of infinity keeps 0 · ∞ out of the slab test.
        let invert = |x: f64| if x.abs() < 1e-200 { 1e200 } else { 1.0 / x };
        let inverse = DVec3::new(invert(direction.x), invert(direction.y), invert(direction.z));
        Some(Self { origin, direction, inverse })
    }

    /// Distance [m] at which the ray enters a box; infinite for a miss.
    fn enter(&self, bounds: &Aabb) -> f64 {
        let (low, high) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let (one, other) = ((low - self.origin) * self.inverse, (high - self.origin) * self.inverse);
        let entry = one.min(other).max_element().max(0.0);
        let exit = one.max(other).min_element();
        // Bound on the rounding of three operations on each side (Ize 2013).
        if entry * (1.0 - 1e-14) <= exit * (1.0 + 1e-14) { entry * (1.0 - 1e-14) } else { f64::INFINITY }
    }

    /// Distance [m] to a triangle; infinite for a miss.
    ///
    /// The three volumes spanned by the ray and an edge have equal signs inside. On a shared edge, two triangles
    /// compute the same number except for its sign, so no ray passes between them (after Woop, Benthin & Wald 2013).
    fn meet(&self, corners: [DVec3; 3]) -> f64 {
        let [a, b, c] = corners.map(|corner| corner - self.origin);
        let [u, v, w] = [c.cross(b), a.cross(c), b.cross(a)].map(|moment| moment.dot(self.direction));
        let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
        let sum = u + v + w;
        if !inside || sum == 0.0 {
            return f64::INFINITY;
        }
        let distance = (u / sum * a + v / sum * b + w / sum * c).dot(self.direction);
        if distance >= 0.0 { distance } else { f64::INFINITY }
    }
}
