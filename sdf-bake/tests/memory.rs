//! Memory of a field besides its bricks: small, even for few bricks in a large box.

use std::path::{Path, PathBuf};

use glam::{DVec3, IVec3};
use sdf_bake::clean::clean;
use sdf_bake::grid::BRICK_VOXELS;
use sdf_bake::nvdb::{Codec, read, write_field};
use sdf_bake::read::{UnitChoice, read_mesh};
use sdf_bake::{BakeOptions, BrickGrid, Mesh, SignChoice, bake};

/// Bytes of a grid divided by those of its bricks' φ.
fn ratio(grid: &BrickGrid) -> f64 {
    grid.bytes() as f64 / (size_of::<f32>() * BRICK_VOXELS * grid.brick_count()) as f64
}

/// Adds a wire of six sides between two points [m].
fn add_wire(mesh: &mut Mesh, from: DVec3, to: DVec3, diameter: f64) {
    let (u, v) = (to - from).normalize().any_orthonormal_pair();
    let first = mesh.positions.len() as u32;
    for end in [from, to] {
        mesh.positions.extend((0..6).map(|i| {
            let (sine, cosine) = (std::f64::consts::FRAC_PI_3 * f64::from(i)).sin_cos();
            end + 0.5 * diameter * (cosine * u + sine * v)
        }));
    }
    let at = |end: u32, i: u32| first + 6 * end + i % 6;
    for i in 0..6 {
        mesh.triangles.extend([[at(0, i), at(0, i + 1), at(1, i + 1)], [at(0, i), at(1, i + 1), at(1, i)]]);
    }
    for i in 1..5 {
        mesh.triangles.extend([[at(0, 0), at(0, i + 1), at(0, i)], [at(1, 0), at(1, i), at(1, i + 1)]]);
    }
}

fn corner(i: u32) -> DVec3 {
    DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 0.1
}

/// One wire from corner to corner of a box.
fn diagonal(diameter: f64) -> Mesh {
    let mut mesh = Mesh::default();
    add_wire(&mut mesh, corner(0), corner(7), diameter);
    mesh
}

/// The diagonals of a box and of its faces.
fn frame(diameter: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for (from, to) in [(0, 7), (1, 6), (2, 5), (3, 4), (0, 3), (0, 5), (0, 6), (3, 5), (3, 6), (5, 6)] {
        add_wire(&mut mesh, corner(from), corner(to), diameter);
    }
    mesh
}

#[test]
fn the_index_of_a_thin_wire_takes_less_than_its_bricks() {
    // Ratios of the box's length to a wire's diameter, and to a voxel.
    for (diameter, resolution) in [(50.0, 256.0), (200.0, 1024.0), (500.0, 1024.0), (1000.0, 2048.0)] {
        for (name, mesh) in [("wire", diagonal(0.1 / diameter)), ("frame", frame(0.1 / diameter))] {
            let grid = bake(&mesh, &BakeOptions::with_voxel(0.1 / resolution)).unwrap().0;
            let ratio = ratio(&grid);
            println!("{name} of 1/{diameter} at {resolution}: {} bricks, {ratio:.3}", grid.brick_count());
            assert!(ratio <= 2.0, "{name} of 1/{diameter} at {resolution}: {ratio}");
        }
    }
}

#[test]
fn a_thin_wire_comes_back_from_a_file() {
    let grid = bake(&diagonal(1e-4), &BakeOptions::with_voxel(0.1 / 2048.0)).unwrap().0;
    let back = read(&write_field(&grid, Codec::None).unwrap()).unwrap().grids[0].to_bricks().unwrap();
    let slots = |of: &BrickGrid| grid.bricks.iter().map(|&brick| of.slot(brick + IVec3::X)).collect::<Vec<u32>>();
    assert_eq!((&back.bricks, &back.phi, slots(&back)), (&grid.bricks, &grid.phi, slots(&grid)));
}

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
        eprintln!("NOT TESTED: memory of the shared meshes. {missing}.");
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

#[test]
fn fields_of_the_shared_meshes_take_little_more_than_their_bricks() {
    for path in shared_meshes() {
        let mesh = clean(read_mesh(&path, UnitChoice::Auto).unwrap().mesh).unwrap().0;
        let (low, high) = mesh.bounds().unwrap();
        let voxel = (high - low).max_element() / 256.0;
        let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(voxel) };
        let grid = bake(&mesh, &options).unwrap().0;
        let (name, ratio) = (path.file_name().unwrap().to_string_lossy(), ratio(&grid));
        println!("{name:75} {} bricks, {ratio:.3}", grid.brick_count());
        assert!(ratio <= 2.0, "{name}: {ratio}");
    }
}
