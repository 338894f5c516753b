//! φ of each brick with the voxels around it, so that any cell or stencil of a brick is read from one array.
//!
//! ```text
//!    ┌─┬────────┬──┐
//!    │·│········│··│   one voxel before the brick's 8 and two after them along every axis: the 4³ voxels around any of
//!    └─┴────────┴──┘   its cells
//! ```

use glam::{IVec3, Vec3, Vec4};
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, OUTSIDE, trilinear};

use super::field::Field;
use super::lanes::{LANES, Lanes, Points, integer};
use super::occupancy::Blocks;
use super::shadow::PENUMBRA_BAND;
use super::walk::BRICK_SHIFT;

/// Voxels along a side.
const SIDE: usize = 11;
/// Offsets to the next voxel along x, y and z.
const STEPS: [usize; 3] = [SIDE * SIDE, SIDE, 1];
/// Offset of the brick's own first voxel.
const OWN: usize = STEPS[0] + STEPS[1] + STEPS[2];
/// Voxels of a padded brick.
const VOXELS: usize = SIDE * SIDE * SIDE;
/// Offset of the cell's last voxel, plus one.
const CELL: usize = OWN + 1;

/// Contents at an index entry.
#[derive(Clone, Copy, Debug)]
struct Site {
    /// Offset of its padded brick's first voxel.
    first: u32,
    /// Distance to the nearest brick with metal, as in [`Entry`](super::index::Entry).
    to_metal: u8,
    to_brick: u8,
    /// Label of all voxels of its cells, if it is unique.
    label: Option<u16>,
    /// True if no voxel of its cells has a dose or removed depth.
    is_plain: bool,
}

/// Padded bricks. Bricks without a cell that crosses φ's range share one.
#[derive(Clone, Debug)]
pub(crate) struct Padded {
    values: Vec<f32>,
    /// Brick coordinates in the grid, with the blocks of each brick that can cast a shadow, as in [`Blocks`].
    pub(crate) near: Vec<(IVec3, Blocks)>,
    /// One per index entry; the last one stands for all positions beyond the index.
    sites: Vec<Site>,
    dims: [u32; 3],
    steps: [u32; 3],
}

/// Cells of the samples.
pub(crate) struct Cells {
    /// Lowest corners [voxels].
    pub(crate) low: Points,
    /// φ at the eight corners [m], z fastest.
    pub(crate) values: [Lanes; 8],
    /// Brick coordinates in the grid.
    pub(crate) bricks: [[i32; LANES]; 3],
    /// Distances to the nearest brick with metal, and to the nearest that is not outside [bricks].
    pub(crate) to_metal: [i32; LANES],
    pub(crate) to_brick: [i32; LANES],
    sites: [u32; LANES],
    voxels: [u32; LANES],
}

impl Padded {
    /// Copies φ of all bricks at or next to the surface.
    pub(crate) fn new(field: &Field) -> Self {
        let (index, grid) = (&field.index, field.grid);
        let [x, y, z] = index.steps;
        let dims = grid.dims.as_uvec3().to_array();
        let none = Site { first: 0, to_metal: 1, to_brick: 1, label: Some(0), is_plain: true };
        let mut padded = Self {
            values: [[grid.band; VOXELS], [-grid.band; VOXELS]].concat(),
            near: Vec::new(),
            sites: vec![none; index.len() + 1],
            dims,
            steps: index.steps.map(|step| step as u32),
        };
        let labels: Vec<Option<u16>> = grid.label.chunks(BRICK_VOXELS).map(only).collect();
        let scalars = [&grid.dose[..], &grid.removed];
        let is_zero = |slot: usize| {
            let of = |values: &[f32]| {
                values.chunks(BRICK_VOXELS).nth(slot).is_none_or(|brick| brick.iter().all(|v| *v == 0.0))
            };
            scalars.into_iter().all(of)
        };
        let plain: Vec<bool> = (0..grid.bricks.len()).map(is_zero).collect();
        let bricks = (-1..grid.dims.x)
            .flat_map(|x| (-1..grid.dims.y).flat_map(move |y| (-1..grid.dims.z).map(move |z| IVec3::new(x, y, z))));
        for brick in bricks {
            let place = index.place(brick).expect("a brick of the index");
            let entry = index.at(place);
            if entry.to_brick > 1 {
                padded.sites[place] = Site { to_metal: entry.to_metal, to_brick: entry.to_brick, ..none };
                continue;
            }
            let corners = [0, z, y, y + z, x, x + z, x + y, x + y + z].map(|step| index.slot(place + step));
            let label = common(corners.map(|slot| labels.get(slot as usize).copied().unwrap_or(Some(0))));
            let is_plain = corners.iter().all(|&slot| plain.get(slot as usize).is_none_or(|is_plain| *is_plain));
            let first = match corners {
                [OUTSIDE, ..] if corners == [OUTSIDE; 8] => 0,
                // No need among those that cast a shadow: a ray from here meets the surface in another brick.
                [INSIDE, ..] if corners == [INSIDE; 8] => VOXELS,
                _ => padded.push(field, brick),
            };
            padded.sites[place] =
                Site { first: first as u32, to_metal: entry.to_metal, to_brick: entry.to_brick, label, is_plain };
        }
        padded
    }

