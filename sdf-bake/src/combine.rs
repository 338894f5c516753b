//! Union, difference and intersection of two fields on one lattice.
//!
//! min(φ, ψ) is the exact distance outside a union, and also inside it unless the nearer surface is buried in the other
//! body. If it is buried, the nearest point of the union is on the other body's surface or on the seam, where both
//! distances vanish (`seam.rs`). Voxels of cells that the surface crosses never change, so the zero set is that of
//! min(φ, ψ). A difference is the complement of a union with a complement, and so is an intersection.
//!
//! ```text
//!      ψ = 0 ┌────────┐            ··· buried surface
//!   ┌────────┼········│ φ = 0      ▒   nearest surface buried: distance to the seam
//!   │       ▒:▒       │
//!   └────────┴────────┘
//! ```

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use thiserror::Error;

use crate::channels::Scalar;
use crate::grid::{BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE, voxel_at};
use crate::index::columns;
use crate::redistance::{VoxelSet, contains, insert};
use crate::seam::Bodies;

/// Two grids that do not share a lattice.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("the grids differ: voxel {voxels:?} m, band {bands:?} m; both must be equal")]
pub struct LatticeError {
    /// Voxels of the two grids [m].
    pub voxels: [f64; 2],
    /// Bands of the two grids [m].
    pub bands: [f32; 2],
}

/// Reason why two grids cannot be combined.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum CombineError {
    /// They do not share a lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// The blend reaches beyond the band.
    #[error("a blend radius of {radius} m with a band of {band} m: 0 to {:.6} m are accepted; a wider band allows more", BLEND_REACH * f64::from(*band))]
    Blend {
        /// Requested radius [m].
        radius: f64,
        /// Band of the grids [m].
        band: f32,
    },
}

/// Greatest blend radius [bands]: the surface may move where both distances are below 5/4 of the radius.
pub const BLEND_REACH: f64 = 0.8;

/// Boolean operation on two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Combine {
    /// Points in either body: min(φ, ψ).
    Union,
    /// The union with its inner edges filled: min(φ, ψ) − r h²/4 with h = max(1 − |φ − ψ|/r, 0), the quadratic smooth
    /// minimum (I. Quilez 2013). In a right-angled inner edge the fillet meets both faces at distance r from the edge
    /// and fills r²/6 of the section. Surfaces farther than r from each other do not change.
    SmoothUnion {
        /// r [m], at most 0.8 bands.
        radius: f64,
    },
    /// Points in the first body but not in the second: max(φ, −ψ).
    Difference,
    /// Points in both bodies: max(φ, ψ).
    Intersection,
}

impl Combine {
    /// Signs of φ and ψ that convert this to a union, and the sign that converts the result back.
    fn signs(self) -> [f32; 3] {
        match self {
            Self::Union | Self::SmoothUnion { .. } => [1.0, 1.0, 1.0],
            Self::Difference => [-1.0, 1.0, -1.0],
            Self::Intersection => [-1.0, -1.0, -1.0],
        }
    }

    fn radius(self) -> f64 {
        if let Self::SmoothUnion { radius } = self { radius } else { 0.0 }
    }
}

impl BrickGrid {
    /// Combines this body with `other`: truncated distances, with the sign known everywhere. They are exact where the
    /// nearest surface is that of one body, and the distance to the seam elsewhere; the surface is that of min or max
    /// of the two. Each voxel keeps label, dose and other channels of the body whose surface is nearer; surfaces opened
    /// by a cut keep those of this body.
    ///
    /// # Errors
    /// [`CombineError`] if voxel or band differ, or a blend reaches beyond the band.
    pub fn combined_with(&self, other: &BrickGrid, how: Combine) -> Result<BrickGrid, CombineError> {
        let band = f64::from(self.band);
        if !(0.0..=BLEND_REACH * band).contains(&how.radius()) {
            return Err(CombineError::Blend { radius: how.radius(), band: self.band });
        }
        let (mut grid, mut from_other) = Combination::of(self, other, how)?.grid(false);
        if how == Combine::Difference {
            from_other.fill(VoxelSet::default());
        }
        grid.label = inherit(&grid, [(self, &self.label), (other, &other.label)], &from_other);
        grid.inherit_scalars(self, other, &from_other);
        grid.release_uniform_bricks();
        grid.index.tidy();
        Ok(grid)
    }

