//! Look-up and interpolation in a brick grid in plain Rust: CPU twin of `brick_grid.wgsl`, with the same names and
//! order of operations, and so the reference for the kernels.

use crate::constants::{BRICK_SHIFT, BRICK_SIDE, BRICK_VOXELS, FARTHEST_VOXEL, INSIDE, OUTSIDE};
use crate::layout::GridHeader;

/// A brick grid as it is bound on the device: a header and two arrays.
#[derive(Clone, Copy, Debug)]
pub struct GridBuffers<'a> {
    /// Origin, size and resolution.
    pub header: GridHeader,
    /// Slot of each brick, [`OUTSIDE`] or [`INSIDE`], shape `[dims.x, dims.y, dims.z]`.
    pub index: &'a [u32],
    /// φ [m], shape `[bricks, 512]`, z fastest within a brick.
    pub phi: &'a [f32],
}

/// Mismatch between arrays and header of a grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridError {
    /// Voxel or band is not a positive finite length.
    #[error("voxel {voxel} m and band {band} m: both must be finite and above zero")]
    Length {
        /// Distance between voxels [m].
        voxel: f32,
        /// Truncation distance [m].
        band: f32,
    },
    /// The index has a different shape from that in the header.
    #[error("the index has {found} entries, {dims:?} bricks need {expected}")]
    Index {
        /// Entries given.
        found: usize,
        /// Entries per axis [bricks].
        dims: [u32; 3],
        /// Entries needed.
        expected: u64,
    },
    /// The pool has a different size from that in the header.
    #[error("the pool has {found} values, {bricks} bricks need {expected}")]
    Pool {
        /// Values given.
        found: usize,
        /// Number of bricks in the header.
        bricks: u32,
        /// Values needed.
        expected: u64,
    },
    /// An entry is neither a slot nor a code.
    #[error("index entry {entry} is slot {slot}, but the pool has {bricks} bricks (slots 0 to {bricks}, exclusive)")]
    Slot {
        /// Position in the index.
        entry: usize,
        /// The slot found.
        slot: u32,
        /// Bricks in the pool.
        bricks: u32,
    },
    /// The grid is so far from the origin that f32 does not resolve its voxels.
    #[error("the grid reaches beyond voxel {limit}: move the part to the origin or use a larger voxel")]
    Far {
        /// Largest voxel coordinate that can be looked up.
        limit: u32,
    },
}

impl GridBuffers<'_> {
    /// Checks that header and arrays match.
    ///
    /// # Errors
    /// The first mismatch found.
    pub fn validate(&self) -> Result<(), GridError> {
        let GridHeader { origin, dims: [nx, ny, nz, _], voxel, band, bricks, .. } = self.header;
        let is_length = |length: f32| length.is_finite() && length > 0.0;
        if !(is_length(voxel) && is_length(band)) {
            return Err(GridError::Length { voxel, band });
        }
        let limit = i64::from(FARTHEST_VOXEL >> BRICK_SHIFT);
        let within = |(&first, n): (&i32, u32)| i64::from(first) >= -limit && i64::from(first) + i64::from(n) <= limit;
        if !origin.iter().zip([nx, ny, nz]).all(within) {
            return Err(GridError::Far { limit: FARTHEST_VOXEL });
        }
        // Each count is below 2^20 here, so the product fits.
        let entries = u64::from(nx) * u64::from(ny) * u64::from(nz);
        if self.index.len() as u64 != entries {
            return Err(GridError::Index { found: self.index.len(), dims: [nx, ny, nz], expected: entries });
        }
        let values = u64::from(bricks) * u64::from(BRICK_VOXELS);
        if self.phi.len() as u64 != values {
            return Err(GridError::Pool { found: self.phi.len(), bricks, expected: values });
        }
        let is_known = |slot: u32| slot < bricks || slot == OUTSIDE || slot == INSIDE;
        match self.index.iter().position(|&slot| !is_known(slot)) {
            Some(entry) => Err(GridError::Slot { entry, slot: self.index[entry], bricks }),
            None => Ok(()),
        }
    }

    /// φ at a point [m], trilinear between the eight voxels around it; ±band beyond the band, NaN if the point is not
    /// finite. The grid must be valid.
    pub fn sample_phi(&self, point: [f32; 3]) -> f32 {
        if !point.iter().all(|x| x.is_finite()) {
            return self.header.invalid;
        }
        let at = point.map(|x| x / self.header.voxel);
        if at.iter().all(|x| x.abs() < FARTHEST_VOXEL as f32) {
            let corner = at.map(f32::floor);
            let fraction = std::array::from_fn(|axis| at[axis] - corner[axis]);
            return trilinear(&self.cell_phi(corner.map(|x| x as i32)), fraction);
        }
        self.header.band
    }

    /// Position of a brick in the index; valid only if `within_index` is true.
    fn entry(&self, brick: [i32; 3]) -> usize {
        let at: [usize; 3] = std::array::from_fn(|axis| (brick[axis] - self.header.origin[axis]) as usize);
        (at[0] * self.header.dims[1] as usize + at[1]) * self.header.dims[2] as usize + at[2]
    }

    /// True if the index covers a brick.
    fn within_index(&self, brick: [i32; 3]) -> bool {
        let at = |axis: usize| brick[axis] - self.header.origin[axis];
        (0..3).all(|axis| at(axis) >= 0 && at(axis) < self.header.dims[axis] as i32)
    }

    /// Slot of a brick, [`OUTSIDE`] or [`INSIDE`].
    fn slot(&self, brick: [i32; 3]) -> u32 {
        if self.within_index(brick) {
            return self.index[self.entry(brick)];
        }
        OUTSIDE
    }

    /// φ at a voxel [m].
    fn phi_at(&self, voxel: [i32; 3]) -> f32 {
        let place = self.slot(voxel.map(|x| x >> BRICK_SHIFT));
        if place < self.header.bricks {
            return self.phi[place as usize * BRICK_VOXELS as usize + voxel_offset(voxel) as usize];
        }
        if place == INSIDE { -self.header.band } else { self.header.band }
    }

    /// φ at the eight corners of a cell [m], z fastest.
    fn cell_phi(&self, corner: [i32; 3]) -> [f32; 8] {
        let [x, y, z] = corner;
        std::array::from_fn(|i| self.phi_at([x + (i as i32 >> 2), y + (i as i32 >> 1 & 1), z + (i as i32 & 1)]))
    }
}

/// Position of a voxel within its brick's values; z runs fastest.
pub fn voxel_offset(voxel: [i32; 3]) -> u32 {
    let local = voxel.map(|x| (x & (BRICK_SIDE as i32 - 1)) as u32);
    (local[0] << (2 * BRICK_SHIFT)) | (local[1] << BRICK_SHIFT) | local[2]
}

fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Trilinear interpolation of eight corner values, z fastest, at `f` (0 to 1 on each axis).
pub fn trilinear(v: &[f32; 8], f: [f32; 3]) -> f32 {
    let low = lerp(lerp(v[0], v[1], f[2]), lerp(v[2], v[3], f[2]), f[1]);
    let high = lerp(lerp(v[4], v[5], f[2]), lerp(v[6], v[7], f[2]), f[1]);
    lerp(low, high, f[0])
}
