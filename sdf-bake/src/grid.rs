//! A sparse signed distance field: 8³-voxel bricks in one pool under a top-level index ([`BrickIndex`]).
//!
//! φ < 0 inside. Values are exact distances [m] within the band and ±band outside it. Voxel (i, j, k) is the *point*
//! `voxel · (i, j, k)` of the part's frame, not a cell. Inside or outside is known everywhere, also outside the bricks.

use glam::{DVec3, IVec3, Vec3};

use crate::channels::Scalar;
use crate::index::BrickIndex;

/// Voxels along the side of a brick.
pub const BRICK_SIDE: usize = 8;
/// Voxels in a brick.
pub const BRICK_VOXELS: usize = BRICK_SIDE * BRICK_SIDE * BRICK_SIDE;

/// Index entry of a brick that is entirely outside, beyond the band.
pub const OUTSIDE: u32 = u32::MAX;
/// Index entry of a brick that is entirely inside, beyond the band.
pub const INSIDE: u32 = u32::MAX - 1;

/// Position of a voxel within its brick's 512 values; z runs fastest, as in an OpenVDB leaf.
#[inline]
pub fn voxel_offset(voxel: IVec3) -> usize {
    let local = voxel & 7;
    ((local.x << 6) | (local.y << 3) | local.z) as usize
}

/// Voxel coordinates of the value at `offset` in the brick at `brick` [bricks].
pub fn voxel_at(brick: IVec3, offset: usize) -> IVec3 {
    let local = IVec3::new(offset as i32 >> 6, offset as i32 >> 3 & 7, offset as i32 & 7);
    brick * BRICK_SIDE as i32 + local
}

/// The sparse field and its channels. All channels have the same brick order.
#[derive(Clone, Debug, PartialEq)]
pub struct BrickGrid {
    /// Distance between voxels [m].
    pub voxel: f64,
    /// Distance at which φ is truncated [m].
    pub band: f32,
    /// Brick coordinates of the first index entry [bricks].
    pub origin: IVec3,
    /// Index entries per axis [bricks]; x runs slowest.
    pub dims: IVec3,
    /// Slot of each brick, or [`OUTSIDE`] or [`INSIDE`].
    pub index: BrickIndex,
    /// Brick coordinates of each slot [bricks], shape `[bricks]`.
    pub bricks: Vec<IVec3>,
    /// Signed distance [m], shape `[bricks, 512]`.
    pub phi: Vec<f32>,
    /// Weld id of each voxel, 0 for base metal, shape `[bricks, 512]`; empty if the part has no weld.
    pub label: Vec<u16>,
    /// Coating dose D of each voxel, shape `[bricks, 512]`; empty if the part has no coating.
    pub dose: Vec<f32>,
    /// Removed depth at each voxel [m], shape `[bricks, 512]`; empty if it is not recorded.
    pub removed: Vec<f32>,
}

impl BrickGrid {
    /// An empty grid, entirely outside.
    pub fn empty(voxel: f64, band: f32, origin: IVec3, dims: IVec3) -> Self {
        Self {
            voxel,
            band,
            origin,
            dims,
            index: BrickIndex::new(dims),
            bricks: Vec::new(),
            phi: Vec::new(),
            label: Vec::new(),
            dose: Vec::new(),
            removed: Vec::new(),
        }
    }

    /// Number of bricks in the pool.
    pub fn brick_count(&self) -> usize {
        self.bricks.len()
    }

    /// Bytes held by the pool and the index.
    pub fn bytes(&self) -> usize {
        let scalars: usize = Scalar::ALL.iter().map(|&channel| self.scalar(channel).len()).sum();
        4 * (self.phi.len() + scalars) + 2 * self.label.len() + 12 * self.bricks.len() + self.index.bytes()
    }

    /// Index of a brick's entry, x slowest; `None` outside the indexed box.
    pub(crate) fn entry(&self, brick: IVec3) -> Option<usize> {
        let at = brick - self.origin;
        let within = at.cmpge(IVec3::ZERO).all() && at.cmplt(self.dims).all();
        within.then(|| ((at.x * self.dims.y + at.y) as usize) * self.dims.z as usize + at.z as usize)
    }

    /// Slot of a brick, or [`OUTSIDE`] or [`INSIDE`].
    pub fn slot(&self, brick: IVec3) -> u32 {
        self.index.get(brick - self.origin)
    }

