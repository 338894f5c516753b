//! Swept beads against closed forms.

mod shapes;

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::bake::WindingTree;
use shapes::Numbers;
use weldgen::bead::{BeadError, BeadProfile, sweep};
use weldgen::curve::{CurvePoint, WeldCurve};

const PROFILE: BeadProfile =
    BeadProfile { width: 0.010, height: 0.003, shape: weldgen::bead::BeadShape::Parabolic, toe_height: 0.0 };
const ROOT: f64 = 0.0006;

/// A curve of constant curvature in the plane z = 0, from the origin along x.
fn circular(length: f64, curvature: f64, count: u32) -> WeldCurve {
    let point = |i: u32| {
        let s = length * f64::from(i) / f64::from(count);
        let (sin, cos) = (curvature * s).sin_cos();
        let position = match curvature == 0.0 {
            true => DVec3::X * s,
            false => DVec3::new(sin, 1.0 - cos, 0.0) / curvature,
        };
        CurvePoint {
            position,
            tangent: DVec3::new(cos, sin, 0.0),
            normal: DVec3::Z,
            side: DVec3::new(-sin, cos, 0.0),
            arc_length: s,
            geodesic_curvature: curvature,
            face: 0,
            barycentric: [1.0, 0.0, 0.0],
            exposure: 1.0,
            access: 1.0,
            width: PROFILE.width,
            height: PROFILE.height,
        }
    };
    WeldCurve { points: (0..=count).map(point).collect() }
}

/// Every edge is shared by exactly two triangles that walk it in opposite directions; one component of genus 0.
fn assert_is_a_closed_ball(mesh: &Mesh) {
    let mut edges: HashMap<(u32, u32), i32> = HashMap::new();
    for t in &mesh.triangles {
        for i in 0..3 {
            *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
        }
    }
    for (&(a, b), &count) in &edges {
        assert_eq!(count, 1, "edge {a}-{b} is walked {count} times");
        assert_eq!(edges.get(&(b, a)), Some(&1), "edge {a}-{b} has no partner");
    }
    let euler = mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64;
    assert_eq!(euler, 2);
    let smallest =
        (0..mesh.triangles.len()).map(|t| mesh.doubled_area_normal(t).length()).fold(f64::INFINITY, f64::min);
    assert!(smallest > 0.0, "a triangle has no area");
}

#[test]
fn a_straight_bead_is_closed_and_has_the_volume_of_the_formula() {
    let mesh = sweep(&circular(0.1, 0.0, 160), &PROFILE, ROOT).unwrap();
    assert_is_a_closed_ball(&mesh);
    let (volume, expected) = (mesh.volume(), PROFILE.swept_volume(0.1, ROOT));
    let missing = (expected - volume) / expected;
    assert!((0.0..1.5e-3).contains(&missing), "{missing} of the volume is missing");
}

#[test]
fn a_bead_around_an_arc_has_the_volume_that_pappus_gives() {
    for (curvature, count) in [(40.0, 300), (-80.0, 300), (150.0, 300)] {
        let length = 1.4 * PI / f64::abs(curvature);
        let mesh = sweep(&circular(length, curvature, count), &PROFILE, ROOT).unwrap();
        assert_is_a_closed_ball(&mesh);
        let missing = 1.0 - mesh.volume() / PROFILE.swept_volume(length, ROOT);
        assert!((0.0..1.5e-3).contains(&missing), "{missing} of the volume is missing at κ = {curvature}");
    }
}

#[test]
fn the_volume_formula_is_the_integral_of_the_outline() {
    // Section and cap by the midpoint rule on the outline z(y).
    let base = PROFILE.half_width_at(ROOT);
    let count = 20_000;
    let step = base / f64::from(count);
    let (mut area, mut cap) = (0.0, 0.0);
    for i in 0..count {
        let y = step * (f64::from(i) + 0.5);
        area += 2.0 * (PROFILE.height_at(y) + ROOT) * step;
        cap += 2.0 * PI * y * (PROFILE.height_at(y) + ROOT) * step; // both half turns
    }
    assert!((PROFILE.section_area(ROOT) / area - 1.0).abs() < 1e-8);
    assert!((PROFILE.swept_volume(0.05, ROOT) / (0.05 * area + cap) - 1.0).abs() < 1e-8);
    assert!(PROFILE.height_at(0.5 * PROFILE.width).abs() < 1e-18);
}

#[test]
fn on_flat_ground_the_footprint_is_exactly_as_wide_as_the_bead() {
    let mesh = sweep(&circular(0.1, 0.0, 100), &PROFILE, ROOT).unwrap();
    let toes = mesh.positions.iter().filter(|p| p.z.abs() < 1e-15);
    let (low, high) = toes.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(*p), h.max(*p)));
    assert!((high.y - 0.005).abs() < 1e-15 && (low.y + 0.005).abs() < 1e-15);
    // The round ends reach half a width beyond the curve.
    assert!((high.x - 0.105).abs() < 1e-15 && (low.x + 0.005).abs() < 1e-15);
    let crown = mesh.positions.iter().map(|p| p.z).fold(0.0, f64::max);
    let root = mesh.positions.iter().map(|p| p.z).fold(0.0, f64::min);
    assert_eq!((crown, root), (0.003, -ROOT));
}

#[test]
fn no_point_is_inside_twice_and_inside_is_where_the_formula_says() {
    let (curvature, length) = (100.0, 0.05);
    let mesh = sweep(&circular(length, curvature, 200), &PROFILE, ROOT).unwrap();
    let tree = WindingTree::new(&mesh);
    let mut numbers = Numbers(9);
    let mut inside = 0;
    for _ in 0..4000 {
        let angle = numbers.next() * curvature * length;
        let y = (2.0 * numbers.next() - 1.0) * 0.007;
        let z = numbers.next() * 0.0045 - 0.001;
        let radius = 1.0 / curvature - y;
        let point = DVec3::new(radius * angle.sin(), 1.0 / curvature - radius * angle.cos(), z);
        let depth = (PROFILE.height_at(y) - z).min(z + ROOT);
        if depth.abs() < 4e-5 {
            continue; // within the chords' error of the surface
        }
        let expected = if depth > 0.0 { 1.0 } else { 0.0 };
        let found = tree.winding_number(point);
        assert!((found - expected).abs() < 0.05, "winding number {found} at y = {y}, z = {z}");
        inside += usize::from(depth > 0.0);
    }
    assert!(inside > 500);
}

#[test]
fn too_tight_turns_and_bad_sizes_are_refused() {
    let tight = sweep(&circular(0.02, 180.0, 100), &PROFILE, ROOT);
    assert!(matches!(tight, Err(BeadError::TooTight { .. })), "{tight:?}");
    for (profile, root) in [
        (BeadProfile::parabolic(0.0, 0.003), ROOT),
        (BeadProfile::parabolic(0.01, f64::NAN), ROOT),
        (PROFILE, 0.0),
        (PROFILE, f64::INFINITY),
    ] {
        let refused = sweep(&circular(0.05, 0.0, 50), &profile, root);
        assert!(matches!(refused, Err(BeadError::Dimension { .. })), "{refused:?}");
    }
    let none = sweep(&WeldCurve::default(), &PROFILE, ROOT);
    assert_eq!(none, Err(BeadError::TooShort(0)));
    let mut folded = circular(0.05, 0.0, 50);
    folded.points.swap(20, 24);
    assert!(matches!(sweep(&folded, &PROFILE, ROOT), Err(BeadError::Folded(_))));
}
