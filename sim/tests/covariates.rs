//! Covariates of the surface, compared with the totals of the pass.

use std::cell::RefCell;

use effects::{CompiledModel, Library, Model, RowCounts, States};
use glam::{DVec2, DVec3};
use robot::{Tool, Wheel};
use sdf_bake::{BrickGrid, PixelGrid};
use sim::{Covariates, CurvePoint, Pass, PassRecord, PassSettings, Path, TOOL_CELLS, run_pass};

const VOXEL: f64 = 0.25e-3;
const FEED: f64 = 5e-3;
const FORCE: f64 = 15.0;
const RADIUS: f64 = 0.05;
const WIDTH: f64 = 8e-3;
const STIFFNESS: f64 = 1e10;
/// Laws that remove nothing, and laws that do.
const HARD: &str = "[law.preston-threshold]\nthreshold_pressure = \"1e4 MPa\"\n";
const SOFT: &str = "[law.preston-threshold]\nthreshold_pressure = \"0 MPa\"\n";

/// A wheel along a flat plate, on `length` [m] about the origin.
fn pass(length: f64, laws: &str) -> (PassRecord, Covariates) {
    let half = DVec3::new(0.02, 0.008, 0.004);
    let mut part = BrickGrid::from_distance(-half, half, VOXEL, 3.0, |p: DVec3| p.z);
    let curve = [-0.5, 0.5].map(|x| CurvePoint { position: DVec3::X * x * length, normal: DVec3::Z });
    let path = Path::along(&curve, FEED).unwrap();
    let tool = Tool::from(Wheel::cylinder(RADIUS, WIDTH));
    let model = Model::parse_beyond_ranges(
        "model",
        &format!("process = \"grinding\"\n[law.winkler]\nstiffness = \"{STIFFNESS:e} Pa/m\"\n{laws}"),
        Library::builtin(),
    )
    .unwrap();
    let model = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap();
    let map = PixelGrid { origin: DVec2::new(-0.015, -0.006), pitch: VOXEL, nx: 121, ny: 49 };
    let covariates = RefCell::new(Covariates::over(&map, VOXEL));
    let settings = PassSettings { force_setpoint: FORCE, ..PassSettings::default() };
    let pass = Pass { covariates: Some(&covariates), ..Pass::first(&tool, &path, &settings, &model) };
    let record = run_pass(&mut part, pass, &mut States::new(&model, TOOL_CELLS), &mut |_| {}).unwrap();
    (record, covariates.into_inner())
}

#[test]
fn pressures_add_up_to_the_impulse_and_depths_to_the_volume() {
    let total = |values: &[f64]| VOXEL * VOXEL * values.iter().sum::<f64>();
    let (record, covariates) = pass(0.01, HARD);
    let impulse_off = total(&covariates.pressure_time) / record.load_impulse - 1.0;
    assert!(impulse_off.abs() < 1e-9);
    let (record, covariates) = pass(0.01, SOFT);
    let force_off = total(&covariates.pressure_time) / record.impulse - 1.0;
    let volume_off = total(&covariates.removed) / record.removed_volume - 1.0;
    println!("impulses off by {impulse_off:.1e} and {force_off:.1e}, volume by {volume_off:.1e}");
    // The groove's side faces have more surface than the lattice under them, which counts for the volume but not for
    // the force.
    assert!(force_off.abs() < 1e-9);
    assert!(volume_off < 0.0 && volume_off > -0.01);
}

#[test]
fn a_place_is_touched_for_patch_length_over_feed() {
    // Nothing is removed, so the patch is that of a cylinder pressed into a plate: depth δ - x²/(2R), half length
    // a = √(2Rδ), force K b 4/3 δ a.
    let (_, covariates) = pass(0.02, HARD);
    let depth = (FORCE / (STIFFNESS * WIDTH * 4.0 / 3.0 * (2.0 * RADIUS).sqrt())).powf(2.0 / 3.0);
    let length = 2.0 * (2.0 * RADIUS * depth).sqrt();
    let at = |values: &[f64], x: f64| values[covariates.pixels.nearest(DVec2::new(x, 0.0)).unwrap()];
    let time = at(&covariates.contact_time, 0.0);
    let pressure_time = at(&covariates.pressure_time, 0.0);
    println!(
        "{:.2e} off in time, {:.2e} in pressure",
        time * FEED / length - 1.0,
        pressure_time * FEED * WIDTH / FORCE - 1.0
    );
    assert!((time * FEED / length - 1.0).abs() < 0.01);
    assert!((pressure_time * FEED * WIDTH / FORCE - 1.0).abs() < 0.01);
    assert!((at(&covariates.mean_pressure(), 0.0) - pressure_time / time).abs() < 1.0);
    let peak = at(&covariates.peak_pressure, 0.0);
    assert!((peak / (STIFFNESS * depth) - 1.0).abs() < 0.02, "{peak} Pa, {} Pa under the axis", STIFFNESS * depth);
    let (ahead, behind) = (at(&covariates.first_contact, 4e-3), at(&covariates.first_contact, -4e-3));
    assert!((ahead - behind - 8e-3 / FEED).abs() < 2.0 * VOXEL / FEED, "{ahead} {behind}");
    let speed = PassSettings::default().spindle_speed * RADIUS;
    assert!((at(&covariates.slip_way, 0.0) / (speed * time) - 1.0).abs() < 1e-3);
    assert_eq!(at(&covariates.removed, 0.0), 0.0);
}
