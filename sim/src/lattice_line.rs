//! The signed distance along lattice lines, and where they leave the material.

use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_VOXELS, INSIDE, OUTSIDE};

use crate::crossing::way_to_zero;
use crate::sheet::Facing;

/// Voxels by which a column is followed upwards out of the material.
const CLIMB: i32 = 400;
/// Entry of a line that passes beside the field.
const BESIDE: u32 = u32::MAX;
/// Steps between neighbours along x, y and z among a brick's values.
const VALUE_STEPS: [i32; 3] = [64, 8, 1];

/// The lattice lines of a field along one axis. It stays right while bricks are opened: the index keeps its shape.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lattice {
    facing: Facing,
    /// First brick along the lines, and how many there are.
    first: i32,
    bricks: u32,
    /// Step from brick to brick along the lines in the field's index, and from voxel to voxel among a brick's values.
    entry_step: u32,
    value_step: u32,
}

/// One line: where its voxels lie in the field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Entry of its first brick in the field's index, or [`BESIDE`].
    entry: u32,
    /// Place of its first voxel among a brick's values.
    value: u32,
}

impl Lattice {
    pub(crate) fn new(grid: &BrickGrid, facing: Facing) -> Self {
        let axis = facing.axis();
        Self {
            facing,
            first: grid.origin[axis],
            bricks: grid.dims[axis] as u32,
            entry_step: entry_steps(grid)[axis] as u32,
            value_step: VALUE_STEPS[axis] as u32,
        }
    }

    /// The line at lattice place (i, j).
    pub(crate) fn line(&self, grid: &BrickGrid, (i, j): (i32, i32)) -> Line {
        let (a, b) = self.facing.across();
        let bricks = [(a, (i >> 3) - grid.origin[a]), (b, (j >> 3) - grid.origin[b])];
        let value = ((i & 7) * VALUE_STEPS[a] + (j & 7) * VALUE_STEPS[b]) as u32;
        let is_beside = bricks.iter().any(|&(axis, brick)| brick < 0 || brick >= grid.dims[axis]);
        let steps = entry_steps(grid);
        let entry = || bricks.iter().map(|&(axis, brick)| brick * steps[axis]).sum::<i32>() as u32;
        Line { entry: if is_beside { BESIDE } else { entry() }, value }
    }

    /// Slot of the brick at `k` voxels up a line, and the voxel's place among its values.
    #[inline]
    fn slot(&self, grid: &BrickGrid, line: Line, k: i32) -> (u32, usize) {
        let along = self.facing.up() * k;
        let brick = ((along >> 3) - self.first) as u32;
        if line.entry == BESIDE || brick >= self.bricks {
            return (OUTSIDE, 0);
        }
        let value = line.value + (along & 7) as u32 * self.value_step;
        (grid.index[(line.entry + brick * self.entry_step) as usize], value as usize)
    }

    /// Position in the pool of the voxel at `k` up a line, or `None` where no brick is.
    #[inline]
    pub(crate) fn place(&self, grid: &BrickGrid, line: Line, k: i32) -> Option<usize> {
        match self.slot(grid, line, k) {
            (OUTSIDE | INSIDE, _) => None,
            (slot, value) => Some(slot as usize * BRICK_VOXELS + value),
        }
    }

    /// φ [m] at `k` voxels up a line.
    #[inline]
    pub(crate) fn phi(&self, grid: &BrickGrid, line: Line, k: i32) -> f32 {
        match self.slot(grid, line, k) {
            (OUTSIDE, _) => grid.band,
            (INSIDE, _) => -grid.band,
            (slot, value) => grid.phi[slot as usize * BRICK_VOXELS + value],
        }
    }

    /// Height [voxels] at which a line leaves the material, met first from voxel `from`: upwards out of it, or downwards
    /// to voxel `least`.
    pub(crate) fn surface(&self, grid: &BrickGrid, line: Line, from: i32, least: i32) -> Option<f64> {
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
        // φ is a distance, so no crossing lies within φ of k.
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

    /// Root of φ between a voxel in the material and one above it [voxels].
    fn crossing(&self, grid: &BrickGrid, line: Line, mut below: i32, above: i32) -> f64 {
        while below + 1 < above && self.phi(grid, line, below + 1) < 0.0 {
            below += 1;
        }
        let values = [-1, 0, 1, 2].map(|step| f64::from(self.phi(grid, line, below + step)));
        f64::from(below) + way_to_zero(values, grid.band.into())
    }
}

/// Steps between neighbours along x, y and z in a field's index.
fn entry_steps(grid: &BrickGrid) -> [i32; 3] {
    [grid.dims.y * grid.dims.z, grid.dims.z, 1]
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
            let lattice = Lattice::new(&grid, facing);
            for (i, j) in (-40..40).step_by(3).flat_map(|i| (-40..40).step_by(3).map(move |j| (i, j))) {
                let line = lattice.line(&grid, (i, j));
                for k in -40..40 {
                    let voxel = facing.voxel(i, j, k);
                    assert_eq!(lattice.phi(&grid, line, k), grid.phi_at(voxel), "{voxel}");
                    assert_eq!(lattice.place(&grid, line, k), grid.place(voxel), "{voxel}");
                }
            }
        }
    }
}