    /// Sets a brick's slot, or [`OUTSIDE`] or [`INSIDE`].
    ///
    /// # Panics
    /// If the brick is outside the indexed box.
    pub fn set_slot(&mut self, brick: IVec3, slot: u32) {
        self.index.set(brick - self.origin, slot);
    }

    /// True if cells whose lowest corners are in a brick lie between bricks that are entirely inside and entirely
    /// outside. This happens where a hole was closed for the sign only: the distance does not include the patch, and φ
    /// jumps.
    pub(crate) fn jumps_at(&self, brick: IVec3) -> bool {
        let around = |side: u32| (0..8).any(|i| self.slot(brick + cell_corner(i)) == side);
        around(INSIDE) && around(OUTSIDE)
    }

    /// Index of a voxel in the pool, or `None` outside the bricks.
    pub fn place(&self, voxel: IVec3) -> Option<usize> {
        match self.slot(voxel >> 3) {
            OUTSIDE | INSIDE => None,
            slot => Some(slot as usize * BRICK_VOXELS + voxel_offset(voxel)),
        }
    }

    /// Voxel at an index in the pool.
    pub fn voxel_of(&self, place: usize) -> IVec3 {
        voxel_at(self.bricks[place / BRICK_VOXELS], place % BRICK_VOXELS)
    }

    /// φ at a voxel [m].
    pub fn phi_at(&self, voxel: IVec3) -> f32 {
        match self.slot(voxel >> 3) {
            OUTSIDE => self.band,
            INSIDE => -self.band,
            slot => self.phi[slot as usize * BRICK_VOXELS + voxel_offset(voxel)],
        }
    }

    /// Weld id at a voxel; 0 for base metal and outside the bricks.
    pub fn label_at(&self, voxel: IVec3) -> u16 {
        self.place(voxel).and_then(|at| self.label.get(at)).copied().unwrap_or(0)
    }

    /// Position of a voxel in the part's frame [m].
    pub fn position(&self, voxel: IVec3) -> DVec3 {
        voxel.as_dvec3() * self.voxel
    }

    /// Weld id of the voxel nearest to a point [m].
    pub fn label(&self, point: DVec3) -> u16 {
        self.label_at((point / self.voxel).round().as_ivec3())
    }

    /// φ at a point [m], trilinear between the eight voxels around it.
    pub fn sample(&self, point: DVec3) -> f32 {
        let (corner, fraction) = self.cell(point);
        trilinear(&self.cell_phi(corner), fraction)
    }

    /// φ [m] and its gradient [1] at a point [m]: the exact derivative of the trilinear interpolant.
    pub fn sample_gradient(&self, point: DVec3) -> (f32, Vec3) {
        let (corner, fraction) = self.cell(point);
        let values = self.cell_phi(corner);
        let gradient = trilinear_gradient(&values, fraction) / self.voxel as f32;
        (trilinear(&values, fraction), gradient)
    }

    /// Outward unit normal at a point [m], from central differences over one voxel, which are smoother across cells
    /// than [`BrickGrid::sample_gradient`].
    pub fn normal(&self, point: DVec3) -> Vec3 {
        let h = 0.5 * self.voxel;
        let along = |axis: DVec3| self.sample(point + axis * h) - self.sample(point - axis * h);
        Vec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z)).normalize_or_zero()
    }

    /// Lowest voxel of the cell around a point [m], and the point's position in that cell (0 to 1).
    pub fn cell(&self, point: DVec3) -> (IVec3, Vec3) {
        let at = point / self.voxel;
        let corner = at.floor();
        (corner.as_ivec3(), (at - corner).as_vec3())
    }

    /// φ at the eight corners of a cell [m], z fastest.
    pub fn cell_phi(&self, corner: IVec3) -> [f32; 8] {
        let local = corner & 7;
        if local.max_element() < 7 {
            return self.cell_phi_within(corner);
        }
        std::array::from_fn(|i| self.phi_at(corner + cell_corner(i)))
    }

    /// [`BrickGrid::cell_phi`] for a cell whose corners lie in one brick.
    fn cell_phi_within(&self, corner: IVec3) -> [f32; 8] {
        match self.slot(corner >> 3) {
            OUTSIDE => [self.band; 8],
            INSIDE => [-self.band; 8],
            slot => {
                let base = slot as usize * BRICK_VOXELS + voxel_offset(corner);
                [0, 1, 8, 9, 64, 65, 72, 73].map(|step| self.phi[base + step])
            }
        }
    }

    /// Checks that index and pool are consistent and that all values are finite and within the band.
    ///
    /// # Errors
    /// A sentence that names the first faulty brick or voxel.
    pub fn sanity_check(&self) -> Result<(), String> {
        if self.phi.len() != self.bricks.len() * BRICK_VOXELS {
            return Err(format!("{} values for {} bricks", self.phi.len(), self.bricks.len()));
        }
        self.check_channels()?;
        for (slot, &brick) in self.bricks.iter().enumerate() {
            if self.slot(brick) != slot as u32 {
                return Err(format!("brick {brick} is in slot {slot}, the index says {}", self.slot(brick)));
            }
        }
        let limit = self.band * (1.0 + 1e-6);
        match self.phi.iter().position(|&phi| phi.is_nan() || phi.abs() > limit) {
            Some(at) => Err(format!("φ is {} at voxel {}, the band is {}", self.phi[at], self.voxel_of(at), self.band)),
            None => Ok(()),
        }
    }
}

