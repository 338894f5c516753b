//! Compares distance and sign in the band with f64 brute force, summed solid angles and parry3d.

#[path = "common/field.rs"]
mod field;
#[path = "common/noise.rs"]
mod noise;
#[path = "common/parts.rs"]
mod parts;

use field::{band_points, summed_winding_number};
use glam::DVec3;
use noise::noise;
use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};
use sdf_bake::clean::clean;
use sdf_bake::query::MeshQuery;
use sdf_bake::{BakeOptions, BrickGrid, Mesh, SignChoice, bake};

fn bake_at(mesh: &Mesh, resolution: f64) -> BrickGrid {
    let (low, high) = mesh.bounds().unwrap();
    let voxel = (high - low).max_element() / resolution;
    let (grid, report) = bake(mesh, &BakeOptions::with_voxel(voxel)).unwrap();
    assert_eq!((report.boundary_edges, report.ambiguous_share), (0, 0.0));
    grid
}

/// Greatest error of |φ| [voxels] over every `step`-th voxel of the band.
fn worst_distance(mesh: &Mesh, grid: &BrickGrid, step: usize) -> f64 {
    let query = MeshQuery::new(mesh);
    let error = |(point, phi): (glam::DVec3, f64)| (query.closest(point).distance - phi.abs()).abs() / grid.voxel;
    band_points(grid, step).into_iter().map(error).fold(0.0, f64::max)
}

#[test]
fn a_gear_has_its_exact_distance() {
    let mesh = parts::gear(480, 10);
    let worst = worst_distance(&mesh, &bake_at(&mesh, 128.0), 5);
    println!("gear: {worst:.1e} voxels off at most");
    assert!(worst < 2e-5, "{worst} voxels");
}

#[test]
fn slivers_have_their_exact_distance() {
    let mesh = parts::sliver_plate(4000);
    let worst = worst_distance(&mesh, &bake_at(&mesh, 256.0), 41);
    println!("slivers: {worst:.1e} voxels off at most");
    assert!(worst < 2e-5, "{worst} voxels");
}

/// Gives each face its own vertices, moved by up to 1e-5 of the size on each axis.
fn as_soup(mesh: &Mesh) -> Mesh {
    let reach = 1e-5 * mesh.diagonal();
    let jitter = |i: usize| reach * (2.0 * noise(i as u64) - 1.0);
    let corners = (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).enumerate();
    let positions: Vec<DVec3> =
        corners.map(|(i, p)| p + DVec3::new(jitter(3 * i), jitter(3 * i + 1), jitter(3 * i + 2))).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh { positions, triangles }
}

#[test]
fn a_soup_has_its_exact_distance_after_cleaning_too() {
    let soup = as_soup(&parts::gear(480, 10));
    let voxel = 0.08 / 128.0;
    let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(voxel) };
    let (cleaned, report) = clean(soup.clone()).unwrap();
    assert_eq!((report.merged_near, report.boundary_edges), (0, 3 * soup.triangles.len()));
    for (name, mesh) in [("as it is", &soup), ("cleaned", &cleaned)] {
        let grid = bake(mesh, &options).unwrap().0;
        let query = MeshQuery::new(&soup);
        let errors: Vec<f64> = band_points(&grid, 5)
            .into_iter()
            .map(|(p, phi)| (query.closest(p).distance - phi.abs()).abs() / voxel)
            .collect();
        let worst = errors.iter().copied().fold(0.0, f64::max);
        println!("soup {name}: {worst:.1e} voxels off at most of {} voxels", errors.len());
        assert!(worst < 2e-6, "{name}: {worst} voxels");
    }
}

#[test]
fn parts_made_by_formula_have_no_wrong_sign() {
    for (name, mesh) in [("gear", parts::gear(240, 6)), ("slivers", parts::sliver_plate(800))] {
        let grid = bake_at(&mesh, 96.0);
        for (point, phi) in band_points(&grid, 31) {
            let winding = summed_winding_number(&mesh, point);
            assert!(phi.abs() < 1e-4 * grid.voxel || (winding > 0.5) == (phi < 0.0), "{name}: φ {phi} at {point}");
        }
    }
}

#[test]
fn parry_agrees_on_distance_and_sign() {
    let mesh = parts::gear(480, 10);
    let grid = bake_at(&mesh, 128.0);
    let narrow = |p: &glam::DVec3| Vector::new(p.x as f32, p.y as f32, p.z as f32);
    let vertices = mesh.positions.iter().map(narrow).collect();
    let shape = TriMesh::with_flags(vertices, mesh.triangles.clone(), TriMeshFlags::ORIENTED).unwrap();
    let mut compared = 0;
    for (point, phi) in band_points(&grid, 7) {
        let other = f64::from(shape.distance_to_local_point(narrow(&point), false));
        // parry uses f32, and its points are rounded to f32 too.
        let close = (phi - other).abs() < 2e-4 * grid.voxel;
        assert!(close, "φ {phi}, parry {other}, at {point}");
        compared += 1;
    }
    assert!(compared > 20_000, "{compared} points compared");
}
