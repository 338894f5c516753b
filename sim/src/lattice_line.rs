//! The signed distance along lattice lines, and the heights at which they leave the material.

use std::ops::Range;

use glam::IVec3;
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, OUTSIDE};
use shaders::constants::CLIMB;

use crate::height_field::{Facing, Window};

/// Index steps between neighbours along x, y and z among a brick's values.
const VALUE_STEPS: [i32; 3] = [64, 8, 1];

/// The lattice lines of a window of a field along one axis, with the slots of the bricks that they cross.
#[derive(Clone, Debug)]
pub(crate) struct Lattice {
    facing: Facing,
    /// Lowest brick index across the lines, and number of bricks along the second of the two axes.
    low: [i32; 2],
    across: i32,
    /// First brick along the lines, and their number.
    first: i32,
    bricks: u32,
    /// Shape `[bricks across, bricks across, bricks along]`.
    slots: Vec<u32>,
    /// Index step from voxel to voxel along the lines among a brick's values.
    value_step: u32,
}

/// A lattice line: indices of its voxels in the field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Index of its first brick's slot.
    brick: u32,
    /// Index of its first voxel among a brick's values.
    value: u32,
}

impl Lattice {
    pub(crate) fn new(grid: &BrickGrid, facing: Facing, window: &Window) -> Self {
        let (axis, (a, b)) = (facing.axis(), facing.across());
        let low = window.low.map(|low| low >> 3);
        let end = [0, 1].map(|d| ((window.low[d] + window.size[d] as i32 - 1) >> 3) + 1);
        let (first, bricks) = (grid.origin[axis], grid.dims[axis]);
        let mut slots = Vec::new();
        let mut brick = IVec3::ZERO;
        for (i, j) in (low[0]..end[0]).flat_map(|i| (low[1]..end[1]).map(move |j| (i, j))) {
            (brick[a], brick[b]) = (i, j);
            slots.extend((first..first + bricks).map(|k| {
                brick[axis] = k;
                grid.slot(brick)
            }));
        }
        let (across, value_step) = (end[1] - low[1], VALUE_STEPS[axis] as u32);
        Self { facing, low, across, first, bricks: bricks as u32, slots, value_step }
    }

    /// The lines of a row of a window, at lattice indices (i, j).
    pub(crate) fn row(&self, i: i32, columns: Range<i32>) -> impl Iterator<Item = Line> + use<> {
        let (a, b) = self.facing.across();
        let (first, value, step) = (self.place_of([i >> 3, 0]), (i & 7) * VALUE_STEPS[a], VALUE_STEPS[b]);
        let bricks = self.bricks as i32;
        columns.map(move |j| Line {
            brick: first.wrapping_add_signed((j >> 3) * bricks),
            value: (value + (j & 7) * step) as u32,
        })
    }

    /// Records the slot that a new brick of the window was given.
    pub(crate) fn opened(&mut self, brick: IVec3, slot: u32) {
        let (a, b) = self.facing.across();
        let place = self.place_of([brick[a], brick[b]]) + (brick[self.facing.axis()] - self.first) as u32;
        self.slots[place as usize] = slot;
    }

    /// Index of the first slot of a line's bricks.
    fn place_of(&self, [i, j]: [i32; 2]) -> u32 {
        (((i - self.low[0]) * self.across + j - self.low[1]) as u32).wrapping_mul(self.bricks)
    }

    /// Slot of the brick at voxel `k` of a line, and the voxel's index among its values.
    #[inline]
    fn slot(&self, line: Line, k: i32) -> (u32, usize) {
        let along = self.facing.up() * k;
        let brick = ((along >> 3) - self.first) as u32;
        if brick >= self.bricks {
            return (OUTSIDE, 0);
        }
        let value = line.value + (along & 7) as u32 * self.value_step;
        (self.slots[(line.brick + brick) as usize], value as usize)
    }

    /// Index in the pool of voxel `k` of a line, or `None` where there is no brick.
    #[inline]
    pub(crate) fn place(&self, line: Line, k: i32) -> Option<usize> {
        match self.slot(line, k) {
            (OUTSIDE | INSIDE, _) => None,
            (slot, value) => Some(slot as usize * BRICK_VOXELS + value),
        }
    }

