//! Many trials at once, and their failures.

use std::process::Command;

use crate::common::{base, fresh, line, model};
use crate::device;
use crate::faulty_driver::{can_be_made, counted, with_faults};
use effects::CompiledModel;
use glam::DVec3;
use robot::{Tool, Wheel};
use sdf_bake::BrickGrid;
use shaders::device::FaultKind;
use shaders::simulate::{SimulateError, TrialCapacity};
use shaders::testing::{self, lose};
use sim::gpu::{GpuError, Settings, Trial, refusal_of, run_batch, run_pass};
use sim::{Pass, PassSettings, Path};

fn slab() -> BrickGrid {
    let half = DVec3::new(0.010, 0.006, 0.003);
    BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.z - 0.13e-3)
}

fn tool() -> Tool {
    Tool::from(Wheel::cylinder(0.02, 0.004))
}

fn path() -> Path {
    Path::along(&line(-1e-3, 1e-3, 0.13e-3), 5e-3).unwrap()
}

#[test]
fn trials_in_a_batch_leave_the_same_bits_as_alone_whatever_room_they_begin_with() {
    let Some(device) = device() else { return };
    let (part, tool, path, settings) =
        (slab(), tool(), path(), PassSettings { force_setpoint: 5.0, ..PassSettings::default() });
    let mut models: Vec<CompiledModel> = (0..3).map(|_| base()).collect();
    for (n, model) in models.iter_mut().enumerate() {
        let at = model.index("preston-threshold.grind_rate").unwrap();
        model.set(at, 1e-9 * (1 + n) as f64);
    }
    let tools: Vec<_> = models.iter().map(fresh).collect();
    let trials: Vec<Trial> = models
        .iter()
        .zip(&tools)
        .map(|(model, states)| Trial { part: &part, pass: Pass::first(&tool, &path, &settings, model), tool: states })
        .collect();
    // One brick and a few lines: both must grow.
    let tight = Settings { capacity: TrialCapacity { bricks: 1, lines: 16, ticks: 64 }, most_trials: 2 };
    let batch = run_batch(device, &trials, tight, &mut |_, _| {});
    let mut volumes = Vec::new();
    for (outcome, trial) in batch.into_iter().zip(&trials) {
        let outcome = outcome.unwrap();
        let (mut alone, mut states) = (part.clone(), trial.tool.clone());
        let record = run_pass(device, &mut alone, trial.pass, &mut states, &mut |_| {}).unwrap();
        assert_eq!(outcome.record.unwrap(), record);
        assert_eq!(outcome.part, alone);
        volumes.push(record.removed_volume);
    }
    assert!(volumes.windows(2).all(|pair| pair[1] > 1.2 * pair[0]), "{volumes:?}");
}

#[test]
fn what_the_device_does_not_run_is_refused_by_name() {
    let edge = model("process = \"grinding\"\n[effect.edge-pressure]\n");
    let refused = refusal_of(&tool(), &edge).expect("a refusal");
    assert!(refused.contains("edge_distance"), "{refused}");
    assert_eq!(refusal_of(&tool(), &base()), None);
}

#[test]
fn a_device_that_is_lost_or_too_small_is_named_and_the_part_kept() {
    let Some(device) = testing::device("a lost device") else { return };
    let (part, tool, path, settings, model) = (slab(), tool(), path(), PassSettings::default(), base());
    let pass = Pass::first(&tool, &path, &settings, &model);
    let states = fresh(&model);
    let trial = Trial { part: &part, pass, tool: &states };
    let vast =
        Settings { capacity: TrialCapacity { bricks: 10_000_000, ..TrialCapacity::default() }, ..Settings::default() };
    let error = run_batch(&device, &[trial], vast, &mut |_, _| {}).remove(0).unwrap_err();
    assert!(matches!(error, GpuError::Device(SimulateError::TooLarge { array: "bricks", .. })), "{error}");
    assert!(error.to_string().contains(&device.adapter().name), "{error}");
    lose(&device);
    let (mut kept, mut kept_states) = (part.clone(), states.clone());
    let error = run_pass(&device, &mut kept, pass, &mut kept_states, &mut |_| {}).unwrap_err();
    assert!(is_loss(&error) && error.to_string().contains(&device.adapter().name), "{error}");
    assert_eq!((kept, kept_states), (part, states));
}

