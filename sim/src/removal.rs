//! Material removal, Eq. (1): `∂φ/∂t = r |∇φ|` with `r = k max(p - p_c, 0)`.
//!
//! The rate of a voxel is that of its closest surface point `x - φ ∇φ`, so φ stays a distance while the
//! surface recedes (extension velocities, Adalsteinsson and Sethian 1999). A voxel stands for a piece of
//! surface one voxel wide: its rate is the mean over that piece, or rims and side faces of the wheel would
//! gain or lose up to half a voxel.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_SIDE, BRICK_VOXELS, voxel_at};
use sdf_bake::halo::Halo;

use crate::ramp::ramp_mean;
use crate::tool::{Pose, Wheel};

/// Law of removal on a contact with stiffness K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemovalLaw {
    /// K [Pa/m].
    pub stiffness: f64,
    /// k [m/(Pa s)].
    pub grind_rate: f64,
    /// p_c [Pa].
    pub threshold_pressure: f64,
}

/// A wheel at rest in its pose, pressing on a surface.
pub struct Press<'a> {
    /// The tool.
    pub wheel: &'a Wheel,
    /// Where it stands.
    pub pose: Pose,
    /// What it does to the surface under it.
    pub law: RemovalLaw,
}

impl Press<'_> {
    /// Recession speed r [m/s] at a surface point [m] with outward unit normal, mean over a piece of
    /// surface `span` [m] wide.
    pub fn rate(&self, point: DVec3, normal: DVec3, span: f64) -> f64 {
        let radial = self.wheel.radial(&self.pose, point);
        let depth = self.wheel.radius - radial.length() - self.law.threshold_pressure / self.law.stiffness;
        if depth <= -span || normal.dot(self.pose.approach) <= 0.0 {
            return 0.0;
        }
        let slope = radial.normalize().reject_from(normal).length();
        let mean_depth = ramp_mean(depth, (0.5 * span * slope, 0.0));
        let cover = self.wheel.cover((point - self.pose.centre).dot(self.pose.axis), span);
        // Eq. (1), recession speed
        self.law.grind_rate * self.law.stiffness * mean_depth * cover
    }
}

/// What one step of removal did.
#[derive(Clone, Debug, Default)]
pub struct Receded {
    /// Slots whose φ may have changed, in increasing order.
    pub slots: Vec<u32>,
    /// Furthest that the surface moved [m].
    pub furthest: f64,
}

/// Lets the surface recede for `duration` [s] under a press. `wet` are the surface points under pressure [m].
pub fn recede(grid: &mut BrickGrid, press: &Press, wet: &[DVec3], duration: f64) -> Receded {
    let slots = slots_around(grid, wet);
    let receded: Vec<(Vec<f32>, f64)> =
        slots.par_iter().map(|&slot| recede_brick(grid, slot, press, duration)).collect();
    let mut furthest = 0f64;
    for (&slot, (values, moved)) in slots.iter().zip(&receded) {
        let at = slot as usize * BRICK_VOXELS;
        grid.phi[at..at + BRICK_VOXELS].copy_from_slice(values);
        furthest = furthest.max(*moved);
    }
    Receded { slots, furthest }
}

/// New φ of a brick and the furthest that a surface point of its voxels moved [m].
fn recede_brick(grid: &BrickGrid, slot: u32, press: &Press, duration: f64) -> (Vec<f32>, f64) {
    let brick = grid.bricks[slot as usize];
    let halo = grid.halo(brick, 1);
    let mut furthest = 0f64;
    let values = (0..BRICK_VOXELS).map(|offset| {
        let at = halo.at(voxel_at(IVec3::ZERO, offset));
        let phi = halo.phi[at];
        if phi.abs() >= grid.band {
            return phi;
        }
        let gradient = gradient(&halo, at) / grid.voxel;
        let steepness = gradient.length().clamp(0.5, 2.0);
        let normal = gradient.normalize_or_zero();
        let closest = grid.position(voxel_at(brick, offset)) - normal * (f64::from(phi) / steepness);
        let moved = press.rate(closest, normal, grid.voxel) * duration;
        furthest = furthest.max(moved);
        // Eq. (1)
        (phi + (moved * steepness) as f32).min(grid.band)
    });
    (values.collect(), furthest)
}

/// Central differences [m per voxel].
fn gradient(halo: &Halo, at: usize) -> DVec3 {
    let along = |stride: usize| 0.5 * f64::from(halo.phi[at + stride] - halo.phi[at - stride]);
    let [x, y, z] = halo.strides();
    DVec3::new(along(x), along(y), along(z))
}

/// Slots of all bricks whose band voxels may have one of `points` [m] as their closest surface point.
fn slots_around(grid: &BrickGrid, points: &[DVec3]) -> Vec<u32> {
    let reach = f64::from(grid.band) + grid.voxel;
    let side = BRICK_SIDE as f64 * grid.voxel;
    let brick_of = |point: DVec3| (point / side).floor().as_ivec3();
    let Some(&first) = points.first() else { return Vec::new() };
    let (low, high) = points.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    let (low, high) = (brick_of(low - reach), brick_of(high + reach));
    let size = high - low + 1;
    let mut near = vec![false; size.x as usize * size.y as usize * size.z as usize];
    for &point in points {
        let (from, to) = (brick_of(point - reach) - low, brick_of(point + reach) - low);
        for x in from.x..=to.x {
            for y in from.y..=to.y {
                for z in from.z..=to.z {
                    near[((x * size.y + y) * size.z + z) as usize] = true;
                }
            }
        }
    }
    let entries = (0..near.len()).filter(|&i| near[i]).map(|i| i as i32);
    let bricks = entries.map(|i| low + IVec3::new(i / (size.y * size.z), i / size.z % size.y, i % size.z));
    let mut slots: Vec<u32> =
        bricks.map(|brick| grid.slot(brick)).filter(|&slot| (slot as usize) < grid.brick_count()).collect();
    slots.sort_unstable();
    slots
}
