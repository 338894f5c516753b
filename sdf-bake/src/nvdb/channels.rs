//! A field with all its channels as one file, with one grid per channel under the channel's name.

use super::error::{BricksError, WriteError};
use super::tree::NvdbFile;
use super::{Codec, GridRef, write};
use crate::channels::Scalar;
use crate::grid::BrickGrid;

/// Name of the grid of φ.
pub const PHI: &str = "phi";
/// Name of the grid of weld ids.
pub const WELD_ID: &str = "weld_id";

/// Writes a file with φ as `phi`, weld ids as `weld_id`, and each [`Scalar`] under its name; channels that the field
/// does not have are omitted.
///
/// # Errors
/// Those of [`write()`].
pub fn write_field(field: &BrickGrid, codec: Codec) -> Result<Vec<u8>, WriteError> {
    let mut grids = vec![GridRef::LevelSet { name: PHI, grid: field }];
    if !field.label.is_empty() {
        grids.push(GridRef::Labels { name: WELD_ID, grid: field });
    }
    for channel in Scalar::ALL {
        let values = field.scalar(channel);
        if !values.is_empty() {
            grids.push(GridRef::Density { name: channel.name(), grid: field, values });
        }
    }
    write(&grids, codec)
}

impl NvdbFile {
    /// Restores the field that [`write_field`] wrote, with the channels that the file has.
    ///
    /// # Errors
    /// No grid `phi`, or a grid that cannot be converted to bricks or to a channel.
    pub fn to_field(&self) -> Result<BrickGrid, BricksError> {
        let found = || self.grids.iter().map(|grid| grid.name.clone()).collect();
        let phi = self.grid(PHI).ok_or_else(|| BricksError::Missing { wanted: PHI, found: found() })?;
        let mut field = phi.to_bricks()?;
        if let Some(labels) = self.grid(WELD_ID) {
            labels.attach_labels(&mut field)?;
        }
        for channel in Scalar::ALL {
            if let Some(grid) = self.grid(channel.name()) {
                grid.attach_scalar(channel, &mut field)?;
            }
        }
        Ok(field)
    }
}
