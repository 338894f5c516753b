//! The crates and their dependencies, as stated in `ARCHITECTURE.md`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;
use walkdir::WalkDir;

/// Folder of each crate, with the crates of the workspace that it may use.
const MAY_USE: [(&str, &[&str]); 25] = [
    ("shaders", &[]),
    ("random", &[]),
    ("files", &[]),
    ("criteria", &[]),
    ("effects", &["files"]),
    ("sdf-bake", &["files"]),
    ("robot", &["sdf-bake"]),
    ("weldgen", &["sdf-bake"]),
    ("sim", &["effects", "robot", "sdf-bake", "shaders"]),
    ("render", &["sdf-bake", "shaders"]),
    ("export", &["sdf-bake"]),
    ("instruments", &["files", "sdf-bake"]),
    ("trials", &["effects", "files", "instruments", "random", "robot", "sdf-bake"]),
    ("paths", &["instruments", "robot", "sdf-bake", "sim", "trials"]),
    ("perception", &["effects", "export", "paths", "random", "render", "robot", "sdf-bake", "sim"]),
    ("environments", &["effects", "random", "render", "robot", "sdf-bake", "sim"]),
    ("trial-simulation", &["effects", "robot", "sdf-bake", "shaders", "sim", "trials"]),
    ("lab", &["criteria", "effects", "files", "random", "robot", "sdf-bake", "sim", "trial-simulation", "trials"]),
    ("experiments", &["effects", "lab", "robot", "sdf-bake", "trial-simulation", "trials"]),
    ("study", &["effects", "experiments", "files", "lab", "random", "robot", "sdf-bake", "sim", "trials"]),
    ("virtual-lab", &["effects", "files", "random", "robot", "sdf-bake", "sim", "trials"]),
    ("benchmark", &["effects", "files", "lab", "random", "study", "trials", "virtual-lab"]),
    ("report", &["lab", "robot", "sdf-bake", "study", "trials"]),
    (
        "workbench",
        &[
            "effects",
            "files",
            "lab",
            "render",
            "report",
            "sdf-bake",
            "shaders",
            "study",
            "trial-simulation",
            "trials",
            "weldgen",
        ],
    ),
    (
        "",
        &[
            "benchmark",
            "effects",
            "export",
            "files",
            "instruments",
            "lab",
            "paths",
            "perception",
            "random",
            "render",
            "report",
            "robot",
            "sdf-bake",
            "shaders",
            "sim",
            "study",
            "trial-simulation",
            "trials",
            "virtual-lab",
            "weldgen",
            "workbench",
        ],
    ),
];
/// Packages for the command line, which only the main crate may use.
const OF_THE_PROGRAM: [&str; 3] = ["anyhow", "clap", "indicatif"];
/// Greatest number of lines of product code in a crate.
const MOST_LINES: usize = 15_000;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the packages of the workspace by folder.
fn packages() -> BTreeMap<String, Value> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let answer = Command::new(cargo)
        .args(["metadata", "--no-deps", "--offline", "--format-version", "1"])
        .current_dir(root())
        .output()
        .expect("cargo runs");
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let metadata: Value = serde_json::from_slice(&answer.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    packages.iter().map(|package| (folder_of(&package["manifest_path"]), package.clone())).collect()
}

/// Returns the folder of a manifest below the root; empty for the root's own.
fn folder_of(manifest: &Value) -> String {
    let manifest = PathBuf::from(manifest.as_str().expect("a path"));
    let folder = manifest.parent().expect("a folder");
    folder.strip_prefix(root()).expect("a folder below the root").display().to_string()
}

/// Returns the build dependencies of a package: by folder in the workspace, by name otherwise.
fn dependencies(package: &Value) -> BTreeSet<String> {
    let all = package["dependencies"].as_array().expect("dependencies");
    let product = all.iter().filter(|dependency| dependency["kind"].is_null());
    let name = |dependency: &Value| match dependency["path"].as_str() {
        Some(path) => Path::new(path).strip_prefix(root()).expect("a folder below the root").display().to_string(),
        None => dependency["name"].as_str().expect("a name").to_owned(),
    };
    product.map(name).collect()
}

