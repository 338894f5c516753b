//! Compares swept beads with closed forms.

mod shapes;

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use sdf_bake::bake::WindingTree;
use sdf_bake::{BakeOptions, Mesh, bake};
use shapes::Numbers;
use weldgen::bead::{
    BeadError, BeadForm, BeadProfile, BeadShape, Crater, DefectKind, FormRequest, Ripples, Weave, sweep, sweep_formed,
};
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

/// Checks that every edge is shared by exactly two triangles that run along it in opposite directions, and that there
/// is one component of genus 0.
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
    // The round ends extend half a width beyond the curve.
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

#[test]
fn every_shape_on_a_face_has_its_width_height_toe_angle_and_volume() {
    for (shape, toe) in [
        (BeadShape::Parabolic, (4.0f64 * 0.3).atan()),
        (BeadShape::CircularSegment, 2.0 * (2.0f64 * 0.3).atan()),
        (BeadShape::Superellipse, 0.5 * PI),
    ] {
        let profile = BeadProfile::on_face(shape, 0.010, 0.003);
        assert!((profile.height_at(0.0) - 0.003).abs() < 1e-15 && profile.height_at(0.005).abs() < 1e-15, "{shape:?}");
        assert!((profile.toe_angle() - toe).abs() < 1e-12, "{shape:?}");
        if shape != BeadShape::Superellipse {
            let slope = -(profile.height_at(0.005) - profile.height_at(0.005 - 1e-8)) / 1e-8;
            assert!((slope.atan() - toe).abs() < 1e-4, "{shape:?}: the outline meets the surface at {}", slope.atan());
        }
        let mesh = sweep(&circular(0.1, 30.0, 300), &profile, ROOT).unwrap();
        assert_is_a_closed_ball(&mesh);
        let missing = 1.0 - mesh.volume() / profile.swept_volume(0.1, ROOT);
        assert!((-1e-3..3e-3).contains(&missing), "{shape:?}: {missing} of the volume is missing");
        // The area as a sum over heights instead of a polygon.
        let count = 4000;
        let strip = |i: i32| {
            let y = profile.half_width_at(ROOT) * (f64::from(i) + 0.5) / f64::from(count);
            let z = if y < 0.005 { profile.height_at(y) } else { profile.height_at(y).min(0.0) };
            2.0 * (z.max(-ROOT) + ROOT) * profile.half_width_at(ROOT) / f64::from(count)
        };
        let area = (0..count).map(strip).sum::<f64>() / profile.section_area(ROOT);
        assert!((area - 1.0).abs() < 0.01, "{shape:?}: {area}");
    }
}

/// A straight bead of 0.1 m with this form.
fn formed(request: FormRequest) -> (Mesh, BeadForm) {
    let form = BeadForm::new(request, [0.1, PROFILE.width, PROFILE.height], &mut Pcg64Mcg::seed_from_u64(4));
    (sweep_formed(&circular(0.1, 0.0, 160), &PROFILE, &form, ROOT).unwrap(), form)
}

#[test]
fn every_form_keeps_the_bead_closed_and_its_toes_on_the_surface() {
    let plain = FormRequest::default();
    let ripples = Some(Ripples { pitch: 0.004, height: 0.15, chevron: 0.4 });
    let crater = Some(Crater { depth: 0.6, hump: 0.1 });
    let weave = Some(Weave { amplitude: 0.002, pitch: 0.03 });
    let all = FormRequest { ripples, crater, weave, width_variation: 0.1, height_variation: 0.1, ..plain };
    for (name, request) in [
        ("ripples", FormRequest { ripples, ..plain }),
        ("crater", FormRequest { crater, ..plain }),
        ("weave", FormRequest { weave, ..plain }),
        ("pores", FormRequest { pores: 5, ..plain }),
        ("sag", FormRequest { sagging: 0.5, ..plain }),
        ("all", all),
    ] {
        let (mesh, form) = formed(request);
        assert_is_a_closed_ball(&mesh);
        let tree = WindingTree::new(&mesh);
        let mut flat = 0;
        for i in 1..50 {
            let s = 0.002 * f64::from(i);
            let toe = 0.5 * PROFILE.width * form.width_factor(s);
            let across = |y: f64, z: f64| tree.winding_number(DVec3::new(s, form.shift(s) + y, z));
            assert!(across(0.97 * toe, 2e-5) > 0.9 && across(1.03 * toe, 2e-5) < 0.1, "{name}: the toe is off at {s}");
            let crown = PROFILE.height * form.relief(s, 0.0);
            // Between two stations the rim of a pore is cut by a chord.
            let rim =
                [-7e-4, 7e-4].iter().any(|step| (form.relief(s + step, 0.0) / form.relief(s, 0.0) - 1.0).abs() > 0.06);
            if rim {
                continue;
            }
            flat += 1;
            assert!(across(0.0, 0.93 * crown) > 0.9 && across(0.0, 1.07 * crown) < 0.1, "{name}: off the crown at {s}");
        }
        assert!(flat > 20, "{name}: the crown was seen at {flat} places");
    }
}

