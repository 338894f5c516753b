//! A grid prepared for ray tracing.

use std::sync::OnceLock;

use glam::{DVec3, IVec3, Vec3, Vec3A};
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_SIDE, BRICK_VOXELS, INSIDE, OUTSIDE, voxel_offset};

use super::fusion_line::FusionLine;
use super::index::Index;
use super::occupancy::{Blocks, occupancy};
use super::padded::Padded;
use super::walk::{integers, nearest_whole};

/// A grid and the places where rays can meet its surface. Built once for a state of the part, used for any number of
/// rays.
#[derive(Clone, Debug)]
pub struct Field<'a> {
    /// The part.
    pub grid: &'a BrickGrid,
    /// The grid's index with the free distance around each brick.
    pub(crate) index: Index,
    /// Blocks of each brick that contain a voxel inside the metal.
    pub(crate) metal: Vec<Blocks>,
    /// Blocks of each brick that contain a voxel outside.
    pub(crate) air: Vec<Blocks>,
    /// Bounding box of the bricks that contain metal, relative to the lowest voxel of the index [voxels].
    pub(crate) metal_box: (Vec3, Vec3),
    /// Lowest voxel of the index [voxels].
    pub(crate) lowest: DVec3,
    /// Voxels per metre.
    pub(crate) per_metre: f64,
    /// φ padded for reading many samples at a time; built on first use.
    padded: OnceLock<Padded>,
    /// Fusion lines of the welds; found on first use.
    fusion_line: OnceLock<FusionLine>,
}

impl<'a> Field<'a> {
    /// Scans the whole pool once.
    pub fn new(grid: &'a BrickGrid) -> Self {
        let (metal, air) = occupancy(grid);
        let occupied = grid.bricks.iter().zip(&metal).filter(|(_, blocks)| blocks.0 != 0).map(|(&brick, _)| brick);
        let inside = (0..grid.index.tile_count()).flat_map(|tile| grid.index.inside_of(tile));
        let inside = inside.map(|brick| grid.origin + brick);
        let none = (IVec3::MAX, IVec3::MIN);
        let (low, high) = occupied.chain(inside).fold(none, |(low, high), brick| (low.min(brick), high.max(brick)));
        let voxels = |brick: IVec3| ((brick - grid.origin) * BRICK_SIDE as i32).as_vec3();
        let metal_box =
            if low.cmple(high).all() { (voxels(low), voxels(high + IVec3::ONE)) } else { (Vec3::ZERO, Vec3::ZERO) };
        let lowest = (grid.origin * BRICK_SIDE as i32).as_dvec3();
        let (index, per_metre) = (Index::new(grid, &metal), grid.voxel.recip());
        let (padded, fusion_line) = (OnceLock::new(), OnceLock::new());
        Self { grid, index, metal, air, metal_box, lowest, per_metre, padded, fusion_line }
    }

    /// φ of each brick with the voxels around it.
    pub(crate) fn padded(&self) -> &Padded {
        // Built on this thread alone: threads that wait for it might be the ones that should help.
        self.padded.get_or_init(|| Padded::new(self))
    }

    /// Fusion lines of the grid's welds.
    pub(crate) fn fusion_line(&self) -> &FusionLine {
        self.fusion_line.get_or_init(|| FusionLine::of(self.grid))
    }

    /// Converts a point [m] to voxels from the lowest voxel of the index.
    #[inline]
    pub(crate) fn in_voxels(&self, point: DVec3) -> Vec3 {
        (point * self.per_metre - self.lowest).as_vec3()
    }

    /// Returns the values at the eight corners of a cell, z fastest, from values stored per voxel of the pool. `corner`
    /// is relative to the lowest voxel of the index.
    #[inline]
    pub(crate) fn cell<T: Copy>(&self, corner: IVec3, values: &[T], outside: T, inside: T) -> [T; 8] {
        let (local, Some(place)) = (corner & 7, self.index.place(corner >> 3)) else { return [outside; 8] };
        if local.x == 7 || local.y == 7 || local.z == 7 {
            return self.cell_between(place, local, values, outside, inside);
        }
        match self.index.slot(place) {
            OUTSIDE => [outside; 8],
            INSIDE => [inside; 8],
            slot => {
                let from = slot as usize * BRICK_VOXELS + voxel_offset(corner);
                let v = &values[from..from + 74];
                [v[0], v[1], v[8], v[9], v[64], v[65], v[72], v[73]]
            }
        }
    }

