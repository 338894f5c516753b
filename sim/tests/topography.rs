//! The scanner's effects on a known surface: each follows its formula, and changes nothing at its null value.

mod common;

use common::{model, plate};
use effects::{CompiledModel, Hook, Library, Model, Process, RowCounts, StepValues, Variable};
use glam::{DVec2, DVec3};
use sdf_bake::{BrickGrid, HeightMap, PixelGrid};
use sim::{Profilometer, Topography};

const PITCH: f64 = 0.25e-3;
const RADIUS: f64 = 0.02;

/// Pixels on the top of a ball, where it is not steep.
fn pixels() -> PixelGrid {
    PixelGrid { origin: DVec2::new(-6e-3, -4e-3), pitch: PITCH, nx: 49, ny: 33 }
}

fn ball() -> BrickGrid {
    BrickGrid::from_distance(DVec3::splat(-RADIUS), DVec3::splat(RADIUS), PITCH, 3.0, |p| p.length() - RADIUS)
}

/// Height of the ball, its gradient and its Laplacian.
fn exact(p: DVec2) -> (f64, DVec2, f64) {
    let z = (RADIUS * RADIUS - p.length_squared()).sqrt();
    (z, -p / z, -(2.0 / z + p.length_squared() / z.powi(3)))
}

/// Asserts that an effect adds `expected` to the ball's heights, within `share` of the largest addition.
fn adds(effect: &str, values: &[(&str, &str)], share: f64, expected: impl Fn(DVec2) -> f64) {
    let text: String = values.iter().map(|(name, value)| format!("{name} = \"{value}\"\n")).collect();
    let model = model(&format!("process = \"grinding\"\n[effect.{effect}]\n{text}"));
    let topography = Topography::read(&ball(), pixels(), &model);
    let reported = topography.reported(&model, &StepValues::new()).expect("heights");
    let expected = HeightMap::from_function(pixels(), expected).heights;
    let largest = expected.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    assert!(largest > 1e-7, "{effect} does nothing here");
    let inner = |k: &usize| (1..48).contains(&(k % 49)) && (1..32).contains(&(k / 49));
    let off = |k: usize| (reported.heights[k] - topography.map.heights[k] - expected[k]).abs();
    let worst = (0..expected.len()).filter(inner).map(off).fold(0.0, f64::max);
    println!("{effect}: up to {:.2} µm, off by {:.1e} of it", largest * 1e6, worst / largest);
    assert!(worst < share * largest, "{effect}");
}

#[test]
fn each_effect_of_the_scanner_changes_the_heights_by_its_formula() {
    adds("height-gain", &[("gain", "2 %")], 1e-4, |p| 0.02 * exact(p).0);
    adds("slope-bias", &[("bias", "50 um")], 1e-3, |p| 50e-6 * exact(p).1.length_squared());
    adds("lateral-blur", &[("blur", "200 um")], 0.01, |p| 0.5 * 4e-8 * exact(p).2);
    adds("stitching", &[("step", "-7 um"), ("border", "1 mm")], 1e-9, |p| if p.x > 1e-3 { -7e-6 } else { 0.0 });
    let plane = [("piston", "20 um"), ("tilt_x", "1 mrad"), ("tilt_y", "-0.5 mrad")];
    adds("scan-tilt", &plane, 1e-9, |p| 20e-6 + 1e-3 * p.x - 0.5e-3 * p.y);
    let shift = [("shift_x", "30 um"), ("shift_y", "-20 um"), ("yaw", "2 mrad")];
    adds("scan-shift", &shift, 2e-3, |p| exact(p).1.dot(DVec2::new(30e-6, -20e-6) + 2e-3 * p.perp()));
}

#[test]
fn every_effect_of_the_scanner_is_tried_here() {
    let tried = ["height-gain", "slope-bias", "lateral-blur", "stitching", "scan-tilt", "scan-shift"];
    for effect in Library::builtin().effects() {
        let scans = effect.changes.iter().any(|change| change.hook == Hook::Height);
        assert_eq!(scans, tried.contains(&effect.name.as_str()), "{}", effect.name);
    }
}

/// All effects of the scanner at their null values.
fn at_null() -> CompiledModel {
    let scans = |effect: &&effects::Effect| effect.changes.iter().any(|change| change.hook == Hook::Height);
    let effects = Library::builtin().effects().iter().filter(scans);
    let model = effects.fold(Model::new(Process::Grinding), |model, effect| model.with(&effect.name));
    let mut model = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model");
    for slot in 0..model.parameters().len() {
        if let Some(null) = model.parameters()[slot].null {
            model.set(slot, null);
        }
    }
    model
}

#[test]
fn at_null_the_heights_keep_their_bits_and_holes_stay_holes() {
    // A plate that ends within the pixels.
    let half = DVec3::new(4e-3, 3e-3, 2e-3);
    let part = BrickGrid::from_distance(-half, half, PITCH, 3.0, |p| {
        let out = p.abs() - half;
        out.max(DVec3::ZERO).length() + out.max_element().min(0.0)
    });
    let bits = |map: &HeightMap| -> Vec<u64> { map.heights.iter().map(|height| height.to_bits()).collect() };
    for part in [&part, &ball()] {
        let sharp = Profilometer::sharp(pixels()).heights(part);
        let model = at_null();
        let seen = Topography::read(part, pixels(), &model).reported(&model, &StepValues::new()).expect("heights");
        assert_eq!(bits(&seen), bits(&sharp));
    }
    let tilted = model("process = \"grinding\"\n[effect.scan-tilt]\npiston = \"5 um\"\n[effect.lateral-blur]\n");
    let seen = Topography::read(&part, pixels(), &tilted).reported(&tilted, &StepValues::new()).expect("heights");
    assert_eq!(seen.missing(), Profilometer::sharp(pixels()).heights(&part).missing());
    assert!(seen.missing() > 100);
}

const ALL_THAT_IS_KEPT: &str = r#"
name = "kept"
title = "Reads all that the field keeps"
source = "none"

[parameters.amount]
unit = "um"
null = 0.0
range = [-10.0, 10.0]
default = 1.0

[modify]
height = "height + amount * (removed_depth / 1 mm + 10 * dose + 100 * label + 1000 * pass_number)"
"#;

#[test]
fn the_scanner_reads_what_the_field_keeps() {
    let library = Library::builtin().with(&[("kept.toml".to_owned(), ALL_THAT_IS_KEPT.to_owned())]).expect("an effect");
    let model = Model::new(Process::Grinding).with("kept");
    let model = CompiledModel::new(&model, &library, RowCounts::default()).expect("a model");
    let mut part = plate(0.5e-3, 0.0);
    let pixels = PixelGrid { origin: DVec2::splat(-2e-3), pitch: 0.5e-3, nx: 9, ny: 9 };
    let mut step = StepValues::new();
    step.set(Variable::PassNumber, 2.0);
    let reported = |part: &BrickGrid| {
        let seen = Topography::read(part, pixels, &model);
        let map = seen.reported(&model, &step).expect("heights");
        (map.heights[40] - seen.map.heights[40]) * 1e6
    };
    assert!((reported(&part) - 2000.0).abs() < 1e-6, "{}", reported(&part));
    part.removed = vec![2e-3; part.phi.len()];
    part.dose = vec![0.5; part.phi.len()];
    part.label = vec![3; part.phi.len()];
    assert!((reported(&part) - 2307.0).abs() < 1e-3, "{}", reported(&part));
}