/// Offset of corner `i` of a cell, z fastest.
#[inline]
pub fn cell_corner(i: usize) -> IVec3 {
    IVec3::new(i as i32 >> 2, i as i32 >> 1 & 1, i as i32 & 1)
}

/// Trilinear interpolation of eight corner values, z fastest, at `f` (0 to 1 on each axis).
#[inline]
pub fn trilinear(values: &[f32; 8], f: Vec3) -> f32 {
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let z = |i: usize| mix(values[i], values[i + 1], f.z);
    let y = |i: usize| mix(z(i), z(i + 2), f.y);
    mix(y(0), y(4), f.x)
}

/// Gradient of [`trilinear`] with respect to `f`.
pub fn trilinear_gradient(values: &[f32; 8], f: Vec3) -> Vec3 {
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let z = |i: usize| mix(values[i], values[i + 1], f.z);
    let dz = |i: usize| values[i + 1] - values[i];
    let y = |i: usize| mix(z(i), z(i + 2), f.y);
    let dy = |i: usize| z(i + 2) - z(i);
    Vec3::new(y(4) - y(0), mix(dy(0), dy(4), f.x), mix(mix(dz(0), dz(2), f.y), mix(dz(4), dz(6), f.y), f.x))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One brick with a linear field, which trilinear sampling must reproduce exactly.
    fn linear_grid() -> (BrickGrid, impl Fn(DVec3) -> f64) {
        let plane = |p: DVec3| 0.02 * p.x - 0.05 * p.y + 0.01 * p.z + 0.001;
        let mut grid = BrickGrid::empty(0.5, 1.0, IVec3::splat(-1), IVec3::ONE);
        grid.set_slot(IVec3::splat(-1), 0);
        grid.bricks.push(IVec3::splat(-1));
        grid.phi = (0..BRICK_VOXELS).map(|o| plane(voxel_at(IVec3::splat(-1), o).as_dvec3() * 0.5) as f32).collect();
        (grid, plane)
    }

    #[test]
    fn sampling_reproduces_a_linear_field_and_its_gradient() {
        let (grid, plane) = linear_grid();
        for i in 0..50 {
            let t = i as f64 / 50.0;
            let point = DVec3::new(-3.9 + 3.3 * t, -0.6 - 3.0 * t * t, -2.0 + t);
            let (phi, gradient) = grid.sample_gradient(point);
            assert!((phi as f64 - plane(point)).abs() < 1e-6, "at {point}");
            assert!((gradient - Vec3::new(0.02, -0.05, 0.01)).length() < 1e-6, "at {point}");
        }
    }

    #[test]
    fn offsets_and_coordinates_are_inverse() {
        for offset in 0..BRICK_VOXELS {
            let voxel = voxel_at(IVec3::new(-3, 0, 7), offset);
            assert_eq!(voxel_offset(voxel), offset);
            assert_eq!(voxel >> 3, IVec3::new(-3, 0, 7));
        }
    }

    #[test]
    fn the_sanity_check_names_a_bad_voxel() {
        let (mut grid, _) = linear_grid();
        assert_eq!(grid.sanity_check(), Ok(()));
        grid.phi[9] = f32::NAN;
        assert!(grid.sanity_check().unwrap_err().contains("NaN"));
    }
}
