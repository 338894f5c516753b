//! Many simulations in one submission.

use std::collections::BTreeMap;

use rayon::prelude::*;
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use sdf_bake::grid::BRICK_VOXELS;
use shaders::Device;
use shaders::constants::{
    ABSENT, FAULT_DOSE, FAULT_FORCE, FAULT_POSE, FAULT_PRESSURE, FAULT_RATE, FAULT_SHAPE, FAULT_SPINDLE,
    FAULT_TOOL_STATE, STATUS_DONE, STATUS_FORMULA, STATUS_TOO_MANY_STEPS,
};
use shaders::layout::{RunHeader, TrialState};
use shaders::simulate::{Batch, Running, SimulateError, Simulator, TrialCapacity, TrialResults};

use super::setup::time_of;
use super::{GpuError, readback, refusal, setup};
use crate::measured::Readings;
use crate::pass::Progress;
use crate::physics::Physics;
use crate::record::PassRecord;
use crate::scheme::{StepLimits, scheme_of};
use crate::settings::{Pass, PassError};
use crate::tool_cells;
use effects::{CompiledModel, DeviceModel, Hook, Reset, States};

/// A pass on a part. Trials may share the part; each changes its own copy.
#[derive(Clone, Copy)]
pub struct Trial<'a> {
    /// The part before the pass.
    pub part: &'a BrickGrid,
    /// The pass.
    pub pass: Pass<'a>,
    /// States of the tool before the pass.
    pub tool: &'a States,
}

/// Result of a pass.
#[derive(Debug)]
pub struct Outcome {
    /// The part after the pass; if the pass failed, after the last good step.
    pub part: BrickGrid,
    /// States of the tool after the pass.
    pub tool: States,
    /// Log and results, or the error.
    pub record: Result<PassRecord, GpuError>,
}

/// Settings of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Initial memory of each trial; it grows if needed.
    pub capacity: TrialCapacity,
    /// Maximum number of trials in one submission.
    pub most_trials: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { capacity: TrialCapacity::default(), most_trials: 4096 }
    }
}

/// Runs one pass: changes `grid` and the tool's `states`, as [`crate::run_pass`] does.
///
/// # Errors
/// [`GpuError`]; where the device failed, grid and states are as they were.
pub fn run_pass(
    device: &Device,
    grid: &mut BrickGrid,
    pass: Pass,
    states: &mut States,
    progress: &mut dyn FnMut(Progress),
) -> Result<PassRecord, GpuError> {
    let trial = Trial { part: grid, pass, tool: states };
    let outcome = run_batch(device, &[trial], Settings::default(), &mut |_, at| progress(at)).remove(0)?;
    (*grid, *states) = (outcome.part, outcome.tool);
    outcome.record
}

/// Runs independent trials, as many at once as fit into the device's memory. Returns one result per trial, in their
/// order; `progress` gets a trial's index and its progress. A trial that does not fit even alone gets its own error. If
/// the device fails, all trials of that submission get its error; earlier submissions keep their results.
pub fn run_batch(
    device: &Device,
    trials: &[Trial],
    settings: Settings,
    progress: &mut dyn FnMut(usize, Progress),
) -> Vec<Result<Outcome, GpuError>> {
    let mut results: Vec<Option<Result<Outcome, GpuError>>> = trials.iter().map(|_| None).collect();
    // Trials whose models have the same formulas share a kernel.
    let mut groups: BTreeMap<String, (DeviceModel, Vec<Ready>)> = BTreeMap::new();
    for (number, trial) in trials.iter().enumerate() {
        match Ready::new(number, *trial) {
            Ok((model, ready)) => {
                groups.entry(model.text.clone()).or_insert_with(|| (model, Vec::new())).1.push(ready);
            }
            Err(error) => results[number] = Some(Err(error)),
        }
    }
    for (model, group) in groups.into_values() {
        let mut size = settings.most_trials.max(1);
        let mut rest = group.as_slice();
        while !rest.is_empty() {
            let (now, later) = rest.split_at(size.min(rest.len()));
            match run_group(device, &model, now, settings.capacity, progress) {
                Err(error) if now.len() > 1 && error.is_for_want_of_room() && device.loss().is_none() => {
                    size = now.len() / 2;
                    continue;
                }
                Err(error) => {
                    now.iter().for_each(|ready| results[ready.number] = Some(Err(GpuError::Device(error.clone()))));
                }
                Ok(outcomes) => {
                    now.iter().zip(outcomes).for_each(|(ready, outcome)| results[ready.number] = Some(Ok(outcome)));
                }
            }
            rest = later;
        }
    }
    results.into_iter().map(|result| result.expect("every trial was run or refused")).collect()
}

/// A trial that the device can run.
struct Ready<'a> {
    number: usize,
    trial: Trial<'a>,
    states: States,
    setup: shaders::layout::TrialSetup,
    step_limits: StepLimits,
    sands: bool,
    keeps_removed: bool,
}

