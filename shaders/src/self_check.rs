//! Comparison of the device with the CPU twin on a field with known values: a real kernel on the user's own driver.

use crate::brick_grid::GridBuffers;
use crate::constants::{BRICK_SIDE, BRICK_VOXELS, INSIDE, OUTSIDE};
use crate::device::Device;
use crate::layout::GridHeader;
use crate::sample::{SampleError, Sampler};

/// Largest difference between device and twin that rounding explains [voxels]. Coordinates stay below 32 voxels. There
/// a division with an error of 2.5 units in the last place, as Vulkan guarantees, is accurate to 5e-6 voxels. On a
/// field of slope 1, including contracted multiply-adds, that leaves a factor of five.
pub const SELF_CHECK_LIMIT: f32 = 1e-4;

/// Distance between voxels of the checked grid [m].
const VOXEL: f32 = 0.001;
/// Its truncation distance [m].
const BAND: f32 = 0.003;
/// Radius of its ball [m]: the eight bricks around the centre are entirely inside, those in the corners entirely
/// outside.
const RADIUS: f32 = 0.0172;
/// Bricks from the centre to each side.
const REACH: i32 = 3;

/// Samples a ball on the device and on the CPU, and returns the largest difference [voxels]: NaN if only one of the two
/// gives NaN. The device is correct if the result is below [`SELF_CHECK_LIMIT`].
///
/// # Errors
/// The errors of [`Sampler`].
pub fn self_check(device: &Device) -> Result<f32, SampleError> {
    let (header, index, phi) = ball();
    let grid = GridBuffers { header, index: &index, phi: &phi };
    let points = points();
    let sampled = Sampler::new(device, &grid)?.sample(&points)?;
    let differences = points.iter().zip(&sampled).map(|(&[x, y, z, _], &phi)| {
        let expected = grid.sample_phi([x, y, z]);
        if expected.is_nan() && phi.is_nan() { 0.0 } else { (phi - expected).abs() / VOXEL }
    });
    Ok(worst(differences))
}

/// The largest number, or NaN if any is NaN, which `f32::max` would drop.
fn worst(differences: impl Iterator<Item = f32>) -> f32 {
    differences.fold(0.0, |worst, next| if worst.is_nan() || next <= worst { worst } else { next })
}

/// A ball around the origin: slots, both codes, and bricks on both sides of zero.
fn ball() -> (GridHeader, Vec<u32>, Vec<f32>) {
    let (mut index, mut phi) = (Vec::new(), Vec::new());
    let mut bricks = 0;
    let side = BRICK_SIDE as i32;
    for entry in 0..8 * REACH * REACH * REACH {
        let brick = [entry / (4 * REACH * REACH), entry / (2 * REACH) % (2 * REACH), entry % (2 * REACH)];
        let values: Vec<f32> = (0..BRICK_VOXELS as i32)
            .map(|offset| [offset >> 6, offset >> 3 & 7, offset & 7])
            .map(|local| std::array::from_fn(|axis| ((brick[axis] - REACH) * side + local[axis]) as f32 * VOXEL))
            .map(|[x, y, z]: [f32; 3]| ((x * x + y * y + z * z).sqrt() - RADIUS).clamp(-BAND, BAND))
            .collect();
        if values.iter().all(|&phi| phi == BAND) {
            index.push(OUTSIDE);
        } else if values.iter().all(|&phi| phi == -BAND) {
            index.push(INSIDE);
        } else {
            index.push(bricks);
            bricks += 1;
            phi.extend(values);
        }
    }
    let across = 2 * REACH as u32;
    (GridHeader::new([-REACH; 3], [across; 3], VOXEL, BAND, bricks), index, phi)
}

/// Points in and around the ball's box, on voxels and between them, and one that is not finite.
fn points() -> Vec<[f32; 4]> {
    // Fractional parts of multiples of irrational numbers fill the box evenly (Weyl 1916).
    let along = |i: u32, step: f64| ((f64::from(i) * step).fract() as f32 - 0.5) * 0.06;
    let mut points: Vec<_> =
        (0..20_000).map(|i| [along(i, 0.819_172_513), along(i, 0.671_043_606), along(i, 0.549_700_477), 0.0]).collect();
    points.extend((-30..30).map(|i| [i as f32 * VOXEL, 0.0, -0.002, 0.0]));
    points.push([f32::NAN, 0.0, 0.0, 0.0]);
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_is_the_worst_difference() {
        assert_eq!(worst([0.1, 0.3, 0.2].into_iter()), 0.3);
        assert!(worst([0.1, f32::NAN, 0.2].into_iter()).is_nan());
    }

    #[test]
    fn the_twin_reads_the_ball_to_second_order() {
        let (header, index, phi) = ball();
        let grid = GridBuffers { header, index: &index, phi: &phi };
        assert_eq!(grid.validate(), Ok(()));
        assert!(index.contains(&INSIDE) && index.contains(&OUTSIDE));
        let mut near = 0;
        for [x, y, z, _] in points() {
            let exact = (x * x + y * y + z * z).sqrt() - RADIUS;
            if exact.abs() < BAND - 2.0 * VOXEL {
                near += 1;
                // The trilinear error is at most h²/8 Σ |∂²φ/∂xᵢ²|, and that sum is 2 / r.
                let bound = 0.25 * VOXEL * VOXEL / (RADIUS - BAND);
                assert!((grid.sample_phi([x, y, z]) - exact).abs() < bound, "at {x} {y} {z}");
            }
        }
        assert!(near > 200, "{near} points near the surface");
    }
}
