//! Memory that baking would need, estimated from the mesh before any allocation.

use thiserror::Error;

use crate::grid::{BRICK_SIDE, BRICK_VOXELS};
use crate::{BakeOptions, Mesh};

/// Greatest number of bricks of a field: 1.6 GB of distances and labels, and several times that while a workpiece is
/// made.
pub const MOST_BRICKS: f64 = 5e5;
/// Bytes of distance and label in a brick.
const BRICK_BYTES: f64 = 6.0 * BRICK_VOXELS as f64;

/// Reason why a part cannot be baked with some options.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum BudgetError {
    /// The voxel is larger than the part.
    #[error("a voxel of {voxel_mm:.3e} mm is larger than the part of {part_mm:.3e} mm: use a smaller --voxel-mm")]
    VoxelTooLarge {
        /// The voxel [mm].
        voxel_mm: f64,
        /// The part's longest side [mm].
        part_mm: f64,
    },
    /// The grid is too large for memory.
    #[error(
        "a voxel of {voxel_mm:.3e} mm with a band of {band} voxels needs about {bricks:.1e} bricks ({gigabytes:.1} GB), and \
         {MOST_BRICKS:.0e} are accepted: use --voxel-mm {least_voxel_mm:.3e} or more, --resolution {resolution:.0} or less, or a \
         smaller --band"
    )]
    TooManyBricks {
        /// The voxel [mm].
        voxel_mm: f64,
        /// Half width of the band [voxels].
        band: f64,
        /// Required number of bricks.
        bricks: f64,
        /// Memory of these bricks [GB].
        gigabytes: f64,
        /// Least voxel that fits [mm].
        least_voxel_mm: f64,
        /// Greatest resolution that fits.
        resolution: f64,
    },
}

/// Estimated number of bricks for the band around a surface, including half the shell: `A (2 b + 1.5 s) / s³`.
///
/// A slab of area A and thickness t meets `A (t + w) / s³` cubes of side s, where w is the cube's width across the
/// slab, 1.5 s on average over all directions (Cauchy 1841). The estimate is limited to the number of bricks in the box
/// around the band.
fn expected_bricks(mesh: &Mesh, options: &BakeOptions) -> f64 {
    let side = BRICK_SIDE as f64 * options.voxel;
    let band = options.band_voxels * options.voxel + options.half_shell();
    let around_surface = mesh.area() * (2.0 * band + 1.5 * side) / side.powi(3);
    let box_of_band =
        mesh.bounds().map_or(0.0, |(low, high)| ((high - low + 2.0 * band) / side + 1.0).element_product());
    around_surface.min(box_of_band)
}

/// Rejects a grid that is too large for memory; returns the estimated number of bricks.
///
/// # Errors
/// If the voxel is larger than the part, or more than half a million bricks would be needed; the message gives a voxel
/// that fits.
pub fn check(mesh: &Mesh, options: &BakeOptions) -> Result<f64, BudgetError> {
    let longest = mesh.bounds().map_or(0.0, |(low, high)| (high - low).max_element());
    if options.voxel > longest {
        return Err(BudgetError::VoxelTooLarge { voxel_mm: options.voxel * 1e3, part_mm: longest * 1e3 });
    }
    let bricks = expected_bricks(mesh, options);
    // The number of bricks around a surface falls with the square of the voxel, that in a box faster.
    let least_voxel = options.voxel * (bricks / MOST_BRICKS).sqrt();
    if bricks > MOST_BRICKS {
        return Err(BudgetError::TooManyBricks {
            voxel_mm: options.voxel * 1e3,
            band: options.band_voxels,
            bricks,
            gigabytes: bricks * BRICK_BYTES * 1e-9,
            least_voxel_mm: least_voxel * 1e3,
            resolution: (longest / least_voxel).floor(),
        });
    }
    Ok(bricks)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::bake;
    use crate::clean::clean;
    use crate::read::{Format, UnitChoice, parse_mesh};

    /// The bundled part.
    fn part() -> Mesh {
        let bytes = include_bytes!("../../data/bracket.obj");
        clean(parse_mesh(bytes, Format::Obj, UnitChoice::Millimetre, "bracket.obj").unwrap().mesh).unwrap().0
    }

    #[test]
    fn the_estimate_is_never_below_what_baking_makes_and_never_twice_as_much() {
        let part = part();
        for (voxel, band_voxels) in [(1e-3, 3.0), (0.5e-3, 3.0)] {
            let options = BakeOptions { band_voxels, ..BakeOptions::with_voxel(voxel) };
            let made = bake(&part, &options).unwrap().1.bricks as f64;
            let expected = expected_bricks(&part, &options);
            assert!((1.0..2.0).contains(&(expected / made)), "{made} bricks, {expected} expected");
        }
    }

    #[test]
    fn the_voxel_that_a_refusal_names_is_accepted() {
        let part = part();
        for band_voxels in [3.0, 64.0] {
            let options = BakeOptions { band_voxels, ..BakeOptions::with_voxel(1e-6) };
            let error = check(&part, &options).unwrap_err().to_string();
            let named = error.split("--voxel-mm ").nth(1).and_then(|text| text.split(' ').next()).unwrap();
            let voxel = 1.001e-3 * named.parse::<f64>().unwrap();
            assert!(check(&part, &BakeOptions { voxel, ..options }).is_ok(), "{error}");
        }
    }
}
