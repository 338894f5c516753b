//! Index of the mesh files and their entries.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::Result;
use files::input::{self, MOST_TEXT_BYTES};
use serde::{Deserialize, Serialize};

use super::Cache;
use files::folder::write_file;

/// Name of the index in a cache.
pub const INDEX_FILE: &str = "index.jsonl";

#[derive(Serialize, Deserialize)]
struct Line {
    mesh: String,
    field: String,
}

impl Cache {
    /// Brings the index up to date: `keys` holds the meshes of this run, with `None` for those that failed.
    ///
    /// Lines of other meshes are kept as long as their field exists, so that several folders can share a cache.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub(super) fn update_index(&self, keys: &BTreeMap<String, Option<String>>) -> Result<()> {
        let _claim = self.claim_catalogue()?;
        let path = self.folder().join(INDEX_FILE);
        let mut fields = read(&path);
        fields.retain(|mesh, field| !keys.contains_key(mesh) && self.folder().join(field).is_file());
        for (mesh, key) in keys {
            if let Some(key) = key {
                fields.insert(mesh.clone(), format!("{key}.nvdb"));
            }
        }
        let mut text = String::new();
        for (mesh, field) in fields {
            text += &serde_json::to_string(&Line { mesh, field })?;
            text.push('\n');
        }
        Ok(write_file(&path, text.as_bytes())?)
    }
}

/// Reads the valid lines; damaged lines are dropped, because the entries are authoritative.
fn read(path: &Path) -> BTreeMap<String, String> {
    let text = input::read(path, MOST_TEXT_BYTES).unwrap_or_default();
    let lines = text.split(|byte| *byte == b'\n').filter_map(|line| serde_json::from_slice::<Line>(line).ok());
    lines.map(|line| (line.mesh, line.field)).collect()
}
