//! Compares traced curves with closed forms.

mod shapes;

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DVec2, DVec3};
use sdf_bake::{Mesh, query::MeshQuery};
use shapes::{Numbers, cuboid, icosphere, plane, sheet, tube};
use weldgen::curvature::CurvatureProfile;
use weldgen::topology::{EdgeNeighbour, Topology};
use weldgen::trace::{Trace, TraceEnd, TraceLimits, TraceStart, trace};

fn limits(length: f64) -> TraceLimits {
    TraceLimits { length, spacing: length / 50.0, sharp_angle: PI, max_steps: 1_000_000 }
}

fn run(mesh: &Mesh, at: DVec3, heading: DVec3, curvature: &CurvatureProfile, limits: TraceLimits) -> Trace {
    let closest = MeshQuery::new(mesh).closest(at);
    let start = TraceStart { face: closest.triangle, barycentric: closest.barycentric, heading };
    trace(mesh, &Topology::new(mesh), start, curvature, limits)
}

/// End of a planar curve whose curvature changes linearly from `first` to `last`: the Fresnel integrals by Simpson's
/// rule.
fn clothoid(start: DVec2, angle: f64, [first, last]: [f64; 2], length: f64) -> (DVec2, f64) {
    let angle_at = |s: f64| angle + first * s + 0.5 * (last - first) / length * s * s;
    let count = 2000;
    let step = length / f64::from(count);
    let panel = |i: i32| {
        let s = step * f64::from(i);
        let [a, b, c] = [s, s + 0.5 * step, s + step].map(|s| DVec2::from_angle(angle_at(s)));
        (a + 4.0 * b + c) * step / 6.0
    };
    (start + (0..count).map(panel).sum::<DVec2>(), angle_at(length))
}

#[test]
fn on_a_plane_a_circle_closes_exactly() {
    let mesh = plane(1.0, 40, 40);
    let (radius, at) = (0.2, DVec3::new(0.0137, -0.2091, 0.0));
    let traced = run(&mesh, at, DVec3::X, &CurvatureProfile::constant(1.0 / radius), limits(TAU * radius));
    assert_eq!(traced.end, TraceEnd::Length);
    assert!(traced.crossings > 100);
    let (first, last) = (traced.points[0], traced.points[50]);
    assert!(first.position.distance(last.position) < 1e-12, "{}", first.position.distance(last.position));
    assert!(first.tangent.distance(last.tangent) < 1e-12);
    let centre = at + DVec3::Y * radius;
    for point in &traced.points {
        assert!((point.position.distance(centre) - radius).abs() < 1e-12);
    }
}

#[test]
fn on_a_plane_a_clothoid_is_the_fresnel_curve() {
    let mesh = plane(1.0, 37, 41);
    let length = 0.5;
    // κ runs from -8 through 0 to +12 per metre.
    let profile = CurvatureProfile::linear(0.0, length, vec![-8.0, 12.0]).unwrap();
    let start = DVec3::new(-0.3, -0.2, 0.0);
    let traced = run(&mesh, start, DVec3::new(1.0, 1.0, 0.0), &profile, limits(length));
    let (expected, angle) = clothoid(start.truncate(), PI / 4.0, [-8.0, 12.0], length);
    let last = traced.points[50];
    assert!(last.position.truncate().distance(expected) < 1e-13, "{}", last.position.truncate().distance(expected));
    assert!((last.tangent.truncate() - DVec2::from_angle(angle)).length() < 1e-12);
}

#[test]
fn slivers_700_000_times_longer_than_wide_change_nothing() {
    // Strips 1.4e-6 wide and 1 long, each cut along its diagonal, crossed by a circle.
    let strip =
        |u: f64, v: f64| DVec3::new(0.7 * u + v * 2e-4, 0.7 * u - v * 2e-4, 0.0) + DVec3::new(-0.35, -0.35, 0.0);
    let mesh = sheet(1, 200, false, strip);
    let curvature = CurvatureProfile::constant(2e4);
    let at = strip(0.4137, 0.5);
    let traced = run(&mesh, at, DVec3::new(1.0, 0.2, 0.0), &curvature, limits(TAU / 2e4));
    assert_eq!(traced.end, TraceEnd::Length);
    assert!(traced.crossings > 200, "{}", traced.crossings);
    let gap = traced.points[0].position.distance(traced.points[50].position);
    assert!(gap < 1e-13, "the circle misses its start by {gap}");
}

