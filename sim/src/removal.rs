//! Material removal, Eq. (1): `∂φ/∂t = r |∇φ|` with `r = k max(p - p_c, 0)`.
//!
//! The rate of a voxel is that of its closest surface point `x - φ ∇φ`, so φ stays a distance while the
//! surface recedes (extension velocities, Adalsteinsson and Sethian 1999).
//!
//! A stiff contact relaxes over the length v/(kK), which may be less than a voxel. Then the voxels, as a
//! quadrature of the law, are a few per cent off its integral over the patch. So each step's rates are
//! scaled to remove exactly what the law asks of the patch: `dV/dt = ∫ r dA` holds step by step.

use glam::{DVec3, IVec3};
use rayon::prelude::*;
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_SIDE, BRICK_VOXELS, voxel_at};
use sdf_bake::halo::Halo;
use sdf_bake::redistance::KEPT_VOXELS;

use crate::tool::{Pose, Wheel};

/// Most by which a step's rates are scaled.
const MOST_SCALED: f64 = 0.2;

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
    /// Recession speed r [m/s] at a surface point [m] with outward unit normal. At the side faces it falls
    /// to zero over `span` [m].
    pub fn rate(&self, point: DVec3, normal: DVec3, span: f64) -> f64 {
        let depth = self.wheel.depth(&self.pose, point) - self.law.threshold_pressure / self.law.stiffness;
        if !(depth > 0.0 && normal.dot(self.pose.approach) > 0.0) {
            return 0.0;
        }
        let cover = self.wheel.cover((point - self.pose.centre).dot(self.pose.axis), span);
        // Eq. (1), recession speed
        self.law.grind_rate * self.law.stiffness * depth * cover
    }
}

/// What a step shall remove.
pub struct Cut<'a> {
    /// Surface points under pressure [m].
    pub wet: &'a [DVec3],
    /// Time for which the press lasts [s].
    pub duration: f64,
    /// `∫ r dA` over the patch times the duration [m³].
    pub volume: f64,
}

/// What one step of removal did.
#[derive(Clone, Debug, Default)]
pub struct Receded {
    /// Slots whose φ may have changed, in increasing order.
    pub slots: Vec<u32>,
    /// Furthest that the surface moved [m].
    pub furthest: f64,
}

/// Lets the surface recede under a press.
pub fn recede(grid: &mut BrickGrid, press: &Press, cut: &Cut) -> Receded {
    let slots = slots_around(grid, cut.wet);
    let rises: Vec<Rise> = slots.par_iter().map(|&slot| rise_of_brick(grid, slot, press, cut.duration)).collect();
    let volume: f64 = rises.iter().map(|rise| rise.volume).sum();
    let scale = if volume > 0.0 { (cut.volume / volume).clamp(1.0 - MOST_SCALED, 1.0 + MOST_SCALED) } else { 1.0 };
    let mut furthest = 0f64;
    for (&slot, rise) in slots.iter().zip(&rises) {
        let at = slot as usize * BRICK_VOXELS;
        for (phi, way) in grid.phi[at..at + BRICK_VOXELS].iter_mut().zip(&rise.phi) {
            *phi = (*phi + *way * scale as f32).min(grid.band);
        }
        furthest = furthest.max(rise.furthest * scale);
    }
    Receded { slots, furthest }
}

/// How φ of a brick's voxels rises in a step.
struct Rise {
    /// [m], shape `[512]`.
    phi: Vec<f32>,
    /// Volume that this removes [m³].
    volume: f64,
    /// Furthest that a surface point moves [m].
    furthest: f64,
}

fn rise_of_brick(grid: &BrickGrid, slot: u32, press: &Press, duration: f64) -> Rise {
    let brick = grid.bricks[slot as usize];
    let halo = grid.halo(brick, 1);
    let mut rise = Rise { phi: vec![0.0; BRICK_VOXELS], volume: 0.0, furthest: 0.0 };
    for offset in 0..BRICK_VOXELS {
        let at = halo.at(voxel_at(IVec3::ZERO, offset));
        let phi = f64::from(halo.phi[at]);
        let position = grid.position(voxel_at(brick, offset));
        // The closest surface point lies within 2 |φ|, and the depth changes no faster than the way.
        let dry = press.wheel.depth(&press.pose, position) + 2.0 * phi.abs() <= 0.0;
        if halo.phi[at].abs() >= grid.band || dry {
            continue;
        }
        let gradient = gradient(&halo, at) / grid.voxel;
        // Only distances that redistancing leaves alone can drift, and only they have whole neighbours.
        let kept = phi.abs() <= KEPT_VOXELS * grid.voxel;
        let steepness = if kept { gradient.length().clamp(0.5, 2.0) } else { 1.0 };
        let normal = gradient.normalize_or_zero();
        let closest = position - normal * (phi / steepness);
        let way = press.rate(closest, normal, grid.voxel) * duration;
        // Eq. (1)
        let risen = way * steepness;
        rise.phi[offset] = risen as f32;
        rise.volume += risen * volume_per_rise(&halo, at, normal, grid.voxel);
        rise.furthest = rise.furthest.max(way);
    }
    rise
}

/// Volume removed per rise of a voxel's φ [m²]: on the lattice line along the axis that the surface faces
/// most, the rise of the two voxels beside a crossing shifts it, each by its share.
fn volume_per_rise(halo: &Halo, at: usize, normal: DVec3, voxel: f64) -> f64 {
    let stride = halo.strides()[normal.abs().max_position()];
    let phi = f64::from(halo.phi[at]);
    let sides = [halo.phi[at - stride], halo.phi[at + stride]].map(f64::from);
    let crossed = sides.iter().filter(|&&near| (near < 0.0) != (phi < 0.0));
    crossed.map(|near| near.abs() / (near - phi).powi(2)).sum::<f64>() * voxel.powi(3)
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
