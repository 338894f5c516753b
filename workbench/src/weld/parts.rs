//! Mesh files of a folder.

use std::fs;
use std::path::{Path, PathBuf};

use files::sha256;

use crate::place::{DEEPEST, ID_DIGITS, Kind, MOST_FOLDERS, folders};

/// Endings of mesh files.
const ENDINGS: [&str; 5] = ["obj", "stl", "ply", "glb", "gltf"];
/// Greatest number of parts that are listed.
const MOST_PARTS: usize = 2000;

/// A mesh file that can be welded.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PartFile {
    /// Id in addresses.
    pub(crate) id: String,
    /// Path relative to the served folder.
    pub(crate) name: String,
    /// Path of the file.
    pub(crate) path: PathBuf,
    /// True for the part of the program.
    pub(crate) is_bundled: bool,
}

impl PartFile {
    fn new(root: &Path, path: &Path) -> Self {
        let name = path.strip_prefix(root).unwrap_or(path).display().to_string();
        let id = sha256(path.as_os_str().as_encoded_bytes())[..ID_DIGITS].to_owned();
        Self { id, name, path: path.to_owned(), is_bundled: false }
    }

    /// Returns the part of the program, which has a file at `path` once it is opened.
    pub(super) fn bundled(path: &Path) -> Self {
        Self { id: "bundled".into(), name: "the bundled bracket".into(), path: path.to_owned(), is_bundled: true }
    }

    /// Returns the name of an asset of this part: its stem in letters, digits and hyphens.
    pub(crate) fn stem(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let plain: String = stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).take(40).collect();
        let plain = plain.trim_matches('-');
        if plain.is_empty() { "part".to_owned() } else { plain.to_owned() }
    }
}

/// Lists the mesh files below a folder by name, without those of assets and data sets. The second value is true if the
/// list is incomplete.
pub(crate) fn parts(root: &Path) -> (Vec<PartFile>, bool) {
    let (mut found, mut left, mut seen) = (Vec::new(), vec![(root.to_owned(), 0)], 0);
    while let Some((folder, depth)) = left.pop() {
        seen += 1;
        if seen > MOST_FOLDERS || found.len() > MOST_PARTS {
            break;
        }
        if matches!(Kind::of(&folder), Some(Kind::Asset | Kind::DataSet)) {
            continue;
        }
        found.extend(meshes(&folder).iter().map(|path| PartFile::new(root, path)));
        if depth < DEEPEST {
            left.extend(folders(&folder).into_iter().map(|below| (below, depth + 1)));
        }
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    let is_cut = seen > MOST_FOLDERS || found.len() > MOST_PARTS;
    found.truncate(MOST_PARTS);
    (found, is_cut)
}

/// Lists the visible mesh files of a folder, without links; empty if the folder cannot be read.
fn meshes(folder: &Path) -> Vec<PathBuf> {
    let is_mesh = |path: &Path| {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str()))
    };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let shown = own.filter(|entry| !entry.file_name().to_string_lossy().starts_with('.'));
    shown.map(|entry| entry.path()).filter(|path| is_mesh(path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_listed_and_those_of_assets_are_not() {
        let root = tempfile::tempdir().unwrap();
        for file in ["a.STL", "it's <b>.obj", "deep/er/c.ply", "asset/asset.json", "asset/welded.glb", ".hidden.obj"] {
            let path = root.path().join(file);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        let (found, is_cut) = parts(root.path());
        let names: Vec<&str> = found.iter().map(|part| part.name.as_str()).collect();
        assert!(!is_cut);
        assert_eq!(names, ["a.STL", "deep/er/c.ply", "it's <b>.obj"]);
        assert_eq!(found[2].stem(), "it-s--b");
    }
}
