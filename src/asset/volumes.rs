//! The NanoVDB files of an asset.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use files::input::{self, MOST_MESH_BYTES};
use sdf_bake::BrickGrid;
use sdf_bake::nvdb::{self, Checksum, Codec, GridRef, NvdbFile, NvdbGrid};

use crate::workpiece::Workpiece;

/// Level sets `phi` (welded workpiece) and `target` (bare part) [m].
pub const PHI_FILE: &str = "phi.nvdb";
/// `weld_id` (0 base metal) and `weld_share` (share of the voxel's cell that is weld metal, 0 to 1).
pub const WELD_FILE: &str = "weld.nvdb";

/// The fields of an asset, as its files hold them.
pub struct AssetFields {
    /// The welded workpiece with weld ids.
    pub welded: BrickGrid,
    /// The part without its welds: the target of finishing.
    pub target: BrickGrid,
    /// Share of each voxel's cell that is weld metal, in the order of `welded.phi`.
    pub share: Vec<f32>,
}

pub(super) fn write(workpiece: &Workpiece, folder: &Path) -> Result<()> {
    let (welded, target) = (&workpiece.welded, &workpiece.target);
    let phi = [GridRef::LevelSet { name: "phi", grid: welded }, GridRef::LevelSet { name: "target", grid: target }];
    fs::write(folder.join(PHI_FILE), nvdb::write(&phi, Codec::Zip)?)?;
    let share = welded.difference_share(target);
    let weld = [
        GridRef::Labels { name: "weld_id", grid: welded },
        GridRef::Density { name: "weld_share", grid: welded, values: &share },
    ];
    fs::write(folder.join(WELD_FILE), nvdb::write(&weld, Codec::Zip)?)?;
    Ok(())
}

impl AssetFields {
    /// Reads the fields of an asset folder.
    ///
    /// # Errors
    /// When a file or a grid is missing, damaged, or its checksum is wrong.
    pub fn open(folder: &Path) -> Result<Self> {
        let phi = read(folder, PHI_FILE)?;
        let weld = read(folder, WELD_FILE)?;
        let mut welded = level_set(&phi, "phi")?;
        let target = level_set(&phi, "target")?;
        grid(&weld, WELD_FILE, "weld_id")?.attach_labels(&mut welded).context(WELD_FILE)?;
        let share = grid(&weld, WELD_FILE, "weld_share")?.channel(&welded).context(WELD_FILE)?;
        Ok(Self { welded, target, share })
    }
}

fn read(folder: &Path, name: &str) -> Result<NvdbFile> {
    let bytes = input::read(&folder.join(name), MOST_MESH_BYTES).with_context(|| name.to_owned())?;
    let file = nvdb::read(&bytes).with_context(|| name.to_owned())?;
    for grid in &file.grids {
        ensure!(grid.checksum == Checksum::Matches, "{name}: grid {:?} does not match its checksum", grid.name);
    }
    Ok(file)
}

fn level_set(file: &NvdbFile, name: &str) -> Result<BrickGrid> {
    grid(file, PHI_FILE, name)?.to_bricks().with_context(|| format!("{PHI_FILE}: {name}"))
}

fn grid<'a>(file: &'a NvdbFile, file_name: &str, name: &str) -> Result<&'a NvdbGrid> {
    file.grid(name).with_context(|| format!("{file_name} holds no grid {name:?}"))
}
