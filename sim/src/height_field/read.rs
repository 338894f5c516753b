//! Reading of a height field from the distance field, or, where the surface has not changed, from the previous height
//! field.

use std::cell::OnceCell;

use sdf_bake::BrickGrid;

use super::{Facing, HeightField, NO_SURFACE, Window};
use crate::crossing::Crossings;
use crate::lattice_line::Lattice;

impl HeightField {
    /// Reads the surface in a window. On each column the search starts near `level` [m up], goes up if it starts inside
    /// the material, and otherwise down to `floor` [m up].
    pub fn read(grid: &BrickGrid, facing: Facing, window: Window, level: f64, floor: f64) -> Self {
        Self::read_beside(None, grid, facing, window, (level, floor))
    }

    /// Reads a window of a surface that has not changed since the height field `before`: columns in both are copied
    /// from it.
    pub(crate) fn read_beside(
        before: Option<&Self>,
        grid: &BrickGrid,
        facing: Facing,
        window: Window,
        (level, floor): (f64, f64),
    ) -> Self {
        let lines = window.lines();
        let lattice = Lattice::new(grid, facing, &window);
        let (mut on, mut place) = (Vec::with_capacity(lines), Vec::with_capacity(lines));
        for (i, columns) in window.rows() {
            let u = f64::from(i) * grid.voxel;
            on.extend(lattice.row(i, columns.clone()));
            place.extend(columns.map(|j| [u, f64::from(j) * grid.voxel]));
        }
        let mut height_field = Self {
            facing,
            pitch: grid.voxel,
            window,
            lattice,
            on,
            place,
            read_height: Vec::new(),
            height: vec![NO_SURFACE; lines],
            levels: (f64::INFINITY, f64::NEG_INFINITY),
            slope: vec![[0.0; 2]; lines],
            area_ratio: vec![1.0; lines],
            dose: vec![0.0; lines],
            removed: vec![0.0; lines],
            label: vec![0; lines],
            edges: OnceCell::new(),
        };
        before.into_iter().for_each(|before| height_field.take_from(before));
        let known = height_field.height.clone();
        height_field.read_heights(grid, level, floor);
        for height in height_field.height.iter().filter(|height| **height > NO_SURFACE) {
            height_field.levels = (height_field.levels.0.min(*height), height_field.levels.1.max(*height));
        }
        height_field.read_height = height_field.height.clone();
        height_field.set_slopes();
        height_field.read_channels(grid, &known);
        height_field
    }

    /// Copies the columns that are also in another height field, with the values that reading them from the field would
    /// give.
    fn take_from(&mut self, before: &Self) {
        let (own, other) = (self.window, before.window);
        let common = [0, 1].map(|d| {
            let end = |window: &Window| window.low[d] + window.size[d] as i32;
            let first = own.low[d].max(other.low[d]);
            first..end(&own).min(end(&other)).max(first)
        });
        for row in common[0].clone() {
            let lines = |window: &Window| {
                let first = (row - window.low[0]) as usize * window.size[1];
                let at = |column: i32| first + (column - window.low[1]) as usize;
                at(common[1].start)..at(common[1].end)
            };
            let (to, from) = (lines(&own), lines(&other));
            self.height[to.clone()].copy_from_slice(&before.height[from.clone()]);
            self.removed[to.clone()].copy_from_slice(&before.removed[from.clone()]);
            self.label[to.clone()].copy_from_slice(&before.label[from.clone()]);
            // The distance field stores it in single precision.
            let doses = self.dose[to].iter_mut().zip(&before.dose[from]);
            doses.for_each(|(to, dose)| *to = f64::from(*dose as f32));
        }
    }

    /// Reads the heights that are not known yet.
    fn read_heights(&mut self, grid: &BrickGrid, level: f64, floor: f64) {
        let above = |height: f64| (height / grid.voxel).ceil() as i32;
        let (start, least) = (above(level), (floor / grid.voxel).floor() as i32);
        let across = self.window.size[1];
        let (mut crossings, mut met) = (Crossings::default(), Vec::new());
        for first in (0..self.window.lines()).step_by(across) {
            let before = first.checked_sub(across).map_or(NO_SURFACE, |before| self.height[before]);
            let mut guess = if before > NO_SURFACE { above(before) } else { start };
            crossings.clear();
            met.clear();
            for line in first..first + across {
                if self.height[line] > NO_SURFACE {
                    guess = above(self.height[line]);
                    continue;
                }
                let below = self.lattice.below_surface(grid, self.on[line], guess, least);
                guess = below.map_or(start, |below| below + 1);
                if let Some(below) = below {
                    crossings.push(self.lattice.around(grid, self.on[line], below));
                    met.push((line, below));
                }
            }
            for ((line, below), way) in met.iter().zip(crossings.ways(grid.band.into())) {
                self.height[*line] = (f64::from(*below) + way) * grid.voxel;
            }
        }
    }

    /// Reads dose, removed depth and label of the columns that were not `known` yet, from the voxel nearest to the
    /// surface.
    fn read_channels(&mut self, grid: &BrickGrid, known: &[f64]) {
        if grid.dose.is_empty() && grid.removed.is_empty() && grid.label.is_empty() {
            return;
        }
        let value = |channel: &[f32], at: usize| channel.get(at).copied().map_or(0.0, f64::from);
        for (line, known) in known.iter().enumerate() {
            if self.height[line] == *known {
                continue;
            }
            let nearest = (self.height[line] / self.pitch).round() as i32;
            if let Some(at) = self.lattice.place(self.on[line], nearest) {
                self.dose[line] = value(&grid.dose, at);
                self.removed[line] = value(&grid.removed, at);
                self.label[line] = grid.label.get(at).copied().unwrap_or(0);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::channels::Scalar;

    use super::*;
    use crate::write_back::write_back;

    #[test]
    fn lines_of_the_height_field_before_are_those_of_the_field() {
        let half = DVec3::new(0.01, 0.01, 0.004);
        let mut grid = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.z.max(0.003 - p.truncate().length()));
        grid.scalar_or_zero(Scalar::Dose);
        let facing = Facing::of(DVec3::Z);
        let read = |grid: &BrickGrid, before, low| {
            HeightField::read_beside(before, grid, facing, Window { low, size: [16, 18] }, (0.005, -0.005))
        };
        let mut before = read(&grid, None, [-12, -10]);
        let met: Vec<usize> = (0..before.window.lines()).filter(|&line| before.height[line] > NO_SURFACE).collect();
        met.iter().for_each(|&line| before.dose[line] = 1e-3 * (line as f64 + 0.1));
        assert!((100..before.window.lines()).contains(&met.len()));
        write_back(&mut grid, &mut before);
        for low in [[-12, -10], [-9, -14], [-2, 1], [20, 30]] {
            let (beside, alone) = (read(&grid, Some(&before), low), read(&grid, None, low));
            assert_eq!((&beside.height, &beside.slope, beside.levels), (&alone.height, &alone.slope, alone.levels));
            assert_eq!((&beside.dose, &beside.removed, &beside.label), (&alone.dose, &alone.removed, &alone.label));
        }
    }
}
