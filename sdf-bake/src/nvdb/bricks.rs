//! Converts a grid that was read to bricks.

use glam::{DVec3, I64Vec3, IVec3};

use super::error::BricksError;
use super::tree::{GridClass, NvdbGrid, Tile, Tree, Values};
use crate::channels::Scalar;
use crate::grid::{BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE, voxel_at};

/// Index entries allowed per leaf and tile of a tree, plus some for a small one. The 2 KiB of a leaf allow 256 bytes of
/// the index's root.
const ENTRIES_PER_NODE: u128 = 1 << 15;
const ENTRIES_AT_LEAST: u128 = 1 << 22;

/// Least share of the band at which a value counts as beyond it; other writers round.
const BEYOND: f32 = 1.0 - 1e-6;

impl NvdbGrid {
    /// Converts a level set to bricks. The output of [`super::write()`] is restored bit for bit: voxel, band, every φ,
    /// and the side outside the bricks. Bricks are in index order; the index spans the bricks and the inside.
    ///
    /// # Errors
    /// Not a Float level set, translated from the origin, too sparse, or values that are not truncated distances.
    pub fn to_bricks(&self) -> Result<BrickGrid, BricksError> {
        let tree = match (&self.values, self.class) {
            (Values::Float(tree), GridClass::LevelSet) => tree,
            _ => return Err(self.wrong_kind("a Float level set")),
        };
        if self.translation != DVec3::ZERO {
            return Err(BricksError::Translation { grid: self.name.clone(), translation: self.translation });
        }
        let band = tree.background;
        if !(band.is_finite() && band > 0.0) {
            return Err(self.bad_value(IVec3::ZERO, format!("background {band}; a band above 0 is needed")));
        }
        let inside = self.inside_tiles(tree)?;
        let mut grid = self.empty_over(tree, &inside)?;
        for tile in &inside {
            let low = tile.voxel >> 3;
            grid.index.fill(low - grid.origin, low + (1 << (tile.side_log2 - 3)) - grid.origin, INSIDE);
        }
        let mut order: Vec<usize> = (0..tree.leaves.len()).collect();
        order.sort_by_key(|&leaf| tree.leaves[leaf].to_array());
        grid.phi.reserve_exact(tree.values.len());
        for leaf in order {
            self.push_leaf(tree, leaf, &mut grid)?;
        }
        grid.index.tidy();
        Ok(grid)
    }

    /// Sets a grid's `label` from this Int32 grid; inactive voxels are 0.
    ///
    /// # Errors
    /// Not an Int32 grid, a different voxel size or origin, an id beyond 65535, or an id outside the grid's bricks.
    pub fn attach_labels(&self, grid: &mut BrickGrid) -> Result<(), BricksError> {
        let Values::Int32(tree) = &self.values else {
            return Err(self.wrong_kind("an Int32 grid"));
        };
        let labels = self.gather(tree, grid)?;
        let wrong = labels.iter().position(|&label| u16::try_from(label).is_err());
        if let Some(at) = wrong {
            let voxel = voxel_at(grid.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS);
            return Err(self.bad_value(voxel, format!("weld id {}; 0 to 65535 fit", labels[at])));
        }
        grid.label = labels.into_iter().map(|label| label as u16).collect();
        Ok(())
    }

