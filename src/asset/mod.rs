//! The asset folder: meshes, fields, labels and ground truth of a welded workpiece, in standard formats.
//!
//! Each file has an [`Exporter`] and a row in [`EXPORTS`]; the [`Manifest`] is written last with all hashes.

mod check;
mod exporter;
mod manifest;
mod meshes;
mod preview;
mod surface;
mod truth;
mod usd;
mod volumes;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::Serialize;

use crate::console::Console;
use crate::picture::{SAMPLES_PER_SIDE, VIEW_SIZE};
use crate::workpiece::{WeldingOptions, Workpiece};
use export::mass::STEEL_DENSITY;
use export::models::Models;
use export::surface::WeldedSurface;
use files::folder::StagedFolder;
use files::output::FolderKind;

pub use check::{Check, Opened, Validation};
pub use exporter::{Content, Export, Exporter};
pub use manifest::{ASSET_FORMAT, FileRecord, MANIFEST_FILE, Manifest, record_files};
pub use meshes::Meshes;
pub use truth::{CurveTruth, Imperfection, WELDS_FORMAT, WeldTruth, Welds};
pub use usd::UsdMode;
pub use volumes::{AssetFields, PHI_FILE, WELD_FILE};

/// Name of the ground truth file.
pub const WELDS_FILE: &str = "welds.json";
/// Name of the bare part's mesh file.
pub const WORKPIECE_FILE: &str = "workpiece.glb";
/// Name of the welded mesh file.
pub const WELDED_FILE: &str = "welded.glb";
/// Name of the mesh file of the welded surface.
pub const SURFACE_FILE: &str = "surface.glb";
/// Name of the USD file.
pub const USD_FILE: &str = "welded.usdc";
/// Name of the picture.
pub const PREVIEW_FILE: &str = "preview.png";

/// Exporters in the order in which they run, the manifest apart: USD is made from the files before it.
pub const EXPORTS: &[Export] = &[
    Export::of::<meshes::PartMesh>(),
    Export::of::<meshes::WeldedMeshes>(),
    Export::of::<surface::Surface>(),
    Export::of::<volumes::Phi>(),
    Export::of::<volumes::WeldLabels>(),
    Export::of::<truth::Truth>(),
    Export::of::<preview::Preview>(),
    Export::of::<surface::Model<0>>(),
    Export::of::<surface::Model<1>>(),
    Export::of::<surface::Model<2>>(),
    Export::of::<surface::Model<3>>(),
    Export::of::<surface::Model<4>>(),
    Export::of::<surface::Model<5>>(),
    Export::of::<volumes::Vdb>(),
    Export::of::<usd::Usd>(),
];

/// Names of the files in [`EXPORTS`].
pub const ASSET_NAMES: &[&str] = &{
    let mut names = [""; EXPORTS.len()];
    let mut row = 0;
    while row < names.len() {
        names[row] = EXPORTS[row].file;
        row += 1;
    }
    names
};
/// Kind of an asset's folder.
pub const ASSET: FolderKind = FolderKind { marker: MANIFEST_FILE, key: "baking", names: &[("", ASSET_NAMES)] };

/// Settings of the picture, of the USD file and of the files that follow from the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extras {
    /// Density [kg/m³] for the mass; `None` leaves out all files of [`export::models`].
    pub density: Option<f64>,
    /// True for light meshes and robot models, which take long at fine voxels.
    pub models: bool,
    /// True for `fields.vdb`.
    pub vdb: bool,
    /// Mode of the USD file.
    pub usd: UsdMode,
    /// Width and height of the picture [pixels].
    pub preview: (usize, usize),
    /// Samples along each side of the picture's pixels.
    pub samples_per_side: usize,
}

impl Extras {
    /// Settings with a large picture, steel, and USD as requested.
    pub fn full(usd: UsdMode) -> Self {
        Self {
            density: Some(STEEL_DENSITY),
            models: false,
            vdb: false,
            usd,
            preview: VIEW_SIZE,
            samples_per_side: SAMPLES_PER_SIDE,
        }
    }
}

/// Writes a welded workpiece into a staged folder, which becomes an asset, complete or not at all.
///
/// # Errors
/// If a file cannot be written, or USD is required and not available.
pub fn write(
    workpiece: &Workpiece,
    options: &WeldingOptions,
    folder: StagedFolder,
    extras: Extras,
    console: &Console,
) -> Result<PathBuf> {
    let truth = &Welds::of(&workpiece.welds);
    let surface = &WeldedSurface::of(&workpiece.welded, &workpiece.target);
    let models = |density| {
        Models::of(surface, workpiece.welded.voxel, density).context("the surface of the part encloses no volume")
    };
    let models = extras.density.map(models).transpose()?;
    let (source, seed) = (&workpiece.part.source, options.seed.to_string());
    let origin =
        BTreeMap::from([("source", source.file.clone()), ("source_sha256", source.sha256.clone()), ("seed", seed)]);
    let content = Content { workpiece, truth, surface, models, origin, extras, console };
    for export in EXPORTS {
        (export.write)(&content, &folder.path().join(export.file))?;
    }
    let manifest = manifest_of(workpiece, options, folder.path())?;
    write_json(&folder.path().join(MANIFEST_FILE), &manifest)?;
    let place = folder.commit()?;
    console.step("asset", format!("{} files written", manifest.files.len() + 1));
    Ok(place)
}

fn manifest_of(workpiece: &Workpiece, options: &WeldingOptions, folder: &Path) -> Result<Manifest> {
    let welds = || workpiece.welds.iter();
    let checks = BTreeMap::from([
        ("weld_volume_mm3".to_owned(), welds().map(|placed| placed.volume * 1e9).sum()),
        ("weld_length_mm".to_owned(), welds().map(|placed| placed.weld.curve.length() * 1e3).sum()),
        ("ambiguous_share".to_owned(), workpiece.baking.ambiguous_share),
    ]);
    Ok(Manifest {
        format: ASSET_FORMAT.to_owned(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed: options.seed,
        source: workpiece.part.source.clone(),
        options: serde_json::to_value(options)?,
        cleaning: serde_json::to_value(&workpiece.part.cleaning)?,
        repairs: workpiece.part.cleaning.notes(),
        baking: workpiece.baking.clone(),
        choices: welds().flat_map(|placed| placed.weld.reasons.clone()).collect(),
        checks,
        files: record_files(folder)?,
    })
}

/// Writes a value as indented JSON.
///
/// # Errors
/// If the file cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    fs::write(path, text).with_context(|| format!("{}: cannot write this file", path.display()))
}