impl<'a> Ready<'a> {
    fn new(number: usize, trial: Trial<'a>) -> Result<(DeviceModel, Self), GpuError> {
        let Trial { part, pass, tool } = trial;
        if let Some(what) = refusal(&pass) {
            return Err(GpuError::Unsupported(what));
        }
        let model = DeviceModel::new(pass.model, tool_cells::COUNT).expect("a model that is not refused");
        let mut states = tool.clone();
        states.reset(pass.model, Reset::Pass);
        Readings::new(pass.model, pass.measured).set_states(pass.model, 0.0, &mut states);
        let physics = Physics::new(pass.model, &mut states, pass.settings.coating);
        let (setup, step_limits) = setup::setup(part, &pass, &physics, scheme_of(&physics).as_ref())?;
        let (sands, keeps_removed) = (physics.sands(), physics.keeps_removed());
        Ok((model, Self { number, trial, states, setup, step_limits, sands, keeps_removed }))
    }
}

/// Planes of the brick pool that a group of trials needs.
fn header(group: &[Ready]) -> RunHeader {
    let mut header: RunHeader = bytemuck::Zeroable::zeroed();
    header.planes = 1;
    let mut plane = |is_there: bool| {
        if !is_there {
            return ABSENT;
        }
        header.planes += 1;
        header.planes - 1
    };
    let dose = plane(group.iter().any(|ready| ready.sands || !ready.trial.part.dose.is_empty()));
    let removed = plane(group.iter().any(|ready| ready.keeps_removed || !ready.trial.part.removed.is_empty()));
    let label = plane(group.iter().any(|ready| !ready.trial.part.label.is_empty()));
    RunHeader { dose_plane: dose, removed_plane: removed, label_plane: label, ..header }
}

/// The arrays of a group; a part that trials share is stored once.
fn batch(group: &[Ready], model: &DeviceModel) -> Batch {
    let header = header(group);
    let mut batch = Batch {
        header,
        setups: Vec::new(),
        states: Vec::new(),
        index: Vec::new(),
        bricks: Vec::new(),
        path: Vec::new(),
        values: Vec::new(),
    };
    let mut parts: Vec<(&BrickGrid, u32)> = Vec::new();
    for ready in group {
        let Trial { part, pass, .. } = ready.trial;
        let first_brick = match parts.iter().find(|(known, _)| std::ptr::eq(*known, part)) {
            Some((_, first)) => *first,
            None => {
                let first = (batch.bricks.len() / (header.planes as usize * BRICK_VOXELS)) as u32;
                add_bricks(&mut batch.bricks, part, &header);
                parts.push((part, first));
                first
            }
        };
        let path_first = batch.path.len() as u32;
        batch.path.extend(setup::path(&pass, part.voxel, &ready.step_limits));
        let mut setup = ready.setup;
        (setup.first_brick, setup.shared_bricks) = (first_brick, part.brick_count() as u32);
        (setup.path_first, setup.path_pieces) = (path_first, batch.path.len() as u32 - path_first - 1);
        let mut state = setup::state(&pass, &setup);
        state.piece = path_first;
        batch.setups.push(setup);
        batch.states.push(state);
        batch.index.extend(part.index.dense());
        batch.values.extend(setup::values(&pass, &ready.states, model));
    }
    batch
}

/// Appends the bricks of a part, plane by plane; a channel that it does not store is zero.
fn add_bricks(bricks: &mut Vec<f32>, part: &BrickGrid, header: &RunHeader) {
    let planes = header.planes as usize;
    let first = bricks.len();
    bricks.resize(first + part.brick_count() * planes * BRICK_VOXELS, 0.0);
    let label: Vec<f32> = part.label.iter().map(|&id| f32::from(id)).collect();
    let channels = [
        (0, part.phi.as_slice()),
        (header.dose_plane, part.scalar(Scalar::Dose)),
        (header.removed_plane, part.scalar(Scalar::Removed)),
        (header.label_plane, label.as_slice()),
    ];
    for (plane, values) in channels.into_iter().filter(|(plane, _)| *plane != ABSENT) {
        for (brick, from) in values.chunks_exact(BRICK_VOXELS).enumerate() {
            let at = first + (brick * planes + plane as usize) * BRICK_VOXELS;
            bricks[at..at + BRICK_VOXELS].copy_from_slice(from);
        }
    }
}