    /// Sets a channel of a grid from this Float grid; 0 where this grid has no leaf.
    ///
    /// # Errors
    /// Those of [`NvdbGrid::channel`], and a value that is not finite.
    pub fn attach_scalar(&self, channel: Scalar, grid: &mut BrickGrid) -> Result<(), BricksError> {
        let values = self.channel(grid)?;
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let what = format!("{} {}; a finite number is needed", channel.name(), values[at]);
            return Err(self.bad_value(grid.voxel_of(at), what));
        }
        *grid.scalar_mut(channel) = values;
        Ok(())
    }

    /// Returns a Float channel in the order of `grid.phi`, shape `[bricks, 512]`; 0 where this grid has no leaf.
    ///
    /// # Errors
    /// Not a Float grid, a different voxel size or origin, or a value outside the grid's bricks.
    pub fn channel(&self, grid: &BrickGrid) -> Result<Vec<f32>, BricksError> {
        match &self.values {
            Values::Float(tree) => self.gather(tree, grid),
            Values::Int32(_) => Err(self.wrong_kind("a Float grid")),
        }
    }

    fn gather<V: Copy + Default + PartialEq>(&self, tree: &Tree<V>, grid: &BrickGrid) -> Result<Vec<V>, BricksError> {
        if self.translation != DVec3::ZERO {
            return Err(BricksError::Translation { grid: self.name.clone(), translation: self.translation });
        }
        if self.voxel != grid.voxel {
            let what = format!("voxels of {} m; the bricks have {} m", self.voxel, grid.voxel);
            return Err(self.bad_value(IVec3::ZERO, what));
        }
        if let Some(tile) = tree.tiles.iter().find(|tile| tile.active) {
            return Err(self.bad_value(tile.voxel, "an active tile; values in leaves are needed".to_owned()));
        }
        let mut values = vec![V::default(); grid.bricks.len() * BRICK_VOXELS];
        for (leaf, &brick) in tree.leaves.iter().enumerate() {
            let from = &tree.values[leaf * BRICK_VOXELS..(leaf + 1) * BRICK_VOXELS];
            match grid.slot(brick) {
                OUTSIDE | INSIDE => {
                    if let Some(offset) = from.iter().position(|value| *value != V::default()) {
                        return Err(self.bad_value(voxel_at(brick, offset), "a value outside all bricks".to_owned()));
                    }
                }
                slot => values[slot as usize * BRICK_VOXELS..][..BRICK_VOXELS].copy_from_slice(from),
            }
        }
        Ok(values)
    }

    /// Returns the inside tiles; any other tile of a level set must be outside.
    fn inside_tiles<'a>(&self, tree: &'a Tree<f32>) -> Result<Vec<&'a Tile<f32>>, BricksError> {
        let band = tree.background;
        let mut inside = Vec::new();
        for tile in &tree.tiles {
            let beyond = tile.value.abs() >= band * BEYOND;
            if tile.active || !beyond {
                return Err(self.bad_value(tile.voxel, format!("a tile of {}; the band is {band}", tile.value)));
            }
            if tile.value < 0.0 {
                inside.push(tile);
            }
        }
        Ok(inside)
    }

    /// Makes an empty grid whose index spans all leaves and the given tiles.
    fn empty_over(&self, tree: &Tree<f32>, inside: &[&Tile<f32>]) -> Result<BrickGrid, BricksError> {
        let leaves = tree.leaves.iter().map(|leaf| (leaf.as_i64vec3(), leaf.as_i64vec3() + 1));
        let tiles = inside.iter().map(|tile| {
            let low = tile.voxel.as_i64vec3() >> 3;
            (low, low + (1 << (tile.side_log2 - 3)))
        });
        let grow = |a: (I64Vec3, I64Vec3), b: (I64Vec3, I64Vec3)| (a.0.min(b.0), a.1.max(b.1));
        let (low, high) = leaves.chain(tiles).reduce(grow).unwrap_or_default();
        let dims = high - low;
        let entries = [dims.x, dims.y, dims.z].iter().map(|&d| d as u128).product();
        let limit = ENTRIES_AT_LEAST.max(ENTRIES_PER_NODE * (tree.leaves.len() + tree.tiles.len()) as u128);
        if entries > limit {
            return Err(BricksError::Sparse { grid: self.name.clone(), leaves: tree.leaves.len(), entries, limit });
        }
        Ok(BrickGrid::empty(self.voxel, tree.background, low.as_ivec3(), dims.as_ivec3()))
    }

    fn push_leaf(&self, tree: &Tree<f32>, leaf: usize, grid: &mut BrickGrid) -> Result<(), BricksError> {
        let brick = tree.leaves[leaf];
        let values = &tree.values[leaf * BRICK_VOXELS..(leaf + 1) * BRICK_VOXELS];
        if let Some(offset) = values.iter().position(|phi| phi.is_nan()) {
            return Err(self.bad_value(voxel_at(brick, offset), "NaN; a distance is needed".to_owned()));
        }
        grid.set_slot(brick, grid.bricks.len() as u32);
        grid.bricks.push(brick);
        grid.phi.extend(values.iter().map(|phi| phi.clamp(-grid.band, grid.band)));
        Ok(())
    }

    fn wrong_kind(&self, expected: &'static str) -> BricksError {
        let kind = match &self.values {
            Values::Float(_) => "Float",
            Values::Int32(_) => "Int32",
        };
        BricksError::Kind { grid: self.name.clone(), found: format!("{kind} grid of class {:?}", self.class), expected }
    }

    fn bad_value(&self, voxel: IVec3, what: String) -> BricksError {
        BricksError::Value { grid: self.name.clone(), voxel, what }
    }
}
