//! Properties of every baked field, on random convex bodies, boxes and balls in random positions.

#[path = "common/field.rs"]
mod field;

use std::f64::consts::TAU;

use field::{band_points, summed_winding_number};
use glam::{DQuat, DVec3, IVec3};
use parry3d::math::Vector;
use parry3d::transformation::convex_hull;
use proptest::prelude::*;
use sdf_bake::grid::{BRICK_VOXELS, voxel_at};
use sdf_bake::{BakeError, BakeOptions, BrickGrid, Mesh, bake};

/// Tolerance of |φ| in the band [voxels].
const DISTANCE_TOLERANCE: f64 = 2e-5;
/// Distance from the surface below which either sign is correct [voxels].
const ON_SURFACE: f64 = 1e-4;
/// Number of voxels of the band per body that are compared with brute force.
const SAMPLES: usize = 300;

/// Triangles of a hull, with outward normals.
fn hull(points: &[DVec3]) -> Mesh {
    let narrow: Vec<Vector> = points.iter().map(|p| Vector::new(p.x as f32, p.y as f32, p.z as f32)).collect();
    let (positions, triangles) = convex_hull(&narrow);
    let wide = |p: &Vector| DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z));
    Mesh { positions: positions.iter().map(wide).collect(), triangles }
}

fn unit_vector() -> impl Strategy<Value = DVec3> {
    // Archimedes: heights on a sphere are uniformly distributed.
    (-1.0..1.0f64, 0.0..TAU).prop_map(|(z, angle)| {
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    })
}

/// Bodies of 2 mm to 0.2 m around the origin.
fn body() -> impl Strategy<Value = Mesh> {
    let corners = |half: DVec3| (0..8).map(|i| half * DVec3::new(sign(i), sign(i >> 1), sign(i >> 2))).collect();
    let cuboid = (0.1..1.0f64, 0.1..1.0f64).prop_map(move |(y, z)| corners(DVec3::new(1.0, y, z)));
    let ball = (40usize..150).prop_map(|count| (0..count).map(|i| spiral(i, count)).collect());
    let polyhedron = prop::collection::vec((unit_vector(), 0.3..1.0f64).prop_map(|(u, r)| u * r), 6..40);
    let points = prop_oneof![cuboid, ball, polyhedron].prop_map(|points: Vec<DVec3>| hull(&points));
    (points, 1e-3..0.1f64).prop_map(|(mesh, size)| moved(mesh, |p| size * p))
}

fn sign(bit: i32) -> f64 {
    f64::from(2 * (bit & 1) - 1)
}

/// Uniformly distributed points on the unit sphere (Fibonacci spiral).
fn spiral(i: usize, count: usize) -> DVec3 {
    let z = 1.0 - (2 * i + 1) as f64 / count as f64;
    let (sine, cosine) = (TAU * 0.618_033_988_749_895 * i as f64).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    DVec3::new(radius * cosine, radius * sine, z)
}

fn moved(mut mesh: Mesh, motion: impl Fn(DVec3) -> DVec3) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p = motion(*p));
    mesh
}

/// A body at a random pose, and a voxel [m] not larger than its thickness.
fn body_and_voxel() -> impl Strategy<Value = (Mesh, f64)> {
    let place = (unit_vector(), 0.0..TAU, prop::array::uniform3(-0.2..0.2f64));
    let posed = (body(), place, 6.0..40.0f64).prop_map(|(mesh, (axis, angle, shift), across)| {
        let turn = DQuat::from_axis_angle(axis, angle);
        let mesh = moved(mesh, |p| turn * p + DVec3::from_array(shift));
        let (low, high) = mesh.bounds().expect("vertices");
        (mesh, (high - low).max_element() / across)
    });
    posed.prop_filter("it must hold a voxel", |(mesh, voxel)| {
        !matches!(bake(mesh, &BakeOptions::with_voxel(*voxel)), Err(BakeError::NoInside { .. }))
    })
}

/// Distance from a point to a triangle in f64 (Ericson 2005, section 5.1.5, by its three regions).
fn distance_to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let within = |u: DVec3, v: DVec3| (v - u).cross(p - u).dot(normal) >= 0.0;
    if normal != DVec3::ZERO && within(a, b) && within(b, c) && within(c, a) {
        return (p - a).dot(normal).abs() / normal.length();
    }
    let to_edge = |u: DVec3, v: DVec3| {
        let along = ((p - u).dot(v - u) / (v - u).length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        p.distance(u + along * (v - u))
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

fn baked(mesh: &Mesh, voxel: f64) -> BrickGrid {
    bake(mesh, &BakeOptions::with_voxel(voxel)).expect("a closed body").0
}

fn baked_on(threads: usize, mesh: &Mesh, voxel: f64) -> BrickGrid {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| baked(mesh, voxel))
}

fn bits(grid: &BrickGrid) -> Vec<u32> {
    grid.phi.iter().map(|phi| phi.to_bits()).collect()
}

/// Greatest |φ(a) − φ(b)| of neighbours in the lattice [voxels].
fn steepest(grid: &BrickGrid) -> f64 {
    let mut steepest: f64 = 0.0;
    for (at, &phi) in grid.phi.iter().enumerate() {
        let voxel = voxel_at(grid.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS);
        for step in IVec3::AXES {
            let difference = f64::from(phi) - f64::from(grid.phi_at(voxel + step));
            steepest = steepest.max(difference.abs() / grid.voxel);
        }
    }
    steepest
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn distance_and_sign_are_those_of_brute_force((mesh, voxel) in body_and_voxel()) {
        let grid = baked(&mesh, voxel);
        let points = band_points(&grid, 1);
        for &(point, phi) in points.iter().step_by((points.len() / SAMPLES).max(1)) {
            let triangles = 0..mesh.triangles.len();
            let exact = triangles.map(|t| distance_to_triangle(point, mesh.corners(t))).fold(f64::MAX, f64::min);
            let error = (exact - phi.abs()).abs() / voxel;
            prop_assert!(error <= DISTANCE_TOLERANCE, "{error} voxels off at {point}: φ {phi}, {exact} exactly");
            let inside = summed_winding_number(&mesh, point) > 0.5;
            prop_assert!(exact < ON_SURFACE * voxel || inside == (phi < 0.0), "φ {phi} at {point}, {exact} from the surface");
        }
    }

    #[test]
    fn neighbours_differ_by_no_more_than_their_distance((mesh, voxel) in body_and_voxel()) {
        let steepest = steepest(&baked(&mesh, voxel));
        prop_assert!(steepest <= 1.0 + 2.0 * DISTANCE_TOLERANCE, "{steepest}");
    }

    #[test]
    fn threads_and_repetition_change_no_bit((mesh, voxel) in body_and_voxel()) {
        let first = baked_on(1, &mesh, voxel);
        for threads in [1, 4] {
            let again = baked_on(threads, &mesh, voxel);
            prop_assert!(bits(&again) == bits(&first) && again.bricks == first.bricks && again.index == first.index);
        }
    }

    #[test]
    fn twice_the_size_with_twice_the_voxel_is_twice_the_field((mesh, voxel) in body_and_voxel()) {
        let small = baked(&mesh, voxel);
        let large = baked(&moved(mesh, |p| 2.0 * p), 2.0 * voxel);
        prop_assert_eq!((&small.bricks, &small.index), (&large.bricks, &large.index));
        let doubled = small.phi.iter().map(|phi| 2.0 * phi);
        prop_assert!(doubled.eq(large.phi.iter().copied()));
    }
}