    /// Adds a brick and returns its offset.
    fn push(&mut self, field: &Field, brick: IVec3) -> usize {
        let first = self.values.len();
        self.values.resize(first + VOXELS, 0.0);
        let (constant, rest) = self.values.split_at_mut(2 * VOXELS);
        let around: [&[f32]; 27] = std::array::from_fn(|i| {
            let step = IVec3::new(i as i32 / 9, i as i32 / 3 % 3, i as i32 % 3) - 1;
            match field.index.entry(brick + step).slot {
                OUTSIDE => &constant[..BRICK_VOXELS],
                INSIDE => &constant[VOXELS..VOXELS + BRICK_VOXELS],
                slot => &field.grid.phi[slot as usize * BRICK_VOXELS..(slot as usize + 1) * BRICK_VOXELS],
            }
        });
        // Brick before, own or after, and the voxel within it.
        let split = |i: usize| (i.div_ceil(8), (i + 7) % 8);
        for (i, row) in rest[first - 2 * VOXELS..].chunks_exact_mut(SIDE).enumerate() {
            let ((brick_x, x), (brick_y, y)) = (split(i / SIDE), split(i % SIDE));
            let of = |brick_z: usize| &around[9 * brick_x + 3 * brick_y + brick_z][64 * x + 8 * y..][..8];
            row[0] = of(0)[7];
            row[1..9].copy_from_slice(of(1));
            row[9..].copy_from_slice(&of(2)[..2]);
        }
        let near = blocks_below(&self.values[first..], 1.001 * PENUMBRA_BAND * field.grid.band);
        if near.0 != 0 {
            self.near.push((brick, near));
        }
        first
    }

    /// Reads φ for the `wanted` samples, whose lowest corners are in `cells`.
    #[inline(always)]
    pub(crate) fn read(&self, wanted: &[bool; LANES], cells: &mut Cells) {
        self.find(cells);
        for (lane, _) in wanted.iter().enumerate().filter(|(_, wanted)| **wanted) {
            let site = self.sites[cells.sites[lane] as usize];
            let first = (site.first + cells.voxels[lane]) as usize;
            let v = &self.values[first..first + CELL];
            let cell = [v[0], v[1], v[11], v[12], v[121], v[122], v[132], v[133]];
            for (values, value) in cells.values.iter_mut().zip(cell) {
                values[lane] = value;
            }
            (cells.to_metal[lane], cells.to_brick[lane]) = (i32::from(site.to_metal), i32::from(site.to_brick));
        }
    }

    /// Finds the cells of the samples, whose lowest corners are in `cells`.
    #[inline(always)]
    pub(crate) fn find(&self, cells: &mut Cells) {
        let ([across, along, up], [step_x, step_y, step_z]) = (self.dims, self.steps);
        let beyond = self.sites.len() as u32 - 1;
        for i in 0..LANES {
            let (x, y, z) = (integer(cells.low.x[i]), integer(cells.low.y[i]), integer(cells.low.z[i]));
            let [bx, by, bz] = [x >> BRICK_SHIFT, y >> BRICK_SHIFT, z >> BRICK_SHIFT];
            (cells.bricks[0][i], cells.bricks[1][i], cells.bricks[2][i]) = (bx, by, bz);
            let [ax, ay, az] = [bx.wrapping_add(1) as u32, by.wrapping_add(1) as u32, bz.wrapping_add(1) as u32];
            let is_within = (ax <= across) & (ay <= along) & (az <= up);
            let place = ax.wrapping_mul(step_x).wrapping_add(ay.wrapping_mul(step_y)).wrapping_add(az * step_z);
            cells.sites[i] = if is_within { place } else { beyond };
            let [x, y, z] = [(x & 7) as u32, (y & 7) as u32, (z & 7) as u32];
            cells.voxels[i] = OWN as u32 + x * STEPS[0] as u32 + y * STEPS[1] as u32 + z;
        }
    }

