//! Small meshes with one flaw each, and the exact counts of cleaning.

mod common;

use common::*;
use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::clean::{CleanError, CleanReport, clean};

/// Report of a clean cube, to be modified by tests.
fn cube_report() -> CleanReport {
    CleanReport {
        vertices_before: 8,
        triangles_before: 12,
        weld_tolerance: 1e-6 * 3f64.sqrt(),
        vertices: 8,
        triangles: 12,
        bodies: 1,
        shells: 1,
        closed: true,
        consistently_oriented: true,
        ..CleanReport::default()
    }
}

fn unit_cube() -> Mesh {
    cube(DVec3::ZERO, 1.0)
}

fn cleaned(mesh: Mesh) -> (Mesh, CleanReport) {
    clean(mesh).expect("it can be cleaned")
}

/// Two meshes in one, without merging.
fn both(mut a: Mesh, b: &Mesh) -> Mesh {
    a.append(b);
    a
}

fn inside_out(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh
}

fn soup(mesh: &Mesh) -> Mesh {
    Mesh {
        positions: (0..mesh.triangles.len()).flat_map(|t| mesh.corners(t)).collect(),
        triangles: (0..mesh.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
    }
}

#[test]
fn a_perfect_mesh_goes_through_untouched() {
    let (mesh, report) = cleaned(unit_cube());
    assert_eq!((mesh, report.clone()), (unit_cube(), cube_report()));
    assert!(report.notes().is_empty() && report.is_watertight());
}

#[test]
fn a_soup_is_welded() {
    let (mesh, report) = cleaned(soup(&unit_cube()));
    assert_eq!(report, CleanReport { vertices_before: 36, merged_equal: 28, ..cube_report() });
    assert_eq!((mesh.positions.len(), report.repairs()), (8, 0));
}

#[test]
fn cracks_are_closed_up_to_the_tolerance_and_no_wider() {
    let shaken = |gap: f64| {
        let mut mesh = soup(&unit_cube());
        mesh.positions.iter_mut().enumerate().for_each(|(i, p)| p.x += if i % 2 == 0 { gap } else { 0.0 });
        cleaned(mesh).1
    };
    let close = shaken(1e-6);
    assert_eq!((close.vertices, close.boundary_edges, close.closed), (8, 0, true));
    assert_eq!(close.merged_near + close.merged_equal, 28);
    let wide = shaken(1e-5);
    assert_eq!((wide.merged_near, wide.closed), (0, false));
}

#[test]
fn a_plate_thinner_than_the_tolerance_keeps_both_faces() {
    let mut mesh = unit_cube();
    mesh.positions.iter_mut().for_each(|p| p.z *= 1e-7);
    let (plate, report) = cleaned(mesh.clone());
    assert_eq!((plate, report.merged_near, report.degenerate_faces), (mesh, 0, 0));
}

#[test]
fn a_short_edge_on_a_boundary_is_not_collapsed() {
    let mut mesh = unit_cube();
    // The open top's corner is cut by an edge shorter than the tolerance.
    mesh.triangles.retain(|t| !t.iter().all(|&v| v >= 4));
    mesh.positions.push(DVec3::new(1e-7, 0.0, 1.0));
    mesh.triangles.push([0, 8, 4]);
    mesh.triangles.iter_mut().filter(|t| **t == [0, 5, 4]).for_each(|t| *t = [0, 5, 8]);
    let report = cleaned(mesh).1;
    assert_eq!((report.merged_near, report.triangles, report.boundary_edges), (0, 11, 5));
}

#[test]
fn slivers_stay_and_empty_triangles_go() {
    let mut mesh = unit_cube();
    mesh.positions.extend([DVec3::new(0.5, 0.0, 0.0), DVec3::new(9.0, 9.0, 9.0)]);
    mesh.triangles.extend([[0, 8, 1], [3, 3, 5], [0, 0, 0]]);
    let (_, report) = cleaned(mesh);
    let expected = CleanReport {
        vertices_before: 10,
        triangles_before: 15,
        degenerate_faces: 3,
        unused_vertices: 2,
        weld_tolerance: 1e-6 * 3f64.sqrt(),
        ..cube_report()
    };
    assert_eq!(CleanReport { weld_tolerance: expected.weld_tolerance, ..report }, expected);

    let mut sliver = unit_cube();
    sliver.positions.push(DVec3::new(0.5, 1e-9, 0.0));
    sliver.triangles.retain(|t| *t != [0, 3, 1] && *t != [0, 1, 5]);
    sliver.triangles.extend([[0, 3, 8], [8, 3, 1], [0, 8, 5], [8, 1, 5]]);
    let (_, report) = cleaned(sliver);
    assert_eq!((report.degenerate_faces, report.triangles, report.closed), (0, 14, true));
}

#[test]
fn a_flat_triangle_between_neighbours_goes_without_leaving_a_gap() {
    let mut mesh = unit_cube();
    mesh.positions.extend([DVec3::new(0.5, 0.0, 0.0), DVec3::new(0.25, 0.0, 0.0)]);
    // The side y = 0 uses corners 8 and 9 on the edge 0-1, the bottom does not; two flat triangles fill the gap.
    mesh.triangles.retain(|t| *t != [0, 1, 5]);
    mesh.triangles.extend([[0, 9, 5], [9, 8, 5], [8, 1, 5], [0, 1, 8], [0, 8, 9]]);
    let (mesh, report) = cleaned(mesh);
    assert_eq!((report.swapped_edges, report.degenerate_faces, report.triangles), (2, 0, 16));
    assert!(report.is_watertight(), "{report:?}");
    assert!((mesh.volume() - 1.0).abs() < 1e-12 && (mesh.area() - 6.0).abs() < 1e-12);
}

#[test]
fn duplicates_go_whatever_corner_they_start_at() {
    let mut mesh = unit_cube();
    mesh.triangles.extend([[2, 3, 0], [3, 0, 2], [5, 7, 4]]);
    let (cleaned, report) = cleaned(mesh);
    assert_eq!(cleaned, unit_cube());
    assert_eq!(report, CleanReport { triangles_before: 15, duplicate_faces: 3, ..cube_report() });
    assert_eq!(report.notes(), ["dropped 3 duplicate faces"]);
}

#[test]
fn touching_cubes_keep_both_faces() {
    // The cube's triangles on x = 0 and x = 1 have different diagonals; mirrored, they coincide.
    let mut mirrored = inside_out(unit_cube());
    mirrored.positions.iter_mut().for_each(|p| p.x = 2.0 - p.x);
    let (mesh, report) = cleaned(both(unit_cube(), &mirrored));
    assert_eq!((report.duplicate_faces, report.coincident_pairs, report.triangles), (0, 2, 24));
    assert_eq!((report.bodies, report.non_manifold_edges, report.flipped_triangles), (1, 5, 0));
    assert!(report.closed && report.consistently_oriented && !report.is_watertight());
    assert!((mesh.volume() - 2.0).abs() < 1e-12);
}

#[test]
fn turned_triangles_are_turned_back() {
    let (mesh, report) = cleaned(inside_out(unit_cube()));
    assert!((mesh.volume() - 1.0).abs() < 1e-12);
    assert_eq!(report, CleanReport { flipped_shells: 1, ..cube_report() });

    let mut half = unit_cube();
    half.triangles.iter_mut().take(5).for_each(|t| t.swap(0, 1));
    let (mesh, report) = cleaned(half);
    assert!((mesh.volume() - 1.0).abs() < 1e-12);
    assert_eq!(report, CleanReport { flipped_triangles: 5, ..cube_report() });

    let mut most = unit_cube();
    most.triangles.iter_mut().take(8).for_each(|t| t.swap(0, 1));
    let (mesh, report) = cleaned(most);
    assert!((mesh.volume() - 1.0).abs() < 1e-12);
    assert_eq!(report, CleanReport { flipped_triangles: 4, flipped_shells: 1, ..cube_report() });
}

#[test]
fn a_cavity_stays_a_cavity() {
    let outer = cube(DVec3::ZERO, 3.0);
    let inner = cube(DVec3::ONE, 1.0);
    let volume_and_flips = |mesh: Mesh| {
        let (mesh, report) = cleaned(mesh);
        assert_eq!((report.bodies, report.shells), (2, 2));
        (mesh.volume().round(), report.flipped_shells)
    };
    let hollow = both(outer.clone(), &inside_out(inner.clone()));
    assert_eq!(volume_and_flips(hollow.clone()), (26.0, 0));
    assert_eq!(volume_and_flips(inside_out(hollow)), (26.0, 2));
    // A solid within a solid is not a cavity; it stays unchanged.
    assert_eq!(volume_and_flips(both(outer.clone(), &inner)), (28.0, 0));
    // Order does not matter.
    assert_eq!(volume_and_flips(both(inner, &inside_out(outer))), (26.0, 2));
}

#[test]
fn neighbours_do_not_count_as_nested() {
    let mesh = both(unit_cube(), &inside_out(cube(DVec3::new(0.2, 0.3, 5.0), 0.5)));
    let (mesh, report) = cleaned(mesh);
    assert!((mesh.volume() - 1.125).abs() < 1e-12);
    assert_eq!((report.flipped_shells, report.shells), (1, 2));
}

#[test]
fn an_open_box_is_reported_and_left_open() {
    let mut mesh = unit_cube();
    mesh.triangles.retain(|t| !t.iter().all(|&v| v >= 4));
    let (_, report) = cleaned(inside_out(mesh));
    let expected =
        CleanReport { triangles_before: 10, triangles: 10, boundary_edges: 4, closed: false, ..cube_report() };
    assert_eq!(report, expected);
    assert_eq!(report.notes(), ["left 4 boundary edges: the surface is open there"]);
}

#[test]
fn solids_that_touch_at_a_vertex_are_one_body_of_two_shells() {
    let (_, report) = cleaned(both(unit_cube(), &cube(DVec3::ONE, 1.0)));
    assert_eq!((report.bodies, report.shells, report.merged_equal), (1, 2, 1));
    assert!(report.is_watertight());
}

#[test]
fn what_cannot_be_a_solid_is_refused_with_the_reason() {
    let triangle = Mesh { positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]] };
    let message = clean(triangle.clone()).expect_err("a triangle").to_string();
    assert_eq!(message, "1 triangle cannot enclose a volume; at least 4 are needed");
    let six = Mesh { triangles: vec![[0, 1, 2]; 6], ..triangle.clone() };
    let message = clean(six).expect_err("a triangle").to_string();
    assert!(message.ends_with("(5 of 6 are degenerate or duplicate)"), "{message}");
    assert!(clean(Mesh::default()).expect_err("nothing").to_string().starts_with("0 triangles cannot"));

    let mut bad = unit_cube();
    bad.positions[5] = DVec3::new(f64::NAN, 0.0, 1.0);
    assert_eq!(clean(bad).expect_err("NaN").to_string(), "vertex 5 is (NaN, 0, 1): coordinates must be finite numbers");
    let bad = Mesh { triangles: vec![[0, 1, 3]], ..triangle };
    assert_eq!(clean(bad), Err(CleanError::NoSuchVertex { triangle: 0, vertex: 3, vertices: 3 }));
}

#[test]
fn the_bundled_bracket_needs_no_repair() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/bracket.obj");
    let file = sdf_bake::read::read_mesh(&path, sdf_bake::read::UnitChoice::Auto).expect("the bundled part");
    let (mesh, report) = cleaned(file.mesh);
    assert!(report.notes().is_empty(), "{:?}", report.notes());
    assert_eq!((report.bodies, report.shells), (1, 1));
    let (low, high) = mesh.bounds().expect("vertices");
    assert!((high - low - DVec3::new(0.160, 0.090, 0.060)).abs().max_element() < 1e-9, "{low} to {high}");
}