/// Runs a group with a common kernel, submission after submission until the last trial has ended.
fn run_group(
    device: &Device,
    model: &DeviceModel,
    group: &[Ready],
    capacity: TrialCapacity,
    progress: &mut dyn FnMut(usize, Progress),
) -> Result<Vec<Outcome>, SimulateError> {
    let simulator = Simulator::new(device, &model.text)?;
    let mut running = simulator.load(batch(group, model), capacity)?;
    let header = header(group);
    let mut records = vec![PassRecord::default(); group.len()];
    let states = loop {
        let setups = running.setups().to_vec();
        let chunk = running.advance()?;
        for (trial, ready) in group.iter().enumerate() {
            let setup = &setups[trial];
            let record = &mut records[trial];
            let before = record.steps as u32;
            for step in before..chunk.states[trial].steps {
                let row = &chunk.rows[(setup.log_first + step % setup.log_rows) as usize];
                readback::push(record, row, &ready.trial.pass, ready.trial.part.voxel);
            }
            if record.steps as u32 > before {
                progress(ready.number, at(&chunk.states[trial], ready));
            }
        }
        if chunk.states.iter().all(|state| state.status >= STATUS_FORMULA || state.status == STATUS_DONE) {
            break chunk.states;
        }
    };
    outcomes(&running, model, (group, &header), (records, &states))
}

/// Progress of a trial.
fn at(state: &TrialState, ready: &Ready) -> Progress {
    Progress {
        time: time_of(state.time_blocks, state.time_rest),
        duration: ready.trial.pass.path.duration(),
        force: state.end_force.into(),
    }
}

fn outcomes(
    running: &Running,
    model: &DeviceModel,
    (group, header): (&[Ready], &RunHeader),
    (records, states): (Vec<PassRecord>, &[TrialState]),
) -> Result<Vec<Outcome>, SimulateError> {
    let remains = running.remains()?;
    let before: Vec<PartBefore> = group.iter().map(PartBefore::of).collect();
    let each = before.par_iter().zip(&remains).zip(running.setups());
    let parts: Vec<BrickGrid> =
        each.map(|((before, remains), setup)| before.changed(remains, (setup, header))).collect();
    let each = group.iter().zip(records).zip(parts).zip(remains.iter().zip(states));
    Ok(each
        .map(|(((ready, record), part), (remains, state))| {
            let tool = readback::states(ready.trial.pass.model, model, &remains.values, &ready.states);
            Outcome { part, tool: tool.unwrap_or_else(|| ready.states.clone()), record: finish(record, state, ready) }
        })
        .collect())
}

/// A part before a pass, and the channels that the pass writes.
struct PartBefore<'a> {
    part: &'a BrickGrid,
    sands: bool,
    keeps_removed: bool,
    grinds: bool,
}

impl<'a> PartBefore<'a> {
    fn of(ready: &Ready<'a>) -> Self {
        let Ready { trial, sands, keeps_removed, setup, .. } = *ready;
        Self { part: trial.part, sands, keeps_removed, grinds: setup.grinds == 1 }
    }

    /// The part with what a trial changed.
    fn changed(&self, remains: &TrialResults, at: (&shaders::layout::TrialSetup, &RunHeader)) -> BrickGrid {
        let mut part = self.part.clone();
        if self.sands {
            part.scalar_or_zero(Scalar::Dose);
        }
        if self.keeps_removed {
            part.scalar_or_zero(Scalar::Removed);
        }
        readback::write_bricks(&mut part, remains, at);
        if self.grinds {
            part.release_uniform_bricks();
        }
        part
    }
}

/// The completed record of a pass, or the reason for its early end.
fn finish(mut record: PassRecord, state: &TrialState, ready: &Ready) -> Result<PassRecord, GpuError> {
    let settings = ready.trial.pass.settings;
    let time = time_of(state.time_blocks, state.time_rest);
    match state.status {
        STATUS_FORMULA => return Err(formula_fault(time, place_of(state.detail), ready.trial.pass.model)),
        STATUS_TOO_MANY_STEPS => {
            return Err(PassError::TooManySteps { time, most: settings.most_steps.unwrap_or_default() }.into());
        }
        _ => {}
    }
    if state.too_soft == 1 && record.contact_time == 0.0 {
        let (setpoint, reach) = (settings.force_setpoint, settings.search_reach);
        return Err(PassError::TooSoft { setpoint, reach }.into());
    }
    record.finish(ready.trial.pass.path.duration());
    Ok(record)
}

/// The error of a formula at a hook.
fn formula_fault(time: f64, place: Hook, model: &CompiledModel) -> GpuError {
    let names: Vec<&str> = model.acting(place).map(|effect| effect.name.as_str()).collect();
    let effects = if names.is_empty() { "the base law".to_owned() } else { names.join(" or ") };
    GpuError::Formula { time, effects, place }
}

fn place_of(fault: u32) -> Hook {
    match fault {
        FAULT_POSE => Hook::Pose,
        FAULT_SHAPE => Hook::Shape,
        FAULT_PRESSURE => Hook::Pressure,
        FAULT_SPINDLE => Hook::Spindle,
        FAULT_FORCE => Hook::Force,
        FAULT_RATE => Hook::Rate,
        FAULT_DOSE => Hook::Dose,
        FAULT_TOOL_STATE => Hook::ToolState,
        _ => Hook::ToolCell,
    }
}
