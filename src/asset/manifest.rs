//! `asset.json`: what an asset was made from, with what parameters, and the hash of every file.

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

/// The manifest of an asset. It holds no date, machine or folder: the same input gives the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// [`ASSET_FORMAT`].
    pub format: String,
    /// Version of the program.
    pub version: String,
    /// Seed of every random choice.
    pub seed: u64,
    /// The file the part came from.
    pub source: Source,
    /// All options of the run.
    pub options: Value,
    /// What cleaning found and changed.
    pub cleaning: Value,
    /// What cleaning found and changed, in sentences.
    pub repairs: Vec<String>,
    /// Voxel size, bricks, sign.
    pub baking: BakeReport,
    /// Why the weld is as it is, one sentence each.
    pub choices: Vec<String>,
    /// Figures checked when the asset was made.
    pub checks: BTreeMap<String, f64>,
    /// Files of the folder by name, without this one.
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
    /// Hashes a file.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn of(path: &Path) -> Result<Self> {
        Ok(Self::of_bytes(&input::read(path, MOST_MESH_BYTES)?))
    }

    /// Hashes the content of a file.
    pub fn of_bytes(content: &[u8]) -> Self {
        Self { sha256: sha256(content), bytes: content.len() as u64 }
    }
}

/// Records of all files in a folder, by name; folders in it are left out.
///
/// # Errors
/// When the folder or a file cannot be read.
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
    /// When the folder is no asset, or of another format.
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