    /// [`Field::cell`] for a cell that spans several bricks.
    fn cell_between<T: Copy>(&self, place: usize, local: IVec3, values: &[T], outside: T, inside: T) -> [T; 8] {
        let block = Block::<2>::new(self, place, local);
        let mut cell = [outside; 8];
        for (i, value) in cell.iter_mut().enumerate() {
            *value = block.at(i >> 2, i >> 1 & 1, i & 1, values, outside, inside);
        }
        cell
    }

    /// φ [m] at the eight corners of a cell.
    #[inline]
    pub(crate) fn cell_phi(&self, corner: IVec3) -> [f32; 8] {
        self.cell(corner, &self.grid.phi, self.grid.band, -self.grid.band)
    }

    /// Outward unit normal at a point [voxels], from differences over two voxels; `None` where φ is constant. They
    /// equal the voxels' central differences interpolated trilinearly; unlike narrower ones they do not jump from cell
    /// to cell.
    pub(crate) fn normal(&self, at: Vec3) -> Option<Vec3> {
        let (corner, f) = cell_of(at);
        let low = corner - 1;
        let place = self.index.place(low >> 3)?;
        let block = Block::<4>::new(self, place, low & 7);
        let (phi, band) = (&self.grid.phi[..], self.grid.band);
        let voxel = |x: usize, y: usize, z: usize| block.at(x, y, z, phi, band, -band);
        let (mut middle, mut columns) = ([[0.0; 4]; 4], [[[0.0; 4]; 2]; 2]);
        for x in 0..4 {
            for y in 0..4 {
                let is_inner = (x == 1 || x == 2, y == 1 || y == 2);
                match is_inner {
                    (true, true) => {
                        let column = [voxel(x, y, 0), voxel(x, y, 1), voxel(x, y, 2), voxel(x, y, 3)];
                        (columns[x - 1][y - 1], middle[x][y]) = (column, mix(column[1], column[2], f.z));
                    }
                    (false, false) => {}
                    _ => middle[x][y] = mix(voxel(x, y, 1), voxel(x, y, 2), f.z),
                }
            }
        }
        let level = |m: [[f32; 2]; 2]| mix(mix(m[0][0], m[0][1], f.y), mix(m[1][0], m[1][1], f.y), f.x);
        let around =
            |x: usize, y: usize| level([[middle[x][y], middle[x][y + 1]], [middle[x + 1][y], middle[x + 1][y + 1]]]);
        let layer = |z: usize| {
            let of = |column: &[f32; 4]| mix(column[z], column[z + 1], f.z);
            level([[of(&columns[0][0]), of(&columns[0][1])], [of(&columns[1][0]), of(&columns[1][1])]])
        };
        let across = [around(2, 1) - around(0, 1), around(1, 2) - around(1, 0), layer(2) - layer(0)];
        Vec3::from_array(across).try_normalize()
    }
}

#[inline]
fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Returns the cell of a point and the position within it, 0 to 1.
#[inline]
pub(crate) fn cell_of(at: Vec3) -> (IVec3, Vec3) {
    let at = Vec3A::from(at);
    let nearest = nearest_whole(at);
    let low = nearest - Vec3A::select(nearest.cmpgt(at), Vec3A::ONE, Vec3A::ZERO);
    (integers(low), (at - low).into())
}

/// Addresses of N³ voxels, which lie in up to eight bricks.
struct Block<'a, const N: usize> {
    index: &'a Index,
    /// Index entry of the lowest voxel's brick.
    place: usize,
    /// For each axis and each step along it: offset of the entry, and this axis's part of the offset in the brick.
    steps: [[(usize, usize); N]; 3],
}

impl<'a, const N: usize> Block<'a, N> {
    /// `place`: index entry of the lowest voxel's brick; `local`: that voxel within the brick.
    #[inline]
    fn new(field: &'a Field, place: usize, local: IVec3) -> Self {
        let index = &field.index;
        let mut steps = [[(0, 0); N]; 3];
        for (axis, steps) in steps.iter_mut().enumerate() {
            for (i, step) in steps.iter_mut().enumerate() {
                let at = local[axis] as usize + i;
                let entry = if at < BRICK_SIDE { 0 } else { index.steps[axis] };
                *step = (entry, (at % BRICK_SIDE) << (6 - 3 * axis));
            }
        }
        Self { index, place, steps }
    }

    /// Value of a voxel, counted from the lowest one.
    #[inline]
    fn at<T: Copy>(&self, x: usize, y: usize, z: usize, values: &[T], outside: T, inside: T) -> T {
        let (x, y, z) = (self.steps[0][x], self.steps[1][y], self.steps[2][z]);
        match self.index.slot(self.place + x.0 + y.0 + z.0) {
            OUTSIDE => outside,
            INSIDE => inside,
            slot => values[slot as usize * BRICK_VOXELS + (x.1 | y.1 | z.1)],
        }
    }
}
