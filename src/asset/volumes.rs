//! NanoVDB files of an asset.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use files::input::{self, MOST_MESH_BYTES};
use sdf_bake::BrickGrid;
use sdf_bake::nvdb::{self, Checksum, Codec, GridRef, NvdbFile, NvdbGrid};

use super::check::{Check, Opened, Validation};
use super::exporter::{Content, Exporter};
use crate::workpiece::Workpiece;
use export::vdb::{read_vdb_names, write_vdb};

/// Level sets `phi` (welded workpiece) and `target` (bare part) [m].
pub const PHI_FILE: &str = "phi.nvdb";
/// Labels `weld_id` (0 for base metal) and `weld_share` (share of the voxel's cell that is weld metal, 0 to 1).
pub const WELD_FILE: &str = "weld.nvdb";

/// Fields of an asset, read from its files.
pub struct AssetFields {
    /// Welded workpiece with weld ids.
    pub welded: BrickGrid,
    /// Part without its welds: the target of finishing.
    pub target: BrickGrid,
    /// Share of each voxel's cell that is weld metal, in the order of `welded.phi`.
    pub share: Vec<f32>,
}

/// Exporter of `phi.nvdb`: the level sets.
pub(super) struct Phi;
/// Exporter of `weld.nvdb`: the weld of each voxel.
pub(super) struct WeldLabels;
/// Exporter of `fields.vdb`: the grids of both files as OpenVDB.
pub(super) struct Vdb;

/// Media type of the files with fields; none is registered for NanoVDB or OpenVDB.
const NANOVDB: &str = "application/octet-stream";

impl Exporter for Phi {
    const FILE: &'static str = PHI_FILE;
    const MEDIA_TYPE: &'static str = NANOVDB;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        let Workpiece { welded, target, .. } = content.workpiece;
        let phi = [GridRef::LevelSet { name: "phi", grid: welded }, GridRef::LevelSet { name: "target", grid: target }];
        Ok(fs::write(place, nvdb::write(&phi, Codec::Zip)?)?)
    }
}

impl Exporter for WeldLabels {
    const FILE: &'static str = WELD_FILE;
    const MEDIA_TYPE: &'static str = NANOVDB;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        let Workpiece { welded, target, .. } = content.workpiece;
        let share = welded.difference_share(target);
        let weld = [
            GridRef::Labels { name: "weld_id", grid: welded },
            GridRef::Density { name: "weld_share", grid: welded, values: &share },
        ];
        Ok(fs::write(place, nvdb::write(&weld, Codec::Zip)?)?)
    }
}

impl Exporter for Vdb {
    const FILE: &'static str = "fields.vdb";
    const MEDIA_TYPE: &'static str = NANOVDB;
    const ALWAYS: bool = false;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        if content.extras.vdb {
            let folder = place.parent().unwrap_or(place);
            let files = [read(folder, PHI_FILE)?, read(folder, WELD_FILE)?];
            let grids: Vec<&NvdbGrid> = files.iter().flat_map(|file| &file.grids).collect();
            fs::write(place, write_vdb(&grids))?;
        }
        Ok(())
    }

    fn check(opened: &Opened<'_>, found: &mut Validation) -> Result<()> {
        if opened.manifest.files.contains_key(Self::FILE) {
            let bytes = input::read(&opened.folder.join(Self::FILE), MOST_MESH_BYTES).unwrap_or_default();
            let names = read_vdb_names(&bytes).unwrap_or_default();
            let complete = names == ["phi", "target", "weld_id", "weld_share"];
            let rule = "is complete, with the grids of both NanoVDB files";
            found.checks.push(Check::new(Self::FILE, rule, complete, names.join(", ")));
        }
        Ok(())
    }
}

impl AssetFields {
    /// Reads the fields of an asset folder.
    ///
    /// # Errors
    /// If a file or a grid is missing or damaged, or its checksum is wrong.
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