#[test]
fn on_a_tube_the_curve_unrolls_to_the_planar_one() {
    // Unrolled, a tube of flat sides is a strip of width sides · chord.
    let (radius, sides) = (0.1, 24u32);
    let mesh = tube(radius, 1.0, sides, 7);
    let chord = 2.0 * radius * (PI / f64::from(sides)).sin();
    let profile = CurvatureProfile::linear(0.0, 0.6, vec![3.0, -3.0]).unwrap();
    let mid = radius * (TAU / 48.0).cos() * DVec3::new((TAU / 48.0).cos(), (TAU / 48.0).sin(), 0.0) + DVec3::Z * 0.3;
    let around = DVec3::new(-(TAU / 48.0).sin(), (TAU / 48.0).cos(), 0.0);
    let traced = run(&mesh, mid, around + DVec3::Z * 0.5, &profile, limits(0.6));
    assert_eq!(traced.end, TraceEnd::Length);
    let (expected, _) = clothoid(DVec2::new(0.5 * chord, 0.3), 0.5f64.atan(), [3.0, -3.0], 0.6);
    let last = traced.points[50].position;
    let side = (expected.x / chord).floor();
    let corner = |i: f64| DVec2::from_angle(TAU * i / f64::from(sides)) * radius;
    let there = corner(side).lerp(corner(side + 1.0), expected.x / chord - side).extend(expected.y);
    assert!(last.distance(there) < 1e-13, "{last} is not {there}");
}

#[test]
fn around_a_cone_a_geodesic_turns_by_the_missing_angle() {
    // A cone of flat sides: unrolled, its apex is the centre of a fan. A straight line at distance `b` from the
    // apex spans an angle approaching π, so at equal distances ±x it spans 2·atan(x/b) of fan.
    let sides = 60u32;
    let mesh = sheet(sides, 1, true, |u, v| {
        let r = 0.05 + 0.95 * v;
        DVec3::new(r * (TAU * u).cos(), r * (TAU * u).sin(), -1.5 * r)
    });
    let slant = (1.0f64 + 1.5 * 1.5).sqrt();
    let wedge = 2.0 * ((PI / f64::from(sides)).sin() / slant).asin();
    // Start in the middle of side 0 at fan radius `b`, with heading perpendicular to the fan's radius.
    let middle = |b: f64| {
        let r = b / slant * (1.0 / (wedge / 2.0).cos()) * (PI / f64::from(sides)).cos();
        let turn = PI / f64::from(sides);
        DVec3::new(r * turn.cos(), r * turn.sin(), -1.5 * b / slant / (wedge / 2.0).cos())
    };
    let (b, x) = (0.5, 1.2);
    let around = DVec3::new(-(PI / 60.0).sin(), (PI / 60.0).cos(), 0.0);
    let traced = run(&mesh, middle(b), around, &CurvatureProfile::constant(0.0), limits(x));
    assert_eq!(traced.end, TraceEnd::Length);
    let last = traced.points[50].position;
    let fan_angle = (x / b).atan() + wedge / 2.0;
    let side = (fan_angle / wedge).floor();
    let within = fan_angle - side * wedge;
    // On a side, the fan radius of its chord at angle `within` and its two corners in space.
    let fan_radius = b.hypot(x);
    let corner = |i: f64| {
        let turn = TAU * i / f64::from(sides);
        DVec3::new(turn.cos(), turn.sin(), -1.5) / slant
    };
    let weights = DVec2::new((wedge - within).sin(), within.sin()) / wedge.sin();
    let there = fan_radius * (weights.x * corner(side) + weights.y * corner(side + 1.0));
    assert!(last.distance(there) < 1e-13, "{last} is not {there}");
}

