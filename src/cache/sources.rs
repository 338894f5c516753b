//! Search for mesh files.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use anyhow::Result;
use walkdir::{DirEntry, WalkDir};

use crate::wrong_use;

/// Extensions of mesh files, in lower case.
const EXTENSIONS: [&str; 5] = ["obj", "stl", "ply", "glb", "gltf"];

/// Mesh files to bake: each path once, sorted, with the reason where a place could not be searched.
pub type Sources = BTreeMap<PathBuf, Option<String>>;

/// Finds the mesh files named, and those below the folders named; hidden ones are left out, links are followed.
///
/// A file that is named directly is accepted with any extension.
///
/// # Errors
/// Wrong use if a path does not exist, or a folder holds no mesh file.
pub fn find_meshes(places: &[PathBuf]) -> Result<Sources> {
    let mut sources = Sources::new();
    for place in places {
        let place = tidy(place);
        if place.is_dir() {
            let found = below(&place);
            if found.is_empty() {
                let endings = EXTENSIONS.map(|extension| format!(".{extension}")).join(", ");
                return Err(wrong_use(format!(
                    "{} is a folder without a mesh file (OBJ, STL, PLY, GLB or glTF); {endings} are looked for below it",
                    place.display()
                )));
            }
            sources.extend(found);
        } else if place.exists() {
            sources.insert(place, None);
        } else {
            return Err(wrong_use(format!("{}: no such file or folder", place.display())));
        }
    }
    Ok(sources)
}

/// Removes `./` from a path, so that an index names a file in one way.
fn tidy(place: &Path) -> PathBuf {
    let parts: PathBuf = place.components().filter(|part| *part != Component::CurDir).collect();
    if parts.as_os_str().is_empty() { PathBuf::from(".") } else { parts }
}

fn below(folder: &Path) -> Sources {
    let is_shown = |entry: &DirEntry| entry.depth() == 0 || !entry.file_name().to_string_lossy().starts_with('.');
    let mut sources = Sources::new();
    for entry in WalkDir::new(folder).follow_links(true).into_iter().filter_entry(is_shown) {
        match entry {
            Ok(entry) if entry.file_type().is_file() && is_mesh(entry.path()) => {
                sources.insert(entry.into_path(), None);
            }
            Ok(_) => {}
            Err(error) => {
                let place = error.path().unwrap_or(folder).to_owned();
                sources.insert(place, Some(format!("cannot be searched: {error}")));
            }
        }
    }
    sources
}

fn is_mesh(path: &Path) -> bool {
    let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| EXTENSIONS.contains(&extension.as_str()))
}
