//! A small data set of plates, and functions that inspect it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::program::{robofin, run};

/// Number of items in the small data set: two of each of three plates.
pub(crate) const ITEMS: usize = 6;

/// Returns a plate in millimetres as OBJ; each number gives a different one.
pub(crate) fn plate(number: usize) -> String {
    let size = [80.0 + 10.0 * number as f64, 60.0, 8.0 + number as f64];
    let corner = |i: usize| {
        format!("v {} {} {}\n", size[0] * (i & 1) as f64, size[1] * (i >> 1 & 1) as f64, size[2] * (i >> 2) as f64)
    };
    let quads = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];
    let faces = quads.iter().map(|[a, b, c, d]| format!("f {a} {b} {c}\nf {a} {c} {d}\n"));
    (0..8).map(corner).chain(faces).collect()
}

/// Writes a folder of three plates, one of them in a subfolder.
pub(crate) fn plates(place: &Path) -> PathBuf {
    let parts = place.join("parts");
    fs::create_dir_all(parts.join("below")).expect("a folder");
    for (number, name) in ["a.obj", "b.obj", "below/c.obj"].iter().enumerate() {
        fs::write(parts.join(name), plate(number)).expect("a part");
    }
    parts
}

/// Returns `robofin dataset` with coarse voxels and two items of each part.
pub(crate) fn dataset(parts: &Path, out: &Path) -> Command {
    let mut command = robofin(["dataset", "--per-part", "2", "--seed", "7", "--diagonal", "48"]);
    command.arg(parts).arg("--out").arg(out);
    command
}

/// Returns the plates and their data set made in one run; tests must not change them.
pub(crate) fn undisturbed() -> (&'static Path, &'static Path) {
    static PLACE: LazyLock<(TempDir, PathBuf, PathBuf)> = LazyLock::new(|| {
        let place = tempfile::tempdir().expect("a temporary folder");
        let (parts, out) = (plates(place.path()), place.path().join("set"));
        run(dataset(&parts, &out).args(["--jobs", "2"])).succeeds();
        (place, parts, out)
    });
    (&PLACE.1, &PLACE.2)
}

/// Copies the undisturbed set to a folder of its own, where a test may damage it.
pub(crate) fn copy_of_set(place: &Path) -> PathBuf {
    let out = place.join("set");
    for (name, content) in tree(undisturbed().1) {
        let path = out.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("it can be made");
        fs::write(path, content).expect("a copied file");
    }
    fs::create_dir_all(out.join("failures")).expect("it can be made");
    out
}

/// Reads all files below a folder by path, hidden ones included.
pub(crate) fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("the folder can be read") {
        let path = entry.expect("an entry").path();
        let name = PathBuf::from(path.file_name().expect("a name"));
        if path.is_dir() {
            files.extend(tree(&path).into_iter().map(|(below, content)| (name.join(below), content)));
        } else {
            files.insert(name, fs::read(path).expect("a file"));
        }
    }
    files
}

/// Asserts that two sets have the same files with the same bytes.
#[track_caller]
pub(crate) fn assert_same(one: &Path, two: &Path) {
    let (one, two) = (tree(one), tree(two));
    assert!(one.keys().eq(two.keys()), "{:?}\nand\n{:?}", one.keys(), two.keys());
    let differing: Vec<&PathBuf> =
        one.iter().filter(|(name, bytes)| two[*name] != **bytes).map(|(name, _)| name).collect();
    assert!(differing.is_empty(), "{differing:?} differ");
}

/// Reads the lines of a `.jsonl` file.
pub(crate) fn lines(path: &Path) -> Vec<Value> {
    let text = fs::read_to_string(path).expect("the file can be read");
    text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

/// Lists the folders of the items, sorted.
pub(crate) fn items(set: &Path) -> Vec<PathBuf> {
    let names = crate::program::names(&set.join("assets"));
    names.iter().map(|name| set.join("assets").join(name)).collect()
}
