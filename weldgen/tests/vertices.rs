//! Straightest geodesics through vertices: equal angles on the left and on the right.

mod shapes;

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use sdf_bake::Mesh;
use shapes::{cuboid, plane};
use weldgen::curvature::CurvatureProfile;
use weldgen::topology::Topology;
use weldgen::trace::{Trace, TraceEnd, TraceLimits, TracePoint, TraceStart, trace};

fn aim(mesh: &Mesh, face: u32, barycentric: [f64; 3], at: DVec3, length: f64, sharp_angle: f64) -> Trace {
    let corners = mesh.corners(face as usize);
    let from: DVec3 = corners.iter().zip(barycentric).map(|(corner, weight)| weight * corner).sum();
    let limits = TraceLimits { length, spacing: length / 10.0, sharp_angle, max_steps: 1000 };
    let start = TraceStart { face, barycentric, heading: at - from };
    trace(mesh, &Topology::new(mesh), start, &CurvatureProfile::constant(0.0), limits)
}

/// A closed ring of triangles around vertex 0 at the origin; corner `i` of the ring at the angle 2πi/n and this height.
fn umbrella(count: u32, height: impl Fn(u32) -> f64) -> Mesh {
    let corner = |i: u32| {
        let turn = TAU * f64::from(i) / f64::from(count);
        DVec3::new(turn.cos(), turn.sin(), height(i))
    };
    Mesh {
        positions: std::iter::once(DVec3::ZERO).chain((0..count).map(corner)).collect(),
        triangles: (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect(),
    }
}

/// Angle [rad] around vertex 0 from the first corner of the ring to a point, over the triangles between them.
fn angle_around(mesh: &Mesh, point: &TracePoint) -> f64 {
    let angle = |a: DVec3, b: DVec3| a.cross(b).length().atan2(a.dot(b));
    let before: f64 = (0..point.face as usize).map(|face| angle(mesh.corners(face)[1], mesh.corners(face)[2])).sum();
    before + angle(mesh.corners(point.face as usize)[1], point.position)
}

#[test]
fn over_a_cone_and_over_a_saddle_both_sides_have_half_of_the_angle() {
    let cone = umbrella(7, |_| -0.8);
    let saddle = umbrella(8, |i| if i % 2 == 0 { 0.9 } else { -0.9 });
    let flat = umbrella(5, |_| 0.0);
    for (name, mesh) in [("cone", cone), ("saddle", saddle), ("flat", flat)] {
        let whole: f64 =
            (0..mesh.triangles.len()).map(|face| mesh.corners(face)[1].angle_between(mesh.corners(face)[2])).sum();
        for (face, share) in [(0, 0.3), (1, 0.5), (3, 0.01), (4, 0.9)] {
            let weights = [0.6, 0.4 * (1.0 - share), 0.4 * share];
            let traced = aim(&mesh, face, weights, DVec3::ZERO, 0.8, PI);
            assert_eq!(traced.end, TraceEnd::Length, "{name}");
            let [first, last] = [0, 10].map(|i| angle_around(&mesh, &traced.points[i]));
            let left = (last - first).rem_euclid(whole);
            assert!((left - 0.5 * whole).abs() < 1e-7, "{name}: {left} of {whole} on the left");
            let distance = traced.points[0].position.length() + traced.points[10].position.length();
            assert!((distance - 0.8).abs() < 1e-14, "{name}: the way is {distance} long");
            let tangent = traced.points[10].position.normalize();
            assert!(traced.points[10].tangent.distance(tangent) < 1e-14, "{name}");
        }
    }
}

#[test]
fn over_the_corner_of_a_cube_the_diagonal_goes_on_down_the_edge() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let top = (0..12).find(|&face| {
        let corners = cube.corners(face);
        corners.iter().all(|corner| corner.z == 1.0) && corners.contains(&DVec3::ONE)
    });
    let length = 0.25 * 2f64.sqrt() + 0.3;
    let from = DVec3::new(0.75, 0.75, 1.0);
    let face = top.unwrap();
    let [a, b, c] = cube.corners(face);
    let whole = (b - a).cross(c - a).z;
    let weights = [(b - from).cross(c - from).z / whole, (c - from).cross(a - from).z / whole];
    let weights = [weights[0], weights[1], 1.0 - weights[0] - weights[1]];
    let traced = aim(&cube, face as u32, weights, DVec3::ONE, length, PI);
    let last = traced.points[10].position;
    assert!(last.distance(DVec3::new(1.0, 1.0, 0.7)) < 1e-14, "{last}");
    // With creases on both sides of the path the corner is not passed.
    let stopped = aim(&cube, face as u32, weights, DVec3::ONE, length, 0.6);
    assert_eq!(stopped.end, TraceEnd::Sharp);
    assert!((stopped.length - 0.25 * 2f64.sqrt()).abs() < 1e-14);
}

#[test]
fn a_crease_that_ends_at_a_vertex_is_passed_on_its_open_side() {
    // A flap folded up along two neighbouring edges: all folds are on one side of the path.
    let mesh = umbrella(8, |i| if i == 1 { 0.9 } else { 0.0 });
    let traced = aim(&mesh, 7, [0.6, 0.2, 0.2], DVec3::ZERO, 0.8, 0.3);
    assert_eq!(traced.end, TraceEnd::Length);
}

#[test]
fn at_a_corner_of_an_open_surface_the_trace_ends() {
    let mesh = plane(1.0, 3, 3);
    let corner = mesh.positions[0];
    let face = mesh.triangles.iter().position(|corners| corners.contains(&0)).unwrap();
    let traced = aim(&mesh, face as u32, [0.4, 0.3, 0.3], corner, 2.0, PI);
    assert_eq!(traced.end, TraceEnd::Boundary);
}
