//! Extracts the part of a field in a box.

use glam::{DVec3, IVec3};

use crate::channels::Scalar;
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE};

impl BrickGrid {
    /// Returns the bricks that touch the box from `low` to `high` [m], with their channels. Everything beyond them is
    /// outside, so the part is cut off there without a surface.
    pub fn within(&self, low: DVec3, high: DVec3) -> Self {
        let side = self.voxel * BRICK_SIDE as f64;
        let brick = |point: DVec3| (point / side).floor().as_ivec3();
        let first = brick(low).max(self.origin);
        let dims = (brick(high) + 1).min(self.origin + self.dims) - first;
        let mut kept = Self::empty(self.voxel, self.band, first, dims.max(IVec3::ZERO));
        for x in 0..kept.dims.x {
            for y in 0..kept.dims.y {
                for z in 0..kept.dims.z {
                    kept.take_brick(self, first + IVec3::new(x, y, z));
                }
            }
        }
        kept
    }

    /// Copies a brick of another field, or its side.
    fn take_brick(&mut self, from: &Self, brick: IVec3) {
        let slot = from.slot(brick);
        if matches!(slot, OUTSIDE | INSIDE) {
            self.set_slot(brick, slot);
            return;
        }
        self.set_slot(brick, self.bricks.len() as u32);
        self.bricks.push(brick);
        let values = slot as usize * BRICK_VOXELS..(slot as usize + 1) * BRICK_VOXELS;
        self.phi.extend_from_slice(&from.phi[values.clone()]);
        self.label.extend_from_slice(from.label.get(values.clone()).unwrap_or_default());
        for channel in Scalar::ALL {
            let taken = from.scalar(channel).get(values.clone()).unwrap_or_default();
            self.scalar_mut(channel).extend_from_slice(taken);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_keeps_its_bricks_with_their_channels_and_nothing_else() {
        let half = DVec3::splat(0.02);
        let mut ball = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.length() - 0.015);
        ball.label = (0..ball.phi.len()).map(|at| (at % 7) as u16).collect();
        ball.dose = (0..ball.phi.len()).map(|at| at as f32).collect();
        let (low, high) = (DVec3::new(0.0, -0.004, 0.008), DVec3::new(0.016, 0.004, 0.02));
        let kept = ball.within(low, high);
        assert_eq!(kept.sanity_check(), Ok(()));
        assert!(kept.brick_count() > 0 && kept.brick_count() < ball.brick_count() / 4);
        for i in 0..200 {
            let share = DVec3::new(f64::from(i * 37 % 200), f64::from(i * 91 % 200), f64::from(i)) / 200.0;
            let point = low + share * (high - low);
            assert_eq!(kept.sample(point), ball.sample(point));
            assert_eq!(kept.label(point), ball.label(point));
            assert_eq!(kept.sample_dose(point), ball.sample_dose(point));
        }
        assert_eq!(kept.sample(DVec3::new(-0.0149, 0.0, 0.0)), kept.band);
        assert_eq!(ball.within(DVec3::splat(1.0), DVec3::splat(2.0)).brick_count(), 0);
    }
}
