//! Dose of a spinning pad against its closed forms, level and tilted by an effect.

mod common;

use std::f64::consts::PI;

use common::forms::{number, pad_dose, shared_cases, tilted_pad_dose};
use common::{fresh, line};
use effects::{CompiledModel, Library, Model, Process as Kind, RowCounts};
use glam::DVec3;
use robot::{Controller, Pad, Tool};
use sdf_bake::BrickGrid;
use sim::contact::{ContactCells, Ground};
use sim::height_field::{Facing, HeightField, Window};
use sim::region::Region;
use sim::{Frame, Pass, PassRecord, PassSettings, Path, PathSample, Placement, Pose, run_pass};

const VOXEL: f64 = 0.5e-3;
/// K_P/h_c [1/(Pa m)].
const SANDING_RATE: f64 = 2e-5;

fn sanding(stiffness: f64, sanding_rate: f64, tilt: f64) -> CompiledModel {
    let mut model = Model::new(Kind::Sanding);
    if tilt != 0.0 {
        model = model.with("tool-tilt");
        model.set("tool-tilt", "roll_angle", &[0.0]);
        model.set("tool-tilt", "pitch_angle", &[tilt]);
    }
    model.set("winkler", "stiffness", &[stiffness]);
    model.set("preston-sanding", "sanding_rate", &[sanding_rate]);
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model")
}

/// Moves a pad over flat work along +x with its face at z = -`depth`, and returns the dose at x = 0 and each of
/// `places`, rounded to whole voxels.
fn doses(
    radius: f64,
    (settings, model, depth): (&PassSettings, &CompiledModel, f64),
    feed: f64,
    places: &[f64],
) -> (PassRecord, Vec<(f64, f64)>) {
    // The pad is on the work from its first step to its last.
    let reach = radius + 2e-3;
    let half = DVec3::new(2.0 * reach + 2e-3, reach + 2e-3, 1e-3);
    let mut grid = BrickGrid::from_distance(-half, half, VOXEL, 3.0, |p| p.z);
    let path = Path::along(&line(-reach, reach, -depth), feed).expect("a path");
    let tool = Tool::from(Pad { radius });
    let pass = Pass::first(&tool, &path, settings, model);
    let record = run_pass(&mut grid, pass, &mut fresh(model), &mut |_| {}).expect("a pass");
    let across = (reach / VOXEL) as i32;
    let window = Window { low: [-1, -across], size: [3, 2 * across as usize + 1] };
    let height_field = HeightField::read(&grid, Facing::of(DVec3::Z), window, 1e-3, -1e-3);
    let at = |y: &f64| {
        let column = (y / VOXEL).round() as i32;
        (f64::from(column) * VOXEL, height_field.dose[window.size[1] + (column + across) as usize])
    };
    (record, places.iter().map(at).collect())
}

fn report(what: &str, y: f64, found: f64, exact: f64) {
    let error = found / exact - 1.0;
    println!("{what}, y = {:+.1} mm: dose {found:.5}, exact {exact:.5}, {:+.3} %", y * 1e3, error * 100.0);
    assert!(error.abs() < 5e-3);
}

#[test]
fn a_level_pad_leaves_the_dose_of_the_closed_form() {
    let (radius, feed, force) = (0.0125, 0.03, 10.0);
    for spin in [400.0, 3.0] {
        let settings = PassSettings { force_setpoint: force, spindle_speed: spin, ..PassSettings::default() };
        let model = sanding(1e8, SANDING_RATE, 0.0);
        let (record, found) = doses(radius, (&settings, &model, 0.0), feed, &[-0.011, -0.007, 0.0, 0.004, 0.009]);
        assert!(record.coating_volume > 0.0 && record.removed_volume == 0.0);
        for (y, dose) in found {
            let pressure = force / (PI * radius * radius);
            let exact = SANDING_RATE * pressure / feed * pad_dose(radius, (spin, feed), y);
            report(&format!("level, {spin} rad/s"), y, dose, exact);
        }
    }
}

