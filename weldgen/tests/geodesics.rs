//! Compares ends of long geodesics with a reference of about 32 digits.

#[path = "../../sdf-bake/tests/common/parts.rs"]
mod parts;
mod reference;
mod shapes;

use std::f64::consts::{PI, TAU};

use sdf_bake::Mesh;
use shapes::{Numbers, icosphere};
use weldgen::curvature::CurvatureProfile;
use weldgen::topology::Topology;
use weldgen::trace::{TraceEnd, TraceLimits, TraceStart, trace};

/// A random start within a triangle, evenly over the triangles.
fn start(mesh: &Mesh, numbers: &mut Numbers) -> TraceStart {
    let face = (numbers.next() * mesh.triangles.len() as f64) as u32;
    let [a, b, c] = [0, 1, 2].map(|_| 0.1 + numbers.next());
    let [one, other, _] = mesh.corners(face as usize);
    let along = (other - one).normalize();
    let (sin, cos) = (TAU * numbers.next()).sin_cos();
    let heading = cos * along + sin * mesh.normal(face as usize).cross(along);
    TraceStart { face, barycentric: [a, b, c].map(|weight| weight / (a + b + c)), heading }
}

#[test]
fn ends_of_long_geodesics_are_those_of_a_reference_of_32_digits() {
    for (name, mesh) in [("gear", parts::gear(120, 8)), ("sphere", icosphere(0.1, 4))] {
        let topology = Topology::new(&mesh);
        let length = 0.5 * mesh.diagonal();
        let limits = TraceLimits { length, spacing: length, sharp_angle: PI, max_steps: 1_000_000 };
        let (mut numbers, mut worst, mut crossings) = (Numbers(9), 0f64, 0);
        for _ in 0..200 {
            let start = start(&mesh, &mut numbers);
            let traced = trace(&mesh, &topology, start, &CurvatureProfile::constant(0.0), limits);
            assert_eq!(traced.end, TraceEnd::Length);
            let end = reference::geodesic_end(&mesh, &topology, &start, length).unwrap();
            worst = worst.max(traced.points[1].position.distance(end) / mesh.diagonal());
            crossings += traced.crossings;
        }
        println!("{name}: {} crossings each, at most {worst:.1e} of the diagonal off", crossings / 200);
        assert!(crossings > 200 * 20, "{name}: {crossings} crossings are no test");
        assert!(worst < 1e-12, "{name}: {worst:e} of the diagonal off");
    }
}
