//! Values of a voxel besides φ: optional channels in the order of the pool.
//!
//! A channel is empty if a part does not have it; otherwise it has one value per value of φ. To add an `f32` channel,
//! add a field of [`BrickGrid`], a variant of [`Scalar`] and its match arms below; all functions that add, move,
//! release, unite or store bricks then include it.

use std::ops::Range;

use glam::DVec3;

use crate::grid::{BRICK_VOXELS, BrickGrid, cell_corner, trilinear};

/// An optional `f32` channel of a [`BrickGrid`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scalar {
    /// Coating dose D; 1 where the coating is removed.
    Dose,
    /// Removed depth [m].
    Removed,
}

impl Scalar {
    /// All channels, in the order in which they are stored.
    pub const ALL: [Self; 2] = [Self::Dose, Self::Removed];

    /// Name in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Dose => "dose",
            Self::Removed => "removed",
        }
    }
}

impl BrickGrid {
    /// Values of a channel, shape `[bricks, 512]`; empty if the part does not have it.
    pub fn scalar(&self, channel: Scalar) -> &[f32] {
        match channel {
            Scalar::Dose => &self.dose,
            Scalar::Removed => &self.removed,
        }
    }

    /// Mutable form of [`BrickGrid::scalar`].
    pub fn scalar_mut(&mut self, channel: Scalar) -> &mut Vec<f32> {
        match channel {
            Scalar::Dose => &mut self.dose,
            Scalar::Removed => &mut self.removed,
        }
    }

    /// Values of a channel; filled with zeros first if the part did not have it.
    pub fn scalar_or_zero(&mut self, channel: Scalar) -> &mut [f32] {
        let values = self.phi.len();
        let scalar = self.scalar_mut(channel);
        if scalar.is_empty() {
            scalar.resize(values, 0.0);
        }
        scalar
    }

    /// Value of a channel at a point [m], trilinear between the eight voxels around it; 0 outside the bricks.
    pub fn sample_scalar(&self, channel: Scalar, point: DVec3) -> f32 {
        let values = self.scalar(channel);
        let (corner, fraction) = self.cell(point);
        let at = |i| self.place(corner + cell_corner(i)).and_then(|at| values.get(at)).copied().unwrap_or(0.0);
        trilinear(&std::array::from_fn(at), fraction)
    }

    /// Coating dose D at a point [m], trilinear; 0 outside the bricks.
    pub fn sample_dose(&self, point: DVec3) -> f32 {
        self.sample_scalar(Scalar::Dose, point)
    }

    /// Extends all channels except φ by the value 0 for new bricks at the end of the pool.
    pub(crate) fn extend_channels(&mut self) {
        let values = self.phi.len();
        extend(&mut self.label, values);
        for channel in Scalar::ALL {
            extend(self.scalar_mut(channel), values);
        }
    }

    /// Moves the values of one brick to the position of another in all channels, φ included.
    pub(crate) fn move_brick(&mut self, from: usize, to: usize) {
        let values = from * BRICK_VOXELS..(from + 1) * BRICK_VOXELS;
        self.bricks[to] = self.bricks[from];
        shift(&mut self.phi, values.clone(), to);
        shift(&mut self.label, values.clone(), to);
        for channel in Scalar::ALL {
            shift(self.scalar_mut(channel), values.clone(), to);
        }
    }

    /// Truncates the pool to its first `bricks` bricks, in all channels.
    pub(crate) fn truncate_pool(&mut self, bricks: usize) {
        let values = bricks * BRICK_VOXELS;
        self.bricks.truncate(bricks);
        self.phi.truncate(values);
        self.label.truncate(values);
        for channel in Scalar::ALL {
            self.scalar_mut(channel).truncate(values);
        }
    }