#[test]
fn on_a_sphere_the_latitude_circle_closes_at_the_rate_of_the_tessellation() {
    // At polar angle α the latitude circle has κ_g = cot α / R and length 2π R sin α.
    let alpha = 0.9f64;
    let mut gaps = Vec::new();
    for levels in [3, 4, 5] {
        let mesh = icosphere(1.0, levels);
        let at = DVec3::new(alpha.sin(), 0.0, alpha.cos());
        let profile = CurvatureProfile::constant(1.0 / alpha.tan());
        let traced = run(&mesh, at, DVec3::Y, &profile, limits(TAU * alpha.sin()));
        assert_eq!(traced.end, TraceEnd::Length);
        let worst = traced.points.iter().map(|p| (p.position.normalize().z - alpha.cos()).abs()).fold(0.0, f64::max);
        gaps.push(worst);
    }
    assert!(gaps[2] < 4e-3 && gaps[2] < 0.3 * gaps[0], "off the latitude by {gaps:?}");
}

#[test]
fn around_a_cube_corner_the_holonomy_is_a_quarter_turn() {
    // A closed loop around one corner of a cube, three quarter circles of radius r in its faces: κ_g = 1/r, length 3/4
    // of the full circle. The curve must return to its start with its first heading.
    let mesh = cuboid(DVec3::ZERO, DVec3::ONE);
    let r = 0.4;
    let at = DVec3::new(1.0, 1.0 - r * 0.6, 1.0 - r * 0.8);
    let heading = DVec3::new(0.0, 0.8, -0.6);
    let traced = run(&mesh, at, heading, &CurvatureProfile::constant(1.0 / r), limits(1.5 * PI * r));
    let (first, last) = (traced.points[0], traced.points[50]);
    assert!(first.position.distance(last.position) < 1e-13, "the loop misses its start");
    assert!(first.tangent.distance(last.tangent) < 1e-13, "the loop misses its first heading");
}

#[test]
fn through_vertices_and_along_edges_a_straight_line_stays_straight() {
    // An even grid: the diagonal runs through vertices and along edges.
    let mesh = sheet(16, 16, false, |u, v| DVec3::new(u, v, 0.0));
    for (at, heading) in [
        (DVec3::new(0.125, 0.125, 0.0), DVec3::new(1.0, 1.0, 0.0)),
        (DVec3::new(0.125, 0.5, 0.0), DVec3::X),
        (DVec3::new(0.5, 0.1, 0.0), DVec3::Y),
        (DVec3::new(0.9, 0.1, 0.0), DVec3::new(-1.0, 1.0, 0.0)),
    ] {
        let traced = run(&mesh, at, heading, &CurvatureProfile::constant(0.0), limits(0.8));
        let end = at + 0.8 * heading.normalize();
        assert_eq!(traced.end, TraceEnd::Length, "{at} {heading}");
        assert!(traced.points[50].position.distance(end) < 1e-12, "{} is not {end}", traced.points[50].position);
    }
}

#[test]
fn a_circle_that_starts_along_an_edge_leaves_it_at_once_and_closes() {
    let mesh = sheet(16, 16, false, |u, v| DVec3::new(u, v, 0.0));
    for (heading, curvature) in [(DVec3::X, 8.0), (DVec3::X, -8.0), (DVec3::Y, 8.0), (DVec3::Y, -8.0)] {
        let at = DVec3::new(0.5, 0.5, 0.0) + 0.03 * heading;
        let traced = run(&mesh, at, heading, &CurvatureProfile::constant(curvature), limits(TAU / 8.0));
        let centre = at + DVec3::Z.cross(heading) / curvature;
        for point in &traced.points {
            assert!((point.position.distance(centre) - 0.125).abs() < 1e-12, "{} is off the circle", point.position);
        }
        assert!(traced.points[50].position.distance(at) < 1e-12);
    }
}