    /// φ [m] at a position (0 to 1) in a cell, with the index entry of its brick.
    #[inline]
    pub(crate) fn phi(&self, place: usize, corner: IVec3, within: Vec3) -> f32 {
        let local = (corner & 7).as_usizevec3();
        let first = self.sites[place].first as usize + OWN + local.x * STEPS[0] + local.y * STEPS[1] + local.z;
        let v = &self.values[first..first + CELL];
        trilinear(&[v[0], v[1], v[11], v[12], v[121], v[122], v[132], v[133]], within)
    }

    /// Label of all voxels of the cells of a lane's brick, if it is unique.
    #[inline(always)]
    pub(crate) fn label(&self, cells: &Cells, lane: usize) -> Option<u16> {
        self.sites[cells.sites[lane] as usize].label
    }

    /// True if no voxel of the cells of a lane's brick has a dose or removed depth.
    #[inline(always)]
    pub(crate) fn is_plain(&self, cells: &Cells, lane: usize) -> bool {
        self.sites[cells.sites[lane] as usize].is_plain
    }

    /// Differences of φ over two voxels along the axes, at a position (0 to 1) in a lane's cell; parallel to the normal
    /// of [`Field::normal`].
    #[inline(always)]
    pub(crate) fn differences(&self, cells: &Cells, lane: usize, f: Vec3) -> Vec3 {
        let first = (self.sites[cells.sites[lane] as usize].first + cells.voxels[lane]) as usize - OWN;
        let v = &self.values[first..first + 3 * OWN + 1];
        let column = |x: usize, y: usize| {
            let from = x * STEPS[0] + y * STEPS[1];
            Vec4::from_slice(&v[from..from + 4])
        };
        let mix = |a: Vec4, b: Vec4, t: f32| a + (b - a) * t;
        let inner = [column(1, 1), column(1, 2), column(2, 1), column(2, 2)];
        let along_x = |y: usize, [low, high]: [Vec4; 2]| mix(high - column(0, y), column(3, y) - low, f.x);
        let along_y = |x: usize, [low, high]: [Vec4; 2]| mix(high - column(x, 0), column(x, 3) - low, f.y);
        let x = mix(along_x(1, [inner[0], inner[2]]), along_x(2, [inner[1], inner[3]]), f.y);
        let y = mix(along_y(1, [inner[0], inner[1]]), along_y(2, [inner[2], inner[3]]), f.x);
        let z = mix(mix(inner[0], inner[1], f.y), mix(inner[2], inner[3], f.y), f.x);
        let level = |m: Vec4| m.y + (m.z - m.y) * f.z;
        let up = (z.z - z.x) + ((z.w - z.y) - (z.z - z.x)) * f.z;
        Vec3::new(level(x), level(y), up)
    }
}

/// Returns the label of some voxels if it is unique.
fn only(labels: &[u16]) -> Option<u16> {
    let first = *labels.first()?;
    labels.iter().fold(true, |same, label| same & (*label == first)).then_some(first)
}

/// Returns the label that all eight share.
fn common(labels: [Option<u16>; 8]) -> Option<u16> {
    labels[0].filter(|_| labels.iter().all(|label| *label == labels[0]))
}

/// Blocks of a padded brick with a corner below a limit.
fn blocks_below(values: &[f32], limit: f32) -> Blocks {
    let least =
        |of: &dyn Fn(usize) -> f32, block: usize| of(2 * block + 1).min(of(2 * block + 2)).min(of(2 * block + 3));
    let mut bits = 0;
    for x in (0..4).rev() {
        for y in (0..4).rev() {
            for z in (0..4).rev() {
                let of_row = |x: usize, y: usize| least(&|z| values[x * STEPS[0] + y * STEPS[1] + z], z);
                let is_below = least(&|x| least(&|y| of_row(x, y), y), x) < limit;
                bits = bits << 1 | u64::from(is_below);
            }
        }
    }
    Blocks(bits)
}

