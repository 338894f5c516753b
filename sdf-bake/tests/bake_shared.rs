//! The closed meshes of the shared folder: exact distance and no wrong sign.

#[path = "common/field.rs"]
mod field;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use field::{band_points, summed_winding_number};
use glam::DVec3;
use rayon::prelude::*;
use sdf_bake::clean::clean;
use sdf_bake::query::MeshQuery;
use sdf_bake::read::{UnitChoice, read_mesh};
use sdf_bake::{BakeOptions, Mesh, SignChoice, bake};

const RESOLUTION: f64 = 96.0;

/// Number of voxels per mesh whose sign is compared with the sum over all triangles.
const SIGNS: usize = 160;

/// Number of voxels per mesh whose distance is compared with the closest point.
const DISTANCES: usize = 4000;

/// Distance from the surface below which either sign is correct [voxels].
const ON_SURFACE: f64 = 1e-4;

/// The shared meshes in the order of their names; without the folder, prints what is not tested.
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

/// Number of balls within the union that are searched for a point outside, and of directions for each.
const BALLS: usize = 24;

struct Findings {
    wrong_signs: usize,
    /// Largest error of the distance [voxels].
    error: f64,
    inner_triangles: usize,
    /// Number of points outside within balls that are entirely inside according to φ.
    holes_in_balls: usize,
}

fn check(mesh: &Mesh) -> Findings {
    let (low, high) = mesh.bounds().unwrap();
    let voxel = (high - low).max_element() / RESOLUTION;
    let (grid, report) = bake(mesh, &BakeOptions::with_voxel(voxel)).unwrap();
    let united = report.inner_triangles > 0;
    let points = band_points(&grid, 1);
    let sample = |count: usize| points.par_iter().step_by((points.len() / count).max(1));
    let query = MeshQuery::new(mesh);
    let error = |(point, phi): &(DVec3, f64)| {
        let error = (query.closest(*point).distance - phi.abs()) / voxel;
        // The surface of a union is at least as far as the nearest triangle, which may be a wall inside it.
        if united && *phi < 0.0 { error.max(0.0) } else { error.abs() }
    };
    let is_wrong = |(point, phi): &&(DVec3, f64)| {
        phi.abs() > ON_SURFACE * voxel && (summed_winding_number(mesh, *point) > 0.5) != (*phi < 0.0)
    };
    let beyond_a_wall = |(point, phi): &&(DVec3, f64)| *phi < -(query.closest(*point).distance + 0.01 * voxel);
    let balls: Vec<(DVec3, f64)> = sample(if united { DISTANCES } else { 1 }).filter(beyond_a_wall).copied().collect();
    let outside_in_ball = |(point, phi): &(DVec3, f64)| {
        let is_outside =
            |direction: &DVec3| summed_winding_number(mesh, *point + direction.normalize() * (0.999 * phi.abs())) < 0.5;
        DIRECTIONS.iter().filter(|direction| is_outside(direction)).count()
    };
    let searched = balls.par_iter().step_by((balls.len() / BALLS).max(1));
    Findings {
        wrong_signs: sample(SIGNS).filter(is_wrong).count(),
        error: sample(DISTANCES).map(error).reduce(|| 0.0, f64::max),
        inner_triangles: report.inner_triangles,
        holes_in_balls: searched.map(outside_in_ball).sum(),
    }
}

const DIRECTIONS: [DVec3; 8] = [
    DVec3::X,
    DVec3::NEG_X,
    DVec3::Y,
    DVec3::NEG_Y,
    DVec3::Z,
    DVec3::NEG_Z,
    DVec3::new(1.0, -2.0, 3.0),
    DVec3::new(-3.0, 2.0, -1.0),
];

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
        let Findings { wrong_signs, error, inner_triangles, holes_in_balls } = check(&mesh);
        println!("{name:75} {wrong_signs} wrong signs, {error:.1e} voxels off, {inner_triangles} triangles within");
        assert_eq!(wrong_signs, 0, "wrong signs on {name}");
        assert!(error < 2e-5, "{name} is {error} voxels off");
        assert_eq!(holes_in_balls, 0, "{name} has outside points nearer than φ says");
    }
    assert!(paths.is_empty() || closed >= 17, "only {closed} of {} meshes were closed", paths.len());
}

#[test]
fn open_shared_meshes_have_a_closed_surface_with_the_volume_of_their_field() {
    let paths = shared_meshes();
    let mut open = 0;
    for path in &paths {
        let (mesh, report) = clean(read_mesh(path, UnitChoice::Auto).unwrap().mesh).unwrap();
        if report.closed {
            continue;
        }
        open += 1;
        let (low, high) = mesh.bounds().unwrap();
        let voxel = (high - low).max_element() / 128.0;
        let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(voxel) };
        let grid = bake(&mesh, &options).unwrap().0;
        let surface = grid.surface_mesh();
        let mut balance: HashMap<[u32; 2], i32> = HashMap::new();
        for &[a, b, c] in &surface.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                *balance.entry([from.min(to), from.max(to)]).or_default() += if from < to { 1 } else { -1 };
            }
        }
        let unbalanced = balance.values().filter(|balance| **balance != 0).count();
        let apart = (surface.volume() - grid.volume()) / (surface.area() * voxel);
        let name = path.file_name().unwrap().to_string_lossy();
        println!("{name:75} {} triangles, volume {apart:+.4} voxels over the area", surface.triangles.len());
        assert_eq!(unbalanced, 0, "{name}");
        assert!(apart.abs() < 0.1, "{name}: {apart}");
    }
    assert!(paths.is_empty() || open > 0, "no mesh is open");
}
