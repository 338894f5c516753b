//! Quads and their diagonals.

use glam::{DVec3, IVec3};

use super::cell::edge_ends;
use super::cells::{Brick, CellMap, Corner};
use super::place::Shape;

/// Vertices of the four cells around a lattice edge, counter-clockwise from outside.
pub(super) type Quad = [u32; 4];

/// Share of the inset below which the least height of a triangle counts as zero.
const FLAT: f64 = 0.25;

/// Rule for splitting quads into triangles.
pub(super) struct Split {
    /// Distance between voxels [m].
    pub(super) voxel: f64,
    /// Inset from [`super::settle::inset`].
    pub(super) inset: f64,
}

/// Quads of the lattice edges that start at the voxels of a brick.
pub(super) fn quads(map: &CellMap, brick: &Brick) -> Vec<Quad> {
    let mut quads = Vec::new();
    for cell in &brick.cells {
        let voxel = brick.voxel(cell);
        for axis in 0..3 {
            let edge = 4 * axis;
            if !cell.signs.is_crossed(edge) {
                continue;
            }
            let mut quad = around(map, voxel, axis);
            if !cell.signs.is_inside(edge_ends(edge).0) {
                quad.reverse();
            }
            quads.push(quad);
        }
    }
    quads
}

/// Vertices of the four cells around the edge from `voxel` along an axis, counter-clockwise against that axis.
fn around(map: &CellMap, voxel: IVec3, axis: usize) -> Quad {
    let (u, v) = (IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]);
    [(0, 0), (1, 0), (1, 1), (0, 1)]
        .map(|(i, j)| map.vertex(voxel - u * i - v * j, 4 * axis + 2 * i as usize + j as usize))
}

impl Split {
    /// Splits a quad into two triangles along the diagonal that fits the surface, or along the other if the first gives
    /// a triangle of zero area.
    pub(super) fn triangles(&self, quad @ [a, b, c, d]: Quad, vertices: &[Corner]) -> [[u32; 3]; 2] {
        let corners = quad.map(|vertex| vertices[vertex as usize]);
        let fits = fits_first(corners);
        let [first, second] = self.heights(corners);
        let (kept, other) = if fits { (first, second) } else { (second, first) };
        if fits == (kept >= self.flat() || kept >= other) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    }

    /// True if both diagonals of a quad give a triangle of zero area.
    pub(super) fn is_flat(&self, corners: [Corner; 4]) -> bool {
        self.heights(corners).into_iter().all(|height| height < self.flat())
    }

    fn flat(&self) -> f64 {
        FLAT * self.inset * self.voxel
    }

    /// For both diagonals, the least height of their triangles [m] in single precision.
    fn heights(&self, corners: [Corner; 4]) -> [f64; 2] {
        let [p, q, r, s] = corners.map(|corner| (corner.at * self.voxel).as_vec3().as_dvec3());
        [height([p, q, r]).min(height([p, r, s])), height([p, q, s]).min(height([q, r, s]))]
    }
}

/// The two triangles of a quad with the diagonal that fits the surface [voxels].
pub(super) fn split(corners: [Corner; 4]) -> [[DVec3; 3]; 2] {
    let [p, q, r, s] = corners.map(|corner| corner.at);
    if fits_first(corners) { [[p, q, r], [p, r, s]] } else { [[p, q, s], [q, r, s]] }
}

/// Least height of a triangle.
fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared()).sqrt();
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}

/// True if the first diagonal fits the surface: the outer one at an outer edge, the deeper one at an inner edge,
/// otherwise the shorter one.
fn fits_first(corners: [Corner; 4]) -> bool {
    let [p, q, r, s] = corners.map(|corner| corner.at);
    let shapes = corners.map(|corner| corner.shape);
    let first_stands_out = (r - p).cross(s - q).dot((p + r) - (q + s)) > 0.0;
    match (shapes.contains(&Shape::Outer), shapes.contains(&Shape::Inner)) {
        (true, false) => first_stands_out,
        (false, true) => !first_stands_out,
        _ => p.distance_squared(r) <= q.distance_squared(s),
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A vertex at a place in the cell at (x, y, 0), where 0 is next to the shared edge on x and y.
    fn corner([x, y]: [i32; 2], within: [f64; 3]) -> Corner {
        let cell = IVec3::new(x, y, 0);
        let side = |cell: i32, within: f64| if cell < 0 { -within } else { within };
        let at = DVec3::new(side(x, within[0]), side(y, within[1]), within[2]);
        Corner { at, shape: Shape::Smooth, cell, home: Vec3::ZERO }
    }

    #[test]
    fn four_vertices_at_home_around_an_edge_have_a_diagonal_without_flat_triangles() {
        let inset = 1e-3;
        let ends = |bits: usize| std::array::from_fn(|i| if bits >> i & 1 == 0 { inset } else { 1.0 - inset });
        let split = Split { voxel: 1.0, inset };
        for bits in 0..1 << 12 {
            let cells = [[-1, -1], [0, -1], [0, 0], [-1, 0]];
            let mut place = 0;
            let corners = cells.map(|cell| {
                place += 3;
                corner(cell, ends(bits >> (place - 3)))
            });
            let [first, second] = split.heights(corners);
            assert!(first.max(second) > inset * inset, "{corners:?}: {first}, {second}");
        }
    }
}