fn is_loss(error: &GpuError) -> bool {
    matches!(error, GpuError::Device(SimulateError::Device(fault)) if fault.kind == FaultKind::Lost)
}

#[test]
fn a_device_lost_in_the_middle_of_a_pass_fails_its_submission_and_not_the_one_before() {
    let (Some(shared), Some(device)) = (device(), testing::device("a device lost in a pass")) else { return };
    let (part, tool, path, settings, model) = (slab(), tool(), path(), PassSettings::default(), base());
    let pass = Pass::first(&tool, &path, &settings, &model);
    let states = fresh(&model);
    let trial = Trial { part: &part, pass, tool: &states };
    let one_by_one = Settings { capacity: TrialCapacity { ticks: 16, ..TrialCapacity::default() }, most_trials: 1 };
    let mut lost_at = None;
    let mut results = run_batch(&device, &[trial; 2], one_by_one, &mut |number, at| {
        if number == 1 && lost_at.is_none() {
            lost_at = Some(at.time / at.duration);
            lose(&device);
        }
    });
    assert!(lost_at.is_some_and(|share| share > 0.0 && share < 0.9), "{lost_at:?}");
    let error = results.remove(1).unwrap_err();
    assert!(is_loss(&error) && error.to_string().contains("the part is as it was before the pass"), "{error}");
    let (mut alone, mut tool_states) = (part.clone(), states.clone());
    let record = run_pass(shared, &mut alone, pass, &mut tool_states, &mut |_| {}).unwrap();
    let first = results.remove(0).unwrap();
    assert_eq!((first.part, first.record.unwrap()), (alone, record));
}

/// Also run by the test below in processes of their own whose memory runs out.
#[test]
fn four_trials_with_much_room_leave_the_bits_of_one_alone() {
    let Some(device) = device() else { return };
    let (part, tool, path, settings, model) = (slab(), tool(), path(), PassSettings::default(), base());
    let pass = Pass::first(&tool, &path, &settings, &model);
    let states = fresh(&model);
    let trial = Trial { part: &part, pass, tool: &states };
    // 12 MiB for each.
    let roomy =
        Settings { capacity: TrialCapacity { bricks: 6144, ..TrialCapacity::default() }, ..Settings::default() };
    let (mut alone, mut tool_states) = (part.clone(), states.clone());
    let ran = run_pass(device, &mut alone, pass, &mut tool_states, &mut |_| {});
    let record = ran.unwrap_or_else(|error| panic!("{error}"));
    for outcome in run_batch(device, &[trial; 4], roomy, &mut |_, _| {}) {
        let outcome = outcome.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((outcome.part, outcome.record), (alone.clone(), Ok(record.clone())));
    }
}

#[test]
fn a_batch_that_memory_does_not_hold_is_split_and_a_trial_that_it_does_not_hold_is_named() {
    if !can_be_made("a batch that memory does not hold") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (mebibytes, ends_well) in [("44", true), ("16", false)] {
        let notes = folder.path().join(mebibytes);
        let mut child = Command::new(std::env::current_exe().unwrap());
        child.args(["--exact", "batch::four_trials_with_much_room_leave_the_bits_of_one_alone", "--nocapture"]);
        let settings = [("MEMORY_MIB", mebibytes), ("NOTES", notes.to_str().unwrap())];
        let child = with_faults(&mut child, &settings).output().unwrap();
        let said = String::from_utf8_lossy(&child.stderr);
        assert_eq!(child.status.success(), ends_well, "{said}");
        // Drivers differ in the memory that they reserve, so the array that fails to be allocated differs, too.
        assert!(ends_well || said.contains("ran out of memory while"), "{said}");
        assert!(counted(&notes).1 > 0, "no allocation was refused with {mebibytes} MiB");
    }
}