impl Cells {
    pub(crate) fn new(band: f32) -> Self {
        Self {
            low: Points::ZERO,
            values: [[band; LANES]; 8],
            bricks: [[0; LANES]; 3],
            to_metal: [0; LANES],
            to_brick: [0; LANES],
            sites: [0; LANES],
            voxels: [0; LANES],
        }
    }

    /// φ [m] of a lane at a position in its cell, 0 to 1, as [`trilinear`](sdf_bake::grid::trilinear).
    #[inline(always)]
    pub(crate) fn phi(&self, lane: usize, within: Vec3) -> f32 {
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let z = |i: usize| mix(self.values[i][lane], self.values[i + 1][lane], within.z);
        let y = |i: usize| mix(z(i), z(i + 2), within.y);
        mix(y(0), y(4), within.x)
    }

    /// Lowest corner and side [voxels] of the free cube around the brick of a lane; `distance` ≥ 1 is the distance to
    /// the nearest occupied brick [bricks].
    #[inline(always)]
    pub(crate) fn free_cube(&self, lane: usize, distance: i32) -> (Vec3, f32) {
        let reach = distance - 1;
        let low = |axis: usize| ((self.bricks[axis][lane] - reach) << BRICK_SHIFT) as f32;
        (Vec3::new(low(0), low(1), low(2)), ((2 * reach + 1) << BRICK_SHIFT) as f32)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::BrickGrid;
    use sdf_bake::grid::trilinear;

    use super::*;
    use crate::field::cell_of;

    #[test]
    fn padded_bricks_hold_the_cells_and_normals_of_the_field() {
        let half = DVec3::new(0.012, 0.009, 0.01);
        // Cut off at one side, so that metal reaches the border of the index.
        let shape = |p: DVec3| (p.length() - 0.0105).max(p.y.abs() - 0.02);
        let mut grid = BrickGrid::from_distance(-half, half, 0.0005, 3.0, shape);
        grid.label = (0..grid.phi.len()).map(|i| u16::from(grid.position(grid.voxel_of(i)).x > 0.004)).collect();
        let field = Field::new(&grid);
        let padded = field.padded();
        let point = |i: usize| {
            let i = i as f64;
            field.in_voxels(DVec3::new((2.4 * i).cos(), (2.4 * i).sin(), (0.7 * i).sin()) * (0.0004 * (i % 37.0)))
        };
        let (mut cells, mut normals, mut labels) = (Cells::new(grid.band), 0, 0);
        for first in (0..6000).step_by(LANES) {
            let mut at = Points::ZERO;
            (0..LANES).for_each(|lane| at.set(lane, point(first + lane)));
            at.set(3, Vec3::splat(1e5));
            cells.low = at.corners(&Points::ZERO);
            padded.read(&[true; LANES], &mut cells);
            for lane in 0..LANES {
                let (corner, within) = cell_of(at.get(lane));
                let brick = corner >> BRICK_SHIFT;
                let entry = field.index.entry(brick);
                assert_eq!(cells.phi(lane, within), trilinear(&field.cell_phi(corner), within), "at {corner}");
                assert_eq!(cells.to_brick[lane], i32::from(entry.to_brick));
                assert_eq!(cells.to_metal[lane], i32::from(entry.to_metal));
                if let Some(label) = padded.label(&cells, lane) {
                    assert_eq!(field.cell(corner, &grid.label, 0, 0), [label; 8], "at {corner}");
                    labels += 1;
                }
                let in_metal = field.cell_phi(corner).map(|phi| phi <= 0.0);
                let is_crossed = in_metal.contains(&true) && in_metal.contains(&false);
                if let (true, Some(normal)) = (is_crossed, field.normal(at.get(lane))) {
                    assert!(
                        (padded.differences(&cells, lane, within).normalize() - normal).length() < 1e-5,
                        "at {corner}"
                    );
                    normals += 1;
                }
            }
        }
        assert!(normals > 100 && labels > 1000, "{normals} normals, {labels} labels");
    }
}