    /// φ [m] at voxel `k` of a line.
    #[inline]
    pub(crate) fn phi(&self, grid: &BrickGrid, line: Line, k: i32) -> f32 {
        match self.slot(line, k) {
            (OUTSIDE, _) => grid.band,
            (INSIDE, _) => -grid.band,
            (slot, value) => grid.phi[slot as usize * BRICK_VOXELS + value],
        }
    }

    /// Voxel below the height at which a line leaves the material, the first found from voxel `from`: upwards if it
    /// starts inside, otherwise downwards to voxel `least`.
    pub(crate) fn below_surface(&self, grid: &BrickGrid, line: Line, from: i32, least: i32) -> Option<i32> {
        let voxel = grid.voxel as f32;
        let stride = |phi: f32| ((phi.abs() / voxel) as i32).max(1);
        let (mut k, top) = (from, from.saturating_add(CLIMB));
        let mut phi = self.phi(grid, line, k);
        while phi < 0.0 {
            k += stride(phi);
            if k > top {
                return None;
            }
            phi = self.phi(grid, line, k);
        }
        // |φ| is a distance, so no crossing lies within |φ| of k.
        loop {
            if k < least {
                return None;
            }
            let below = k - stride(phi);
            let next = self.phi(grid, line, below);
            if next < 0.0 {
                return Some(self.crossing(grid, line, below, k));
            }
            (k, phi) = (below, next);
        }
    }

    /// Last voxel inside the material between one inside and one above it.
    fn crossing(&self, grid: &BrickGrid, line: Line, mut below: i32, above: i32) -> i32 {
        while below + 1 < above && self.phi(grid, line, below + 1) < 0.0 {
            below += 1;
        }
        below
    }

    /// φ [m] at the voxels about a crossing: the two from `below` on, one before them and one after.
    pub(crate) fn around(&self, grid: &BrickGrid, line: Line, below: i32) -> [f64; 4] {
        let mut values = [0.0; 4];
        self.read(grid, line, below - 1, &mut values);
        values.map(f64::from)
    }

    /// Writes φ [m] at consecutive voxels of a line from `first` on, brick by brick.
    pub(crate) fn read(&self, grid: &BrickGrid, line: Line, first: i32, mut out: &mut [f32]) {
        let (mut k, up) = (first, self.facing.up());
        while !out.is_empty() {
            let local = (up * k) & 7;
            let left = if up > 0 { 8 - local } else { local + 1 };
            let (part, rest) = out.split_at_mut(out.len().min(left as usize));
            match self.slot(line, k) {
                (OUTSIDE, _) => part.fill(grid.band),
                (INSIDE, _) => part.fill(-grid.band),
                (slot, value) => {
                    let (at, step) = (slot as usize * BRICK_VOXELS + value, up as isize * self.value_step as isize);
                    for (i, out) in part.iter_mut().enumerate() {
                        *out = grid.phi[at.wrapping_add_signed(i as isize * step)];
                    }
                }
            }
            k += part.len() as i32;
            out = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn lines_find_what_the_field_has_from_every_side() {
        let half = DVec3::new(0.008, 0.006, 0.004);
        let grid = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.length() - 0.005);
        for approach in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
            let facing = Facing::of(approach);
            let window = Window { low: [-40; 2], size: [79; 2] };
            let lattice = Lattice::new(&grid, facing, &window);
            for (i, j) in (-40..40).step_by(3).flat_map(|i| (-40..40).step_by(3).map(move |j| (i, j))) {
                let line = lattice.row(i, j..j + 1).next().expect("a line");
                for k in -40..40 {
                    let voxel = facing.voxel(i, j, k);
                    assert_eq!(lattice.phi(&grid, line, k), grid.phi_at(voxel), "{voxel}");
                    assert_eq!(lattice.place(line, k), grid.place(voxel), "{voxel}");
                }
                let mut values = [0.0; 80];
                lattice.read(&grid, line, -40, &mut values);
                assert_eq!(values, std::array::from_fn(|k| lattice.phi(&grid, line, k as i32 - 40)));
            }
        }
    }
}