#[test]
fn crates_use_only_what_they_may() {
    let packages = packages();
    assert_eq!(packages.len(), MAY_USE.len(), "a crate without a place in this list");
    for (folder, allowed) in MAY_USE {
        let own = packages.keys().cloned().collect::<BTreeSet<_>>();
        let used = dependencies(&packages[folder]);
        let inside: Vec<&String> = used.iter().filter(|name| own.contains(*name)).collect();
        let wrong: Vec<_> = inside.iter().filter(|name| !allowed.contains(&name.as_str())).collect();
        assert!(wrong.is_empty(), "{folder:?} uses {wrong:?}");
        let unused: Vec<_> = allowed.iter().filter(|name| !used.contains(**name)).collect();
        assert!(unused.is_empty(), "{folder:?} may use {unused:?} but does not");
    }
}

#[test]
fn the_architecture_page_states_the_same_arrows() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).expect("ARCHITECTURE.md");
    let packages = packages();
    let cell = |row: &str, column: usize| row.split('|').nth(column).expect("five columns").trim().to_owned();
    let rows: Vec<&str> = page.lines().filter(|line| line.starts_with("| `")).collect();
    assert_eq!(rows.len(), MAY_USE.len(), "ARCHITECTURE.md has another number of crates");
    for (row, (folder, allowed)) in rows.into_iter().zip(MAY_USE) {
        let shown = if folder.is_empty() { "src" } else { folder };
        assert_eq!(cell(row, 1), format!("`{shown}/`"));
        assert_eq!(cell(row, 2), format!("`{}`", packages[folder]["name"].as_str().expect("a name")));
        assert_eq!(cell(row, 4), allowed.join(", "), "{shown}/ in ARCHITECTURE.md");
    }
}

#[test]
fn arrows_run_one_way() {
    for (at, (folder, allowed)) in MAY_USE.iter().enumerate() {
        for name in *allowed {
            let below = MAY_USE[..at].iter().any(|(lower, _)| lower == name);
            assert!(below, "{folder:?} uses {name:?}, which does not stand below it");
        }
    }
}

#[test]
fn every_crate_is_described() {
    for (folder, package) in packages() {
        for key in ["description", "license", "readme"] {
            assert!(package[key].as_str().is_some_and(|text| !text.is_empty()), "{folder:?} has no {key}");
        }
        for key in ["keywords", "categories"] {
            let words = package[key].as_array().map_or(0, Vec::len);
            assert!((1..=5).contains(&words), "{folder:?} has {words} {key}; 1 to 5 are accepted");
        }
    }
}

#[test]
fn only_the_program_knows_the_command_line() {
    for (folder, package) in packages().iter().filter(|(folder, _)| !folder.is_empty()) {
        let used = dependencies(package);
        let wrong: Vec<_> = OF_THE_PROGRAM.iter().filter(|name| used.contains(**name)).collect();
        assert!(wrong.is_empty(), "{folder} uses {wrong:?}");
    }
}

#[test]
fn no_crate_is_too_large_to_know() {
    for (folder, _) in MAY_USE {
        let files = WalkDir::new(root().join(folder).join("src")).into_iter().map(|entry| entry.expect("a folder"));
        let rust = files.filter(|file| file.path().extension().is_some_and(|ending| ending == "rs"));
        let lines: usize = rust.map(|file| product_lines(file.path())).sum();
        assert!(lines > 0, "{folder:?} is empty");
        assert!(lines <= MOST_LINES, "{folder:?} has {lines} lines of product code, and {MOST_LINES} are accepted");
    }
}

/// Counts the lines of a source file above its tests.
fn product_lines(file: &Path) -> usize {
    let is_test = file.components().any(|part| part.as_os_str() == "tests") || file.ends_with("tests.rs");
    let text = std::fs::read_to_string(file).expect("a source file");
    if is_test { 0 } else { text.lines().take_while(|line| *line != "#[cfg(test)]").count() }
}
