//! The closed meshes of the shared folder: exact distance and no wrong sign.

#[path = "common/field.rs"]
mod field;

use std::path::{Path, PathBuf};

use field::{band_points, summed_winding_number};
use rayon::prelude::*;
use sdf_bake::clean::clean;
use sdf_bake::query::MeshQuery;
use sdf_bake::read::{UnitChoice, read_mesh};
use sdf_bake::{BakeOptions, Mesh, bake};

const RESOLUTION: f64 = 96.0;

/// Voxels whose sign is held against the sum over all triangles, for each mesh.
const SIGNS: usize = 160;

/// Voxels whose distance is held against the closest point, for each mesh.
const DISTANCES: usize = 4000;

/// Closer to the surface than this [voxels], either sign is right.
const ON_SURFACE: f64 = 1e-4;

/// The shared meshes in the order of their names; without the folder, says loudly what is not tested.
fn shared_meshes() -> Vec<PathBuf> {
    let root = match std::env::var_os("ROBOFIN_SHARED") {
        Some(root) => PathBuf::from(root),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
    };
    let folder = root.join("data/abc");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        let missing = format!("{} is missing; set ROBOFIN_SHARED to the shared folder", folder.display());
        assert!(std::env::var_os("ROBOFIN_REQUIRE_SHARED").is_none_or(|value| value != "1"), "{missing}");
        eprintln!("NOT TESTED: baking the shared meshes. {missing}.");
        return Vec::new();
    };
    let is_mesh = |path: &PathBuf| {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        extension.is_some_and(|e| ["obj", "stl", "ply"].contains(&e.as_str()))
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).filter(is_mesh).collect();
    paths.sort();
    paths
}

/// Wrong signs and the largest error of the distance [voxels].
fn check(mesh: &Mesh) -> (usize, f64) {
    let (low, high) = mesh.bounds().unwrap();
    let voxel = (high - low).max_element() / RESOLUTION;
    let (grid, _) = bake(mesh, &BakeOptions::with_voxel(voxel)).unwrap();
    let points = band_points(&grid, 1);
    let sample = |count: usize| points.par_iter().step_by((points.len() / count).max(1));
    let query = MeshQuery::new(mesh);
    let error = |(point, phi): &(glam::DVec3, f64)| (query.closest(*point).distance - phi.abs()).abs() / voxel;
    let is_wrong = |(point, phi): &&(glam::DVec3, f64)| {
        phi.abs() > ON_SURFACE * voxel && (summed_winding_number(mesh, *point) > 0.5) != (*phi < 0.0)
    };
    (sample(SIGNS).filter(is_wrong).count(), sample(DISTANCES).map(error).reduce(|| 0.0, f64::max))
}

#[test]
fn closed_shared_meshes_bake_exactly_and_without_a_wrong_sign() {
    let paths = shared_meshes();
    let mut closed = 0;
    for path in &paths {
        let read = read_mesh(path, UnitChoice::Auto).unwrap();
        let (mesh, report) = clean(read.mesh).unwrap();
        let name = path.file_name().unwrap().to_string_lossy();
        if !(report.closed && report.consistently_oriented) {
            println!("{name:75} is open or inconsistent: not judged here");
            continue;
        }
        closed += 1;
        let (wrong, error) = check(&mesh);
        println!("{name:75} {wrong} wrong signs, {error:.1e} voxels off at most");
        assert_eq!(wrong, 0, "wrong signs on {name}");
        assert!(error < 2e-5, "{name} is {error} voxels off");
    }
    assert!(paths.is_empty() || closed >= 17, "only {closed} of {} meshes were closed", paths.len());
}