    /// Takes the scalars of the `owned` voxels of each brick from `second`, of the others from `first`.
    pub(crate) fn inherit_scalars(&mut self, first: &Self, second: &Self, owned: &[VoxelSet]) {
        for channel in Scalar::ALL {
            let parts = [(first, first.scalar(channel)), (second, second.scalar(channel))];
            *self.scalar_mut(channel) = inherit(self, parts, owned);
        }
    }

    /// Values of a brick in a channel of this grid; `None` outside the pool.
    fn brick_values<'v, T>(&self, values: &'v [T], brick: IVec3) -> Option<&'v [T]> {
        let first = self.slot(brick) as usize * BRICK_VOXELS;
        values.get(first..first + BRICK_VOXELS)
    }

    /// φ of a whole brick [m], also outside the pool.
    fn brick_phi(&self, brick: IVec3) -> [f32; BRICK_VOXELS] {
        match self.slot(brick) {
            OUTSIDE => [self.band; BRICK_VOXELS],
            INSIDE => [-self.band; BRICK_VOXELS],
            slot => {
                let first = slot as usize * BRICK_VOXELS;
                std::array::from_fn(|offset| self.phi[first + offset])
            }
        }
    }
}

/// A channel for the bricks of `grid` from two others: the second's in the `owned` voxels of each brick, otherwise the
/// first's.
pub(crate) fn inherit<T: Copy + Default>(
    grid: &BrickGrid,
    parts: [(&BrickGrid, &[T]); 2],
    owned: &[VoxelSet],
) -> Vec<T> {
    if parts.iter().all(|(_, values)| values.is_empty()) {
        return Vec::new();
    }
    let mut all = Vec::with_capacity(grid.phi.len());
    for (&brick, owned) in grid.bricks.iter().zip(owned) {
        let none = &[T::default(); BRICK_VOXELS][..];
        let [first, second] = parts.map(|(from, values)| from.brick_values(values, brick).unwrap_or(none));
        if *owned == VoxelSet::default() {
            all.extend_from_slice(first);
        } else {
            let value = |offset: usize| if contains(owned, offset) { second[offset] } else { first[offset] };
            all.extend((0..BRICK_VOXELS).map(value));
        }
    }
    all
}

/// Two bodies, with signs that make their combination a union.
pub(crate) struct Combination<'a> {
    bodies: Bodies<'a>,
    /// Sign that converts the union's φ to that of the combination.
    back: f32,
    radius: f32,
    whole_box: bool,
}

/// One brick of a combination.
struct Mixed {
    phi: [f32; BRICK_VOXELS],
    /// Voxels closer to the second body's surface.
    from_second: VoxelSet,
    inexact: Vec<Inexact>,
}

/// A voxel at which φ is not the distance.
struct Inexact {
    /// Offset in the brick.
    offset: usize,
    exactness: Exactness,
    /// The smaller of both distances [m], an upper bound of the union's.
    bound: f32,
}

/// Knowledge of the distance at a voxel.
#[derive(Clone, Copy)]
enum Exactness {
    /// The distance is φ.
    Exact,
    /// The distance has this value [m].
    Other(f32),
    /// The distance follows only from the voxels around.
    Unknown,
}

enum Part {
    Uniform(u32),
    /// Only one body's surface is within the band.
    Lone(usize),
    Mixed(Box<Mixed>),
}

impl Part {
    fn is_outside(&self) -> bool {
        matches!(self, Self::Uniform(OUTSIDE))
    }
}

