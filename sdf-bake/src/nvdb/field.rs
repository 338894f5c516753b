//! The written part of a brick grid: its distances, its labels, or another channel.

use bytemuck::Pod;

use crate::grid::{BRICK_VOXELS, BrickGrid};

/// A NanoVDB value type of four bytes with statistics in f32.
pub(super) trait Value: Pod + PartialOrd + Send + Sync {
    /// NanoVDB's number of the type.
    const GRID_TYPE: u32;

    fn bits(self) -> u32;
    fn to_f64(self) -> f64;
}

impl Value for f32 {
    const GRID_TYPE: u32 = 1;

    fn bits(self) -> u32 {
        self.to_bits()
    }

    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Value for i32 {
    const GRID_TYPE: u32 = 4;

    fn bits(self) -> u32 {
        self as u32
    }

    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

/// NanoVDB's number of the class of level sets.
pub(super) const CLASS_LEVEL_SET: u32 = 1;
/// NanoVDB's number of the class of fog volumes.
pub(super) const CLASS_FOG: u32 = 2;
/// NanoVDB's number of an unspecified class.
pub(super) const CLASS_UNKNOWN: u32 = 0;

/// A channel of a brick grid, as the writer uses it.
pub(super) trait Field: Sync {
    type Value: Value;

    const CLASS: u32;

    fn grid(&self) -> &BrickGrid;
    fn background(&self) -> Self::Value;
    /// Value of bricks beyond the band inside, if it differs from the background.
    fn inside(&self) -> Option<Self::Value>;
    /// Value at an index in the pool.
    fn value(&self, at: usize) -> Self::Value;
    fn is_active(&self, value: Self::Value) -> bool;
    /// Limit for skipping: a renderer may skip nodes whose values all lie farther from 0 on one side.
    fn skip_beyond(&self) -> Option<f64>;

    /// True if a brick needs a leaf.
    fn keeps(&self, slot: usize) -> bool {
        (slot * BRICK_VOXELS..(slot + 1) * BRICK_VOXELS).any(|at| self.is_active(self.value(at)))
    }
}

/// φ [m]: every brick is a leaf, active where |φ| < band.
pub(super) struct LevelSet<'a>(pub(super) &'a BrickGrid);

impl Field for LevelSet<'_> {
    type Value = f32;

    const CLASS: u32 = CLASS_LEVEL_SET;

    fn grid(&self) -> &BrickGrid {
        self.0
    }

    fn background(&self) -> f32 {
        self.0.band
    }

    fn inside(&self) -> Option<f32> {
        Some(-self.0.band)
    }

    fn value(&self, at: usize) -> f32 {
        self.0.phi[at]
    }

    fn is_active(&self, value: f32) -> bool {
        value.abs() < self.0.band
    }

    fn skip_beyond(&self) -> Option<f64> {
        Some(self.0.voxel)
    }

    fn keeps(&self, _: usize) -> bool {
        true
    }
}

/// Weld ids: a leaf for every brick that has any, active where the id is not 0.
pub(super) struct Labels<'a>(pub(super) &'a BrickGrid);

impl Field for Labels<'_> {
    type Value = i32;

    const CLASS: u32 = CLASS_UNKNOWN;

    fn grid(&self) -> &BrickGrid {
        self.0
    }

    fn background(&self) -> i32 {
        0
    }

    fn inside(&self) -> Option<i32> {
        None
    }

    fn value(&self, at: usize) -> i32 {
        i32::from(self.0.label[at])
    }

    fn is_active(&self, value: i32) -> bool {
        value != 0
    }

    fn skip_beyond(&self) -> Option<f64> {
        None
    }
}

/// A density: a leaf for every brick that has any, active where it is not 0.
pub(super) struct Density<'a> {
    pub(super) grid: &'a BrickGrid,
    pub(super) values: &'a [f32],
}

impl Field for Density<'_> {
    type Value = f32;

    const CLASS: u32 = CLASS_FOG;

    fn grid(&self) -> &BrickGrid {
        self.grid
    }

    fn background(&self) -> f32 {
        0.0
    }

    fn inside(&self) -> Option<f32> {
        None
    }

    fn value(&self, at: usize) -> f32 {
        self.values[at]
    }

    fn is_active(&self, value: f32) -> bool {
        value != 0.0
    }

    fn skip_beyond(&self) -> Option<f64> {
        None
    }
}
