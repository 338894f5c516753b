//! Identity of the measurements behind a result, by the hashes of their files.

use std::path::Path;

use files::input::{self, MOST_MESH_BYTES};
use files::output::holds_results;
use files::sha256;
use walkdir::{DirEntry, WalkDir};

use crate::{Digest, Provenance};
use lab::Result;

/// SHA-256 over the hashes of all files of a folder without the results below it; equal if the measurements are the
/// same.
///
/// # Errors
/// If a file cannot be read.
pub fn inputs_sha256(folder: &Path) -> Result<String> {
    let inputs = provenance(folder, 0)?.inputs;
    let lines: String = inputs.iter().map(|input| format!("{} {}\n", input.sha256, input.file)).collect();
    Ok(sha256(lines.as_bytes()))
}

/// Hashes of all files of a folder without the results below it, and the program that made the report.
pub(super) fn provenance(folder: &Path, seed: u64) -> Result<Provenance> {
    let measures = |entry: &DirEntry| entry.depth() == 0 || !entry.file_type().is_dir() || !holds_results(entry.path());
    let entries = WalkDir::new(folder).sort_by_file_name().into_iter().filter_entry(measures);
    let mut files: Vec<DirEntry> = entries.collect::<Result<_, _>>()?;
    files.retain(|entry| entry.file_type().is_file());
    let digest = |entry: &DirEntry| -> Result<Digest> {
        let sha256 = sha256(&input::read(entry.path(), MOST_MESH_BYTES)?);
        let file = entry.path().strip_prefix(folder).unwrap_or(entry.path()).display().to_string();
        Ok(Digest { file, sha256 })
    };
    Ok(Provenance {
        inputs: files.iter().map(digest).collect::<Result<_>>()?,
        seed,
        versions: vec![("robofin".to_owned(), env!("CARGO_PKG_VERSION").to_owned())],
        ..Provenance::default()
    })
}
