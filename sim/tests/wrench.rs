//! The wrench of a contact against closed forms, on a face of every direction.

use std::f64::consts::PI;

use effects::{CompiledModel, Library, Model, Process, RowCounts, States};
use glam::DVec3;
use robot::{Controller, Pad, Tool, Wheel};
use sdf_bake::BrickGrid;
use sim::{Pass, PassSettings, Path, PathSample, TOOL_CELLS, Wrench, WrenchGauge, run_pass};

/// The six directions of faces.
const FACES: [DVec3; 6] = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z];

fn model(process: Process) -> CompiledModel {
    CompiledModel::new(&Model::new(process), Library::builtin(), RowCounts::default()).expect("a model")
}

/// Returns the wrench and the log's force [N] of a tool that stands with its lowest point at a depth [m] in the middle
/// of a face, its axis turned out of the face's plane by `tilt` [rad].
fn press(tool: &Tool, face: DVec3, (depth, tilt): (f64, f64), friction: f64) -> (Wrench, f64) {
    let half = DVec3::splat(0.012);
    let mut part = BrickGrid::from_distance(-half, half, 0.5e-3, 4.0, |p| p.dot(face));
    let across = face.any_orthonormal_vector();
    let (sine, cosine) = tilt.sin_cos();
    let (approach, axis) = (face * cosine - across * sine, across * cosine + face * sine);
    let sample = |time| PathSample { time, position: face * -depth, approach, axis };
    let path = Path::from_samples(vec![sample(0.0), sample(1e-3)]).expect("a path");
    let model = model(Process::Sanding);
    let settings = PassSettings { controller: Controller::Replay, ..PassSettings::default() };
    let gauge = WrenchGauge::new(friction);
    let pass = Pass { gauge: Some(&gauge), ..Pass::first(tool, &path, &settings, &model) };
    let record = run_pass(&mut part, pass, &mut States::new(&model, TOOL_CELLS), &mut |_| {}).expect("a pass");
    (gauge.read(), record.impulse / path.duration())
}

#[test]
fn a_level_pad_is_pushed_out_of_every_face() {
    let (radius, depth) = (5e-3, 2e-4);
    let stiffness = model(Process::Sanding).law_value("stiffness").expect("a stiffness");
    let force = stiffness * PI * radius * radius * depth;
    for face in FACES {
        let (wrench, logged) = press(&Pad { radius }.into(), face, (depth, 0.0), 0.0);
        assert!((wrench.force - face * force).length() < 5e-3 * force, "{face}: {} of {force}", wrench.force);
        assert!((wrench.force.dot(face) - logged).abs() < 1e-9 * force, "{face}: {logged}");
        assert!(wrench.torque.length() < 1e-3 * force * radius, "{face}: {}", wrench.torque);
    }
}

#[test]
fn a_tilted_pad_is_turned_back_on_every_face() {
    let (radius, depth, tilt) = (5e-3f64, 4e-4f64, 0.02f64);
    let stiffness = model(Process::Sanding).law_value("stiffness").expect("a stiffness");
    // The patch lies beside the middle of the tilted face by the depth times the tangent of the tilt.
    let moment = stiffness * PI * radius.powi(2) * (tilt.sin() * radius.powi(2) / 4.0 + depth.powi(2) * tilt.tan());
    for face in FACES {
        let across = face.any_orthonormal_vector();
        let (wrench, _) = press(&Pad { radius }.into(), face, (depth, tilt), 0.0);
        // The tilt about face × across raises the edge at +across. The torque turns against it.
        let turn = across.cross(face);
        assert!((wrench.torque - turn * -moment).length() < 0.02 * moment, "{face}: {} of {moment}", wrench.torque);
    }
}

#[test]
fn friction_pushes_a_wheel_against_its_rim_and_spin() {
    let (radius, depth, friction) = (20e-3, 1e-4, 0.3);
    let tool = Tool::from(Wheel::cylinder(radius, 6e-3));
    for face in FACES {
        let axis = face.any_orthonormal_vector();
        let [(smooth, _), (rough, _)] = [0.0, friction].map(|share| press(&tool, face, (depth, 0.0), share));
        let normal = smooth.force.dot(face);
        // The rim under the axis moves along face × axis.
        let rim = face.cross(axis);
        let drag = rough.force - smooth.force;
        assert!((drag + rim * friction * normal).length() < 1e-3 * normal, "{face}: {drag}");
        let turn = rough.torque - smooth.torque;
        let expected = axis * (-friction * normal * (radius - depth));
        assert!((turn - expected).length() < 0.02 * expected.length(), "{face}: {turn} of {expected}");
    }
}

#[test]
fn there_is_no_wrench_in_the_air() {
    assert_eq!(press(&Pad { radius: 5e-3 }.into(), DVec3::Z, (-1e-3, 0.0), 0.3).0, Wrench::default());
}