#[test]
fn random_traces_on_a_closed_part_never_stall_and_can_be_walked_back() {
    let mesh = icosphere(1.0, 2);
    let topology = Topology::new(&mesh);
    let mut numbers = Numbers(3);
    for _ in 0..300 {
        let weights = [numbers.next(), numbers.next(), numbers.next()];
        let sum: f64 = weights.iter().sum();
        let heading = DVec3::new(numbers.next() - 0.5, numbers.next() - 0.5, numbers.next() - 0.5);
        let start = TraceStart {
            face: (numbers.next() * mesh.triangles.len() as f64) as u32,
            barycentric: weights.map(|w| w / sum),
            heading,
        };
        let profile = CurvatureProfile::linear(0.0, 0.5, (0..5).map(|_| 6.0 * numbers.next() - 3.0).collect()).unwrap();
        let there = trace(&mesh, &topology, start, &profile, limits(1.0));
        assert_eq!(there.end, TraceEnd::Length);
        let last = there.points[50];
        let turn_round = TraceStart { face: last.face, barycentric: last.barycentric, heading: -last.tangent };
        // Back along the same curve: κ(1 - s), left and right exchanged.
        let knots = (0..=1000).map(|i| -profile.at(1.0 - f64::from(i) / 1000.0)).collect();
        let back =
            trace(&mesh, &topology, turn_round, &CurvatureProfile::linear(0.0, 0.001, knots).unwrap(), limits(1.0));
        let gap = back.points[50].position.distance(there.points[0].position);
        assert!(gap < 1e-9, "the way back misses the start by {gap}");
    }
}

#[test]
fn a_trace_says_why_it_stopped() {
    let straight = CurvatureProfile::constant(0.0);
    let flat = plane(1.0, 8, 8);
    let traced = run(&flat, DVec3::ZERO, DVec3::X, &straight, limits(2.0));
    assert_eq!(traced.end, TraceEnd::Boundary);
    assert!((traced.length - 0.5).abs() < 1e-12);

    let cube = cuboid(DVec3::splat(-0.5), DVec3::splat(0.5));
    let sharp = TraceLimits { sharp_angle: 0.6, ..limits(2.0) };
    let traced = run(&cube, DVec3::new(0.1, 0.0, 0.5), DVec3::X, &straight, sharp);
    assert_eq!(traced.end, TraceEnd::Sharp);
    assert!((traced.length - 0.4).abs() < 1e-12);

    let mut fin = flat.clone();
    let [a, b, _] = fin.triangles[0];
    fin.positions.push(DVec3::Z);
    fin.triangles.push([a, b, fin.positions.len() as u32 - 1]);
    assert!(Topology::new(&fin).across[0].contains(&EdgeNeighbour::NonManifold));

    let few = TraceLimits { max_steps: 3, ..limits(0.4) };
    assert_eq!(run(&flat, DVec3::ZERO, DVec3::X, &straight, few).end, TraceEnd::Steps);
    assert_eq!(run(&flat, DVec3::ZERO, DVec3::Z, &straight, limits(0.4)).end, TraceEnd::Degenerate);
    assert_eq!(run(&flat, DVec3::ZERO, DVec3::NAN, &straight, limits(0.4)).end, TraceEnd::Degenerate);
    let nonsense = CurvatureProfile::constant(f64::NAN);
    assert_eq!(run(&flat, DVec3::ZERO, DVec3::X, &nonsense, limits(0.4)).end, TraceEnd::Degenerate);
    assert_eq!(CurvatureProfile::linear(0.0, 0.0, vec![1.0]), None);
    assert_eq!(CurvatureProfile::linear(0.0, 1.0, vec![]), None);
}

#[test]
fn dihedral_angles_are_signed_by_convexity() {
    let cube = cuboid(DVec3::ZERO, DVec3::ONE);
    let turns = |mesh: &Mesh| -> Vec<f64> {
        let all = Topology::new(mesh).across;
        all.iter()
            .flatten()
            .filter_map(|a| if let EdgeNeighbour::Face { turn, .. } = a { Some(*turn) } else { None })
            .collect()
    };
    assert_eq!(turns(&cube).len(), 36);
    assert!(turns(&cube).iter().all(|t| t.abs() < 1e-12 || (t - FRAC_PI_2).abs() < 1e-12));
    let inside_out = Mesh { triangles: cube.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..cube };
    assert!(turns(&inside_out).iter().all(|t| t.abs() < 1e-12 || (t + FRAC_PI_2).abs() < 1e-12));
}
