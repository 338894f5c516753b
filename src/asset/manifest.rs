//! `asset.json`: the source of an asset, its parameters, and the hash of every file.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use files::input::{self, MOST_MESH_BYTES, MOST_TEXT_BYTES, quoted_near};
use sdf_bake::BakeReport;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::part::{Source, sha256};
use files::json_file::parse_json;

/// Name of the manifest in an asset folder.
pub const MANIFEST_FILE: &str = "asset.json";
/// Value of the `format` key.
pub const ASSET_FORMAT: &str = "robofin-asset/1";

/// Manifest of an asset. It holds no date, machine or folder: the same input gives the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`ASSET_FORMAT`].
    pub format: String,
    /// Version of the program.
    pub version: String,
    /// Seed of every random choice.
    pub seed: u64,
    /// Source file of the part.
    pub source: Source,
    /// All options of the run.
    pub options: Value,
    /// Counts of the defects that cleaning found and repaired.
    pub cleaning: Value,
    /// Repairs of the mesh, one sentence each.
    pub repairs: Vec<String>,
    /// Voxel size, bricks, sign.
    pub baking: BakeReport,
    /// Reasons for the choices of the weld, one sentence each.
    pub choices: Vec<String>,
    /// Figures checked when the asset was made.
    pub checks: BTreeMap<String, f64>,
    /// Records of the other files of the folder, by name.
    pub files: BTreeMap<String, FileRecord>,
}

/// Identity of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileRecord {
    /// SHA-256 of the content.
    pub sha256: String,
    /// Size [bytes].
    pub bytes: u64,
}

impl FileRecord {
    /// Computes size and hash of a file.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn of(path: &Path) -> Result<Self> {
        Ok(Self::of_bytes(&input::read(path, MOST_MESH_BYTES)?))
    }

    /// Computes size and hash of a file's content.
    pub fn of_bytes(content: &[u8]) -> Self {
        Self { sha256: sha256(content), bytes: content.len() as u64 }
    }
}

/// Returns the records of all files in a folder, by name; subfolders are left out.
///
/// # Errors
/// If the folder or a file cannot be read.
pub fn record_files(folder: &Path) -> Result<BTreeMap<String, FileRecord>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).with_context(|| format!("{}: cannot be read", folder.display()))? {
        let entry = entry?;
        if entry.path().is_dir() {
            continue;
        }
        let name = entry.file_name().to_string_lossy().into_owned();
        files.insert(name, FileRecord::of(&entry.path())?);
    }
    Ok(files)
}

impl Manifest {
    /// Reads the manifest of an asset folder.
    ///
    /// # Errors
    /// If the folder is not an asset, or has another format.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join(MANIFEST_FILE);
        let text =
            input::read_text(&path, MOST_TEXT_BYTES).context("an asset folder made by `robofin weld` is expected")?;
        let manifest: Self = parse_json(&path, &text, &format!("a manifest of format {ASSET_FORMAT}"))?;
        if manifest.format != ASSET_FORMAT {
            let found = quoted_near(&manifest.format, [ASSET_FORMAT]);
            bail!("{}: format is {found}, {ASSET_FORMAT:?} is expected", path.display());
        }
        Ok(manifest)
    }
}
