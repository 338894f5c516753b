//! Checks of presence, size and hash of every file.

use std::path::Path;

use crate::asset::{Check, MANIFEST_FILE, Manifest, PREVIEW_FILE, record_files};

pub(super) fn check(folder: &Path, manifest: &Manifest) -> Vec<Check> {
    let found = match record_files(folder) {
        Ok(found) => found,
        Err(error) => return vec![Check::new(MANIFEST_FILE, "the folder can be read", false, format!("{error:#}"))],
    };
    let mut checks: Vec<Check> = manifest
        .files
        .iter()
        .map(|(name, record)| {
            let rule = "has the size and hash that the manifest says";
            match found.get(name) {
                None => Check::new(name, rule, false, "the file is missing"),
                Some(now) if now == record => Check::new(name, rule, true, format!("{} bytes", now.bytes)),
                Some(now) => {
                    let found = format!(
                        "{} bytes, sha256 {}; {} and {} expected",
                        now.bytes, now.sha256, record.bytes, record.sha256
                    );
                    Check::new(name, rule, false, found)
                }
            }
        })
        .collect();
    for name in found.keys().filter(|name| *name != MANIFEST_FILE && !manifest.files.contains_key(*name)) {
        checks.push(Check::new(name, "is listed in the manifest", false, "a file that the manifest does not know"));
    }
    checks.extend(check_folders(folder));
    checks.push(check_picture(folder));
    checks
}

/// Checks that an asset has no subfolders.
fn check_folders(folder: &Path) -> Vec<Check> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names.iter().map(|name| Check::new(name, "is listed in the manifest", false, "a folder inside the asset")).collect()
}

fn check_picture(folder: &Path) -> Check {
    match image::open(folder.join(PREVIEW_FILE)) {
        Ok(picture) => {
            Check::new(PREVIEW_FILE, "is a picture", true, format!("{} x {}", picture.width(), picture.height()))
        }
        Err(error) => Check::new(PREVIEW_FILE, "is a picture", false, error.to_string()),
    }
}