impl<'a> Combination<'a> {
    pub(crate) fn of(first: &'a BrickGrid, second: &'a BrickGrid, how: Combine) -> Result<Self, LatticeError> {
        if first.voxel != second.voxel || first.band != second.band {
            return Err(LatticeError { voxels: [first.voxel, second.voxel], bands: [first.band, second.band] });
        }
        let whole_box = matches!(how, Combine::Union | Combine::SmoothUnion { .. });
        let [s, t, back] = how.signs();
        Ok(Self {
            bodies: Bodies { grids: [first, second], signs: [s, t] },
            back,
            radius: how.radius() as f32,
            whole_box,
        })
    }

    /// Returns the combination, and for each of its bricks the voxels closer to the second body's surface. Labels and
    /// scalars of the first are not copied. With `keeps_core`, bricks that only the second body fills are kept.
    pub(crate) fn grid(&self, keeps_core: bool) -> (BrickGrid, Vec<VoxelSet>) {
        let [first, second] = self.bodies.grids;
        let (origin, dims) = if self.whole_box {
            let origin = first.origin.min(second.origin);
            (origin, (first.origin + first.dims).max(second.origin + second.dims) - origin)
        } else {
            (first.origin, first.dims)
        };
        let mut grid = BrickGrid::empty(first.voxel, first.band, origin, dims);
        let parts = columns(dims).flat_map_iter(|column| {
            let bricks = self.occupied(origin + column.extend(0), dims.z);
            bricks.map(|brick| (brick, self.part(brick, keeps_core))).filter(|(_, part)| !part.is_outside())
        });
        let parts: Vec<(IVec3, Part)> = parts.collect();
        let pooled = parts.iter().filter(|(_, part)| !matches!(part, Part::Uniform(_))).count();
        grid.phi.reserve_exact(pooled * BRICK_VOXELS);
        let (mut from_second, mut inexact) = (Vec::with_capacity(pooled), Vec::new());
        for (brick, part) in parts {
            if let Part::Uniform(side) = part {
                grid.set_slot(brick, side);
                continue;
            }
            let slot = grid.bricks.len() as u32;
            grid.set_slot(brick, slot);
            grid.bricks.push(brick);
            from_second.push(match part {
                Part::Lone(body) => self.append_lone(body, brick, &mut grid.phi),
                Part::Mixed(mixed) => {
                    grid.phi.extend_from_slice(&mixed.phi);
                    inexact.extend((!mixed.inexact.is_empty()).then_some((slot, mixed.inexact)));
                    mixed.from_second
                }
                Part::Uniform(_) => unreachable!("handled above"),
            });
        }
        self.settle(&mut grid, inexact);
        (grid, from_second)
    }