#[test]
fn a_pad_tilted_by_an_effect_leaves_the_dose_of_the_closed_form() {
    let (radius, feed, spin, stiffness) = (0.0125, 0.03, 400.0, 1e8);
    for (depth, tilt) in [(2e-4, 0.01), (5e-5, 0.02), (-5e-5, -0.02)] {
        let settings = PassSettings { controller: Controller::Replay, spindle_speed: spin, ..PassSettings::default() };
        let model = sanding(stiffness, SANDING_RATE, tilt);
        let (_, found) = doses(radius, (&settings, &model, depth), feed, &[-0.009, 0.0, 0.004]);
        for (y, dose) in found {
            let form = tilted_pad_dose(radius, (spin, feed), (depth, tilt), y);
            report(
                &format!("tilted {tilt} rad, {:.0} µm", depth * 1e6),
                y,
                dose,
                SANDING_RATE * stiffness / feed * form,
            );
        }
    }
}

#[test]
fn shared_examples_of_doses_hold() {
    for (inputs, outputs) in &shared_cases("dose_pad") {
        let [rate, force, radius, spin, feed, y] = ["C", "F", "rho", "om", "v", "y"].map(|name| number(inputs, name));
        let per = rate * force / (PI * radius * radius) / feed;
        assert!((per * pad_dose(radius, (spin, feed), y) / number(outputs, "value") - 1.0).abs() < 1e-9);
        let settings = PassSettings { force_setpoint: force, spindle_speed: spin, ..PassSettings::default() };
        let (_, found) = doses(radius, (&settings, &sanding(1e7, rate, 0.0), 0.0), feed, &[y]);
        report("shared", found[0].0, found[0].1, per * pad_dose(radius, (spin, feed), found[0].0));
    }
    for (inputs, outputs) in &shared_cases("dose_pad_tilted") {
        let names = ["C", "K", "rho", "h", "th", "om", "v", "y"];
        let [rate, stiffness, radius, depth, tilt, spin, feed, y] = names.map(|name| number(inputs, name));
        let form = |y: f64| rate * stiffness / feed * tilted_pad_dose(radius, (spin, feed), (depth, tilt), y);
        assert!((form(y) / number(outputs, "value") - 1.0).abs() < 1e-6);
        let settings = PassSettings { controller: Controller::Replay, spindle_speed: spin, ..PassSettings::default() };
        let (_, found) = doses(radius, (&settings, &sanding(stiffness, rate, tilt), depth), feed, &[y]);
        report("shared, tilted", found[0].0, found[0].1, form(found[0].0));
    }
}

/// Dose per pressure [s m/s] at a point: the slip speed under a spinning pad, times the time under it.
fn dose_along(path: &Path, (radius, spin): (f64, f64), place: DVec3) -> f64 {
    let steps = 200_000;
    let dt = path.duration() / f64::from(steps);
    let slip = |k: i32| {
        let time = (f64::from(k) + 0.5) * dt;
        let from_axis = place - path.at(time).position;
        let slip = spin * DVec3::Z.cross(from_axis) + path.velocity(time);
        if from_axis.length() < radius { slip.length() * dt } else { 0.0 }
    };
    (0..steps).map(slip).sum()
}

#[test]
fn a_pad_that_turns_a_corner_leaves_the_dose_of_its_slip() {
    let (radius, feed, spin, force, stiffness) = (0.008, 0.02, 40.0, 10.0, 1e8);
    // As in a log: a sample every hundredth of a second, round a corner that no sample hits.
    let corner = 0.0301;
    let place = |way: f64| DVec3::new(way.min(corner), (way - corner).max(0.0), 0.0) - DVec3::new(0.015, 0.015, 0.0);
    let samples = (0..=300).map(f64::from).map(|k| PathSample {
        time: 0.01 * k,
        position: place(0.01 * k * feed),
        approach: DVec3::Z,
        axis: DVec3::Y,
    });
    let path = Path::from_samples(samples.collect()).unwrap();
    let half = DVec3::new(0.026, 0.026, 1e-3);
    let mut grid = BrickGrid::from_distance(-half, half, VOXEL, 3.0, |p| p.z);
    let settings = PassSettings { force_setpoint: force, spindle_speed: spin, ..PassSettings::default() };
    let model = sanding(stiffness, SANDING_RATE, 0.0);
    let tool = Tool::from(Pad { radius });
    let pass = Pass::first(&tool, &path, &settings, &model);
    let record = run_pass(&mut grid, pass, &mut fresh(&model), &mut |_| {}).expect("a pass");
    let window = Window { low: [-48, -48], size: [97, 97] };
    let height_field = HeightField::read(&grid, Facing::of(DVec3::Z), window, 1e-3, -1e-3);
    println!("{} steps", record.steps);
    for (x, y) in [(-5.0, -15.0), (5.0, -20.0), (12.0, -15.0), (15.0, -13.0), (18.0, -17.0), (12.0, -10.0), (19.0, 0.0)]
    {
        let place = DVec3::new(x, y, 0.0) * 1e-3;
        let column = |along: f64| ((along * 1e-3 / VOXEL).round() + 48.0) as usize;
        let found = height_field.dose[column(x) * window.size[1] + column(y)];
        let exact = SANDING_RATE * force / (PI * radius * radius) * dose_along(&path, (radius, spin), place);
        report(&format!("round a corner, x = {x} mm"), place.y, found, exact);
    }
}

