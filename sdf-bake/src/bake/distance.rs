//! Exact distance from voxels to a brick's own triangles.

use glam::{DVec3, IVec3};

use super::brick_centre;
use crate::grid::{BRICK_VOXELS, BrickGrid, voxel_at};

/// A triangle made ready for many distance queries.
pub(super) struct Facet {
    a: DVec3,
    ab: DVec3,
    ac: DVec3,
    /// Unit normal, zero if degenerate.
    normal: DVec3,
}

impl Facet {
    pub(super) fn new([a, b, c]: [DVec3; 3]) -> Self {
        let (ab, ac) = (b - a, c - a);
        Self { a, ab, ac, normal: ab.cross(ac).normalize_or_zero() }
    }

    pub(super) fn bounds(&self) -> (DVec3, DVec3) {
        let (b, c) = (self.a + self.ab, self.a + self.ac);
        (self.a.min(b).min(c), self.a.max(b).max(c))
    }

    /// Squared distance from the triangle's plane [m²]: a lower bound of the distance.
    fn squared_plane_distance(&self, point: DVec3) -> f64 {
        let height = self.normal.dot(point - self.a);
        height * height
    }

    /// Squared distance [m²] to the closest point of the triangle, by its Voronoi regions (Ericson 2005, §5.1.5).
    pub(super) fn squared_distance(&self, point: DVec3) -> f64 {
        let ap = point - self.a;
        let (d1, d2) = (self.ab.dot(ap), self.ac.dot(ap));
        if d1 <= 0.0 && d2 <= 0.0 {
            return ap.length_squared();
        }
        let bp = ap - self.ab;
        let (d3, d4) = (self.ab.dot(bp), self.ac.dot(bp));
        if d3 >= 0.0 && d4 <= d3 {
            return bp.length_squared();
        }
        let cp = ap - self.ac;
        let (d5, d6) = (self.ab.dot(cp), self.ac.dot(cp));
        if d6 >= 0.0 && d5 <= d6 {
            return cp.length_squared();
        }
        if d1 * d4 - d3 * d2 <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            return (ap - self.ab * (d1 / (d1 - d3))).length_squared();
        }
        if d5 * d2 - d1 * d6 <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            return (ap - self.ac * (d2 / (d2 - d6))).length_squared();
        }
        if d3 * d6 - d5 * d4 <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
            return (bp - (self.ac - self.ab) * along).length_squared();
        }
        self.squared_plane_distance(point)
    }
}

/// Squared distance [m²] from each voxel of a brick to the nearest of its triangles.
pub(super) fn squared_distances(
    brick: IVec3,
    triangles: &[u32],
    facets: &[Facet],
    grid: &BrickGrid,
) -> Box<[f64; BRICK_VOXELS]> {
    let band = f64::from(grid.band);
    let mut nearest = Box::new([band * band * 1.0001; BRICK_VOXELS]);
    let positions: Vec<DVec3> = (0..BRICK_VOXELS).map(|o| grid.position(voxel_at(brick, o))).collect();
    for &triangle in &nearest_first(brick, triangles, facets, grid) {
        let facet = &facets[triangle as usize];
        for (best, &point) in nearest.iter_mut().zip(&positions) {
            if facet.squared_plane_distance(point) < *best {
                *best = best.min(facet.squared_distance(point));
            }
        }
    }
    nearest
}

/// Triangles by distance from the brick's centre, so that later ones are mostly culled by their plane.
fn nearest_first(brick: IVec3, triangles: &[u32], facets: &[Facet], grid: &BrickGrid) -> Vec<u32> {
    let centre = brick_centre(brick, grid.voxel);
    let mut order: Vec<(f64, u32)> =
        triangles.iter().map(|&t| (facets[t as usize].squared_distance(centre), t)).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    order.into_iter().map(|(_, t)| t).collect()
}
