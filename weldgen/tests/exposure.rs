//! Compares exposure with closed forms.

mod shapes;

use std::f64::consts::TAU;

use glam::DVec3;
use sdf_bake::{Mesh, query::MeshQuery};
use shapes::{cuboid, sheet};
use weldgen::exposure::{ExposureRays, exposure, exposures};

const RAYS: ExposureRays = ExposureRays { reach: 10.0, lift: 1e-6, rays: 4096 };

#[test]
fn a_convex_solid_sees_the_whole_sky() {
    let query = MeshQuery::new(&cuboid(DVec3::splat(-1.0), DVec3::ONE));
    for (position, normal) in [(DVec3::new(0.3, 0.2, 1.0), DVec3::Z), (DVec3::new(-1.0, 0.9, 0.9), DVec3::NEG_X)] {
        assert_eq!(exposure(&query, position, normal, RAYS), 1.0);
    }
}

#[test]
fn at_the_foot_of_an_endless_wall_half_the_sky_is_free() {
    let mut mesh = cuboid(DVec3::new(-500.0, -500.0, -1.0), DVec3::new(500.0, 500.0, 0.0));
    mesh.append(&cuboid(DVec3::new(0.001, -500.0, 0.0), DVec3::new(1.0, 500.0, 500.0)));
    let query = MeshQuery::new(&mesh);
    let far = ExposureRays { reach: 1e4, ..RAYS };
    assert!((exposure(&query, DVec3::ZERO, DVec3::Z, far) - 0.5).abs() < 2e-3);
}

/// A round well of radius 1 and the given depth, seen from inside.
fn well(depth: f64) -> Mesh {
    sheet(256, 1, true, |u, v| DVec3::new((TAU * u).cos(), (TAU * u).sin(), depth * (1.0 - v)))
}

#[test]
fn the_middle_of_a_wells_floor_sees_what_the_view_factor_of_its_mouth_says() {
    // View factor from a point to a coaxial disc: r² / (r² + h²).
    for depth in [0.3, 1.0, 2.5] {
        let query = MeshQuery::new(&well(depth));
        let found = exposure(&query, DVec3::ZERO, DVec3::Z, RAYS);
        let expected = 1.0 / (1.0 + depth * depth);
        assert!((found - expected).abs() < 2e-3, "{found} is not {expected}");
    }
}

#[test]
fn what_lies_beyond_the_reach_hides_nothing() {
    let query = MeshQuery::new(&well(2.0));
    let short = ExposureRays { reach: 0.9, ..RAYS };
    assert_eq!(exposure(&query, DVec3::ZERO, DVec3::Z, short), 1.0);
}

#[test]
fn many_points_give_the_same_on_one_thread_and_on_two() {
    let query = MeshQuery::new(&well(1.0));
    let points: Vec<_> = (0..40).map(|i| (DVec3::new(f64::from(i) * 0.02, 0.0, 0.0), DVec3::Z)).collect();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| exposures(&query, &points, ExposureRays { rays: 256, ..RAYS }))
    };
    assert_eq!(on(1), on(2));
}