    /// Checks that every channel is absent or as long as φ, and that all its values are finite.
    pub(crate) fn check_channels(&self) -> Result<(), String> {
        let expected = self.phi.len();
        let fits = |name: &str, length: usize| match length {
            0 => Ok(()),
            length if length == expected => Ok(()),
            length => Err(format!("{length} values of {name} for {expected} of φ")),
        };
        fits("label", self.label.len())?;
        for channel in Scalar::ALL {
            let values = self.scalar(channel);
            fits(channel.name(), values.len())?;
            if let Some(at) = values.iter().position(|value| !value.is_finite()) {
                return Err(format!("{} is {} at voxel {}", channel.name(), values[at], self.voxel_of(at)));
            }
        }
        Ok(())
    }
}

fn extend<T: Copy + Default>(channel: &mut Vec<T>, values: usize) {
    if !channel.is_empty() {
        channel.resize(values, T::default());
    }
}

fn shift<T: Copy>(channel: &mut [T], values: Range<usize>, to: usize) {
    if !channel.is_empty() {
        channel.copy_within(values, to * BRICK_VOXELS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball() -> BrickGrid {
        let half = DVec3::splat(0.01);
        BrickGrid::from_distance(-half, half, 0.0005, 3.0, |p| p.length() - 0.01)
    }

    #[test]
    fn a_linear_channel_is_sampled_exactly_and_absent_ones_are_zero() {
        let mut grid = ball();
        assert_eq!(grid.sample_dose(DVec3::X * 0.01), 0.0);
        let slope = |p: DVec3| 0.5 + 20.0 * p.x - 7.0 * p.y + 3.0 * p.z;
        let values = (0..grid.phi.len()).map(|at| slope(grid.position(grid.voxel_of(at))) as f32).collect();
        *grid.scalar_mut(Scalar::Dose) = values;
        for i in 0..100 {
            let turn = f64::from(i) * 2.4;
            let point = DVec3::new(turn.cos(), turn.sin(), 0.1).normalize() * 0.0101;
            assert!((f64::from(grid.sample_dose(point)) - slope(point)).abs() < 1e-6, "at {point}");
        }
        assert_eq!(grid.sample_scalar(Scalar::Removed, DVec3::X * 0.01), 0.0);
    }

    #[test]
    fn channels_follow_their_bricks_when_bricks_are_added_and_freed() {
        let mut grid = ball();
        let mark = |grid: &BrickGrid, at: usize| grid.voxel_of(at).dot(glam::IVec3::new(1, 100, 10_000)) as f32;
        grid.label = (0..grid.phi.len()).map(|at| mark(&grid, at).abs() as u16 % 7).collect();
        grid.dose = (0..grid.phi.len()).map(|at| mark(&grid, at)).collect();
        grid.scalar_or_zero(Scalar::Removed).fill(1.0);
        let bytes = grid.bytes();
        // The first brick leaves the band, so all others move up; a shrinking ball needs new bricks.
        grid.phi[..BRICK_VOXELS].fill(grid.band);
        assert_eq!(grid.release_uniform_bricks(), 1);
        assert_eq!(bytes - grid.bytes(), BRICK_VOXELS * (4 + 2 + 4 + 4) + 12);
        assert!((0..grid.phi.len()).all(|at| grid.dose[at] == mark(&grid, at)));
        assert!((0..grid.phi.len()).all(|at| grid.label[at] == mark(&grid, at).abs() as u16 % 7));
        for phi in &mut grid.phi {
            *phi = (*phi + 0.001).min(grid.band);
        }
        let old = grid.phi.len();
        for brick in grid.bricks.clone() {
            grid.open_inside_brick(brick - brick.signum());
        }
        assert!(grid.phi.len() > old);
        assert_eq!(grid.sanity_check(), Ok(()));
        assert!(grid.dose[old..].iter().chain(&grid.removed[old..]).all(|&value| value == 0.0));
    }

    #[test]
    fn the_sanity_check_names_a_channel_that_does_not_fit() {
        let mut grid = ball();
        grid.dose = vec![0.0; 7];
        assert!(grid.sanity_check().unwrap_err().contains("7 values of dose"));
        grid.dose = vec![0.0; grid.phi.len()];
        grid.dose[3] = f32::NAN;
        assert!(grid.sanity_check().unwrap_err().contains("dose is NaN at voxel"));
    }
}