    /// Bricks from `lowest` upwards, `count` of them, that are not outside both bodies.
    fn occupied(&self, lowest: IVec3, count: i32) -> impl Iterator<Item = IVec3> + use<> {
        let of = |grid: &'a BrickGrid| {
            let low = lowest - grid.origin;
            grid.index.occupied(low.x, low.y).map(move |z| z - low.z)
        };
        let mut heights: Vec<i32> = self.bodies.grids.into_iter().flat_map(of).collect();
        heights.sort_unstable();
        heights.dedup();
        heights.into_iter().filter(move |z| (0..count).contains(z)).map(move |z| lowest + z * IVec3::Z)
    }

    /// Appends φ of a brick that only one body's surface reaches: the lesser of its own and the band. Returns the
    /// voxels closer to the second body's surface.
    fn append_lone(&self, body: usize, brick: IVec3, phi: &mut Vec<f32>) -> VoxelSet {
        let (grid, sign) = (self.bodies.grids[body], self.bodies.signs[body]);
        let own = grid.brick_values(&grid.phi, brick).expect("a brick of the pool");
        phi.extend(own.iter().map(|&own| self.back * (sign * own).min(grid.band)));
        let mut from_second = VoxelSet::default();
        for (offset, &own) in own.iter().enumerate() {
            let values = if body == 0 { [sign * own, grid.band] } else { [grid.band, sign * own] };
            if values[1] < values[0] {
                insert(&mut from_second, offset);
            }
        }
        from_second
    }

    /// Writes the known distances, and redistances the other voxels; those at the surface stay.
    fn settle(&self, grid: &mut BrickGrid, inexact: Vec<(u32, Vec<Inexact>)>) {
        let off_surface = |(slot, mut voxels): (u32, Vec<Inexact>)| {
            let halo = grid.halo(grid.bricks[slot as usize], 1);
            voxels.retain(|voxel| !halo.at_surface(voxel.offset));
            (slot, voxels)
        };
        let free: Vec<(u32, Vec<Inexact>)> = inexact.into_par_iter().map(off_surface).collect();
        let (mut slots, mut unknown, mut bounds) = (Vec::new(), Vec::new(), Vec::new());
        for (slot, voxels) in free {
            let mut set = VoxelSet::default();
            for Inexact { offset, exactness, bound } in voxels {
                let place = slot as usize * BRICK_VOXELS + offset;
                let phi = &mut grid.phi[place];
                if let Exactness::Other(distance) = exactness {
                    *phi = self.back * distance;
                } else {
                    bounds.push((place, bound));
                    *phi = grid.band.copysign(*phi);
                    insert(&mut set, offset);
                }
            }
            if set != VoxelSet::default() {
                slots.push(slot);
                unknown.push(set);
            }
        }
        grid.redistance_voxels(&slots, &unknown);
        // A point inside a union is no nearer to the union's surface than to that of its own body.
        for (place, bound) in bounds {
            grid.phi[place] = self.back * (self.back * grid.phi[place]).min(bound);
        }
    }

    fn part(&self, brick: IVec3, keeps_core: bool) -> Part {
        // Inside (-1), outside (1) or a brick (0), in terms of the union.
        let state = |body: usize| match self.bodies.grids[body].slot(brick) {
            OUTSIDE => self.bodies.signs[body],
            INSIDE => -self.bodies.signs[body],
            _ => 0.0,
        };
        let (a, b) = (state(0), state(1));
        let uniform = |side: f32| Part::Uniform(if side * self.back < 0.0 { INSIDE } else { OUTSIDE });
        if a < 0.0 || (b < 0.0 && !keeps_core) {
            return uniform(-1.0);
        }
        if a > 0.0 && b > 0.0 {
            return uniform(1.0);
        }
        if a == 0.0 && b > 0.0 {
            return Part::Lone(0);
        }
        if b == 0.0 && a > 0.0 {
            return Part::Lone(1);
        }
        Part::Mixed(Box::new(self.mixed(brick)))
    }

    fn mixed(&self, brick: IVec3) -> Mixed {
        let (grids, [s, t]) = (self.bodies.grids, self.bodies.signs);
        let (first, second) = (grids[0].brick_phi(brick), grids[1].brick_phi(brick));
        let mut mixed = Mixed { phi: [0.0; BRICK_VOXELS], from_second: VoxelSet::default(), inexact: Vec::new() };
        for offset in 0..BRICK_VOXELS {
            let values = [s * first[offset], t * second[offset]];
            if values[1] < values[0] {
                insert(&mut mixed.from_second, offset);
            }
            let point = grids[0].position(voxel_at(brick, offset));
            let (value, exactness) = self.value(values, point);
            if !matches!(exactness, Exactness::Exact) {
                mixed.inexact.push(Inexact { offset, exactness, bound: values[0].min(values[1]) });
            }
            mixed.phi[offset] = self.back * value;
        }
        mixed
    }

    /// φ of the union at a point [m] where the bodies' distances are `values` [m], and the knowledge of its distance.
    fn value(&self, values: [f32; 2], point: DVec3) -> (f32, Exactness) {
        let band = self.bodies.grids[0].band;
        let least = values[0].min(values[1]);
        if self.radius > 0.0 && self.bodies.feet_are_within(values, self.radius, point) {
            return (self.bodies.blended(values, self.radius, point).clamp(-band, least), Exactness::Unknown);
        }
        if !self.bodies.is_buried(values, point) {
            return (least, Exactness::Exact);
        }
        match self.bodies.depth(values, point) {
            Some(depth) => (least, Exactness::Other(depth.clamp(-band, least))),
            None => (least, Exactness::Unknown),
        }
    }
}