#[test]
fn a_pad_that_only_sinks_in_is_measured_as_by_a_full_measurement() {
    let half = DVec3::new(0.016, 0.016, 2e-3);
    // A plate with a bead across it, and a hole beside that.
    let bead = |p: DVec3| (p - DVec3::new(0.002, 0.0, -0.003)).reject_from(DVec3::Y).length() - 0.004;
    let hole = |p: DVec3| (p - DVec3::new(-0.006, 0.003, 0.0)).truncate().length() - 0.002;
    let grid = BrickGrid::from_distance(-half, half, VOXEL, 3.0, |p| p.z.min(bead(p)).max(-hole(p)));
    let window = Window { low: [-30, -30], size: [61, 61] };
    let height_field = HeightField::read(&grid, Facing::of(DVec3::Z), window, 2e-3, -1e-3);
    let (tool, region) = (Tool::from(Pad { radius: 0.0125 }), Region::inside(&window));
    let ground = Ground { height_field: &height_field, region: &region };
    let sweep = DVec3::new(1e-3, 4e-4, -3e-5);
    let (mut steady, mut wet) = (ContactCells::default(), Vec::new());
    for tilt in [0.0, 4e-3] {
        let frame = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z }.tilted(tilt, -0.5 * tilt);
        let pose = |sunk: f64| Pose { centre: DVec3::new(3e-4, -2e-4, -sunk), approach: DVec3::Z, frame };
        let place = |sunk: f64| Placement { tool: &tool, pose: pose(sunk), sweep };
        steady.measure(&place(-9e-4), &ground, &[]);
        for sunk in [-9e-4, -8.99e-4, -8e-4, 1e-4, 5e-4, 5.1e-4, 5.05e-4, 3e-4, -2e-4] {
            if !steady.measure_deeper(&place(sunk), &height_field) {
                steady.measure(&place(sunk), &ground, &[]);
                assert_ne!(tilt, 0.0, "a level pad does not move across its axis");
            }
            let mut measured_again = ContactCells::default();
            measured_again.measure(&place(sunk), &ground, &[]);
            assert_eq!(steady.wet, measured_again.wet, "{tilt} rad, {sunk} m");
            for line in measured_again.wet.list().iter().map(|line| *line as usize) {
                let off = |of: fn(&ContactCells) -> &[f64]| (of(&steady)[line] - of(&measured_again)[line]).abs();
                // A tilted pad may move across its axis by a thousandth of a voxel: the share of a cell under it
                // changes by as much.
                let (share, depth) = if tilt == 0.0 { (1e-10, 1e-14) } else { (2e-3, 2e-6) };
                assert!(
                    off(|contact_cells| &contact_cells.share) < share
                        && off(|contact_cells| &contact_cells.area) < share
                );
                assert!(off(|contact_cells| &contact_cells.mean_depth) < depth);
            }
            wet.push(measured_again.wet.len());
        }
    }
    println!("squares in contact: {wet:?}");
    assert!(wet.iter().any(|count| *count < 500) && wet.iter().any(|count| *count > 1900));
}