#[test]
fn ripples_have_their_pitch_and_height_and_a_crater_its_depth() {
    let crown = |mesh: &Mesh| -> Vec<DVec3> {
        let along = mesh.positions.iter().filter(|p| p.y.abs() < 1e-12 && p.z > 0.0 && (0.0..=0.1).contains(&p.x));
        along.copied().collect()
    };
    let (rippled, _) = formed(FormRequest {
        ripples: Some(Ripples { pitch: 0.005, height: 0.2, chevron: 0.0 }),
        ..FormRequest::default()
    });
    let heights: Vec<f64> = crown(&rippled).iter().map(|p| p.z).collect();
    let peaks = heights.windows(3).filter(|z| z[1] > z[0] && z[1] >= z[2]).count();
    assert!((19..=20).contains(&peaks), "{peaks} ripples on 100 mm with a pitch of 5 mm");
    let span = heights.iter().copied().fold(0.0, f64::max) - heights.iter().copied().fold(1.0, f64::min);
    assert!((span / (0.2 * PROFILE.height) - 1.0).abs() < 0.1, "{span}");
    let (cratered, _) =
        formed(FormRequest { crater: Some(Crater { depth: 0.6, hump: 0.0 }), ..FormRequest::default() });
    let end = crown(&cratered).into_iter().find(|p| (p.x - 0.1).abs() < 1e-12).unwrap();
    assert!((end.z - 0.4 * PROFILE.height).abs() < 1e-9, "{}", end.z);
}

#[test]
fn toes_are_rounded_to_the_radius_asked() {
    // On two planes at the toe angle: the blend's curve X(Y) across the bisector, and its radius of curvature.
    let (radius, half) = (1.8e-3, 0.5 * PROFILE.toe_angle());
    let r = PROFILE.blend_radius(radius);
    let x = |y: f64| (0.25 * r + (half.sin() * y).powi(2) / r) / half.cos();
    let step = 1e-6;
    let bend = (x(step) - 2.0 * x(0.0) + x(-step)) / (step * step);
    assert!((1.0 / bend / radius - 1.0).abs() < 1e-3, "{}", 1.0 / bend);
    // In the field: the bisector of a straight bead's toe is filled up to that point.
    let plate = shapes::cuboid(DVec3::new(-0.02, -0.02, -0.01), DVec3::new(0.12, 0.02, 0.0));
    let options = BakeOptions { band_voxels: 4.0, ..BakeOptions::with_voxel(0.25e-3) };
    let field = |mesh: &Mesh| bake(mesh, &options).unwrap().0;
    let (plate, bead) = (field(&plate), field(&sweep(&circular(0.1, 0.0, 160), &PROFILE, ROOT).unwrap()));
    let (sharp, rounded) = (plate.united_with(&bead, 1).unwrap(), plate.blended_with(&bead, 1, r).unwrap());
    let bisector = DVec3::new(0.0, half.sin(), half.cos());
    for s in [0.02, 0.0513, 0.08] {
        let at = |out: f64| DVec3::new(s, 0.5 * PROFILE.width, 0.0) + out * bisector;
        assert!((rounded.sample(at(x(0.0))) as f64).abs() < 3e-5, "{}", rounded.sample(at(x(0.0))));
        assert!(sharp.sample(at(x(0.0))) as f64 > 1e-4);
        assert_eq!(rounded.label(at(0.8 * x(0.0))), 1, "what fills the toe is weld metal");
    }
    assert!(plate.blended_with(&bead, 1, 0.9e-3).is_err(), "farther than the band knows");
}

#[test]
fn pores_and_sags_are_where_the_truth_says() {
    let (mesh, form) = formed(FormRequest { pores: 4, sagging: 0.4, ..FormRequest::default() });
    let tree = WindingTree::new(&mesh);
    assert_eq!(form.defects().len(), 5);
    for defect in form.defects() {
        assert_eq!(defect.kind.iso_6520(), if defect.kind == DefectKind::Sagging { 509 } else { 2017 });
        let (x, y) = (defect.arc_length, defect.offset);
        let whole = PROFILE.height_at(y);
        let sunk = defect.depth / PROFILE.height * whole;
        assert!(tree.winding_number(DVec3::new(x, y, whole - 0.6 * sunk)) < 0.5, "{defect:?} is filled");
    }
}
