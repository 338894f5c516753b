//! Inputs that once caused long runs, high memory use or a panic. Files found by fuzzing are stored in `finds/`.

use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::clean::clean;
use sdf_bake::read::{Format, UnitChoice, parse_mesh};

/// A star with many corners, as one polygon.
fn star(corners: usize) -> String {
    let mut text = String::new();
    for i in 0..corners {
        let (y, x) = (std::f64::consts::TAU * i as f64 / corners as f64).sin_cos();
        let radius = if i % 2 == 0 { 1.0 } else { 0.5 };
        text += &format!("v {} {} 0\n", radius * x, radius * y);
    }
    text
}

#[test]
fn many_faces_of_many_corners_are_read_in_linear_time() {
    let corners = 10_000;
    let face: String = (1..=corners).fold("f".to_owned(), |text, corner| text + " " + &corner.to_string());
    let file = star(corners) + &format!("{face}\n").repeat(40);
    let mesh = parse_mesh(file.as_bytes(), Format::Obj, UnitChoice::Metre, "star.obj").expect("a star").mesh;
    assert_eq!(mesh.triangles.len(), 40 * (corners - 2));
    // Each pair of neighbours spans a triangle with the centre.
    let slice = 0.5 * 1.0 * 0.5 * (std::f64::consts::TAU / corners as f64).sin();
    assert!((mesh.area() / (40.0 * corners as f64 * slice) - 1.0).abs() < 1e-9);
}

#[test]
fn an_edge_of_very_many_triangles_is_cleaned_in_linear_time() {
    let leaves = 100_000;
    let tip = |i: u32| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), 0.3 + 1e-6 * f64::from(i));
    let positions = [DVec3::ZERO, DVec3::Z].into_iter().chain((0..leaves).map(tip)).collect();
    let triangles = (0..leaves).map(|i| [0, 1, i + 2]).collect();
    let (_, report) = clean(Mesh { positions, triangles }).expect("a book of leaves");
    assert_eq!((report.shells, report.boundary_edges, report.non_manifold_edges), (1, 2 * leaves as usize, 1));
}
