//! The part of a trial, built from its scan before the first pass.

use sdf_bake::BrickGrid;
use sdf_bake::heights::SlabOptions;

use super::{SimulationError, Variation};
use trials::trial::Trial;

/// The part of a trial before its first pass, on voxels of a size [m].
pub(super) fn part_before(trial: &Trial, voxel: f64, variation: &Variation) -> Result<BrickGrid, SimulationError> {
    let options = SlabOptions { margin: trial.tool.half_width() + 4.0 * voxel, ..SlabOptions::with_voxel(voxel) };
    let mut before = trial.scans.checked_before();
    let added = variation.before.iter().flat_map(|map| &map.heights);
    before
        .heights
        .iter_mut()
        .zip(added)
        .for_each(|(height, added)| *height += if added.is_finite() { *added } else { 0.0 });
    let (mut part, _) = BrickGrid::from_heights(&before, &options)?;
    if let Some(material) = &trial.scans.material {
        part.label_columns(&material.pixels, &material.labels);
    }
    Ok(part)
}
