//! Conversion of a trial to the device's form: lengths in voxels, f32.

use glam::DVec3;
use sdf_bake::BrickGrid;
use sdf_bake::redistance::KEPT_VOXELS;
use shaders::constants::{
    CONTROLLER_ADMITTANCE, CONTROLLER_IDEAL, CONTROLLER_REPLAY, PARTIALS, TIME_BLOCKS, TOOL_PAD, TOOL_SPHERE,
    TOOL_WHEEL,
};
use shaders::layout::{PathPiece, TrialSetup, TrialState};

use crate::measured::Readings;
use crate::path::PathSample;
use crate::physics::Physics;
use crate::scheme::{Scheme, StepLimits};
use crate::settings::{LONGEST_STEP, Pass, PassError};
use crate::tool_cells::ToolCells;
use effects::{DeviceModel, States, StepValues, Variable};
use robot::Controller;
use robot::Tool;

/// Longest segment of a path [voxels]: within it, f32 resolves positions to 1e-6 voxel.
const PIECE: f64 = 16.0;
/// Depth to which a tool may sink in at its first touch [voxels].
const SINK: f64 = 2.0;

/// A time as a number of blocks and the remainder [s].
fn clock(time: f64) -> (i32, f32) {
    let blocks = (time * f64::from(TIME_BLOCKS)).floor();
    (blocks as i32, (time - blocks / f64::from(TIME_BLOCKS)) as f32)
}

/// The time from blocks and remainder [s].
pub(super) fn time_of(blocks: i32, rest: f32) -> f64 {
    f64::from(blocks) / f64::from(TIME_BLOCKS) + f64::from(rest)
}

fn four(v: DVec3, last: f64) -> [f32; 4] {
    [v.x as f32, v.y as f32, v.z as f32, last as f32]
}

/// The path in straight segments, and its end.
pub(super) fn path(pass: &Pass, voxel: f64, step_limits: &StepLimits) -> Vec<PathPiece> {
    let samples = pass.path.samples();
    let mut pieces = Vec::new();
    for (pair, &longest_step) in samples.windows(2).zip(&step_limits.longest_steps) {
        let (a, b) = (&pair[0], &pair[1]);
        let count = ((b.position - a.position).length() / (PIECE * voxel)).ceil().max(1.0);
        let velocity = (b.position - a.position) / (b.time - a.time) / voxel;
        let each = (b.time - a.time) / count;
        pieces
            .extend((0..count as usize).map(|n| piece(a, b, n as f64 / count, (velocity, each, longest_step), voxel)));
    }
    let last = &samples[samples.len() - 1];
    pieces.push(piece(last, last, 0.0, (DVec3::ZERO, 1.0, LONGEST_STEP), voxel));
    pieces
}

/// The segment that begins at a share of the distance between two samples.
fn piece(
    a: &PathSample,
    b: &PathSample,
    share: f64,
    (velocity, span, longest_step): (DVec3, f64, f64),
    voxel: f64,
) -> PathPiece {
    let position = a.position.lerp(b.position, share) / voxel;
    let whole = position.floor();
    let (blocks, rest) = clock(a.time + (b.time - a.time) * share);
    PathPiece {
        whole: [whole.x as i32, whole.y as i32, whole.z as i32, blocks],
        rest: [(position.x - whole.x) as f32, (position.y - whole.y) as f32, (position.z - whole.z) as f32, rest],
        velocity: four(velocity, span),
        approach: four(a.approach.lerp(b.approach, share), longest_step),
        axis: four(a.axis.lerp(b.axis, share), 0.0),
    }
}

/// Settings of a trial for the device, and the pace of its tool. The host fills in the offsets of the trial's arrays.
///
/// # Errors
/// A setting out of range.
pub(super) fn setup(
    grid: &BrickGrid,
    pass: &Pass,
    physics: &Physics,
    scheme: &dyn Scheme,
) -> Result<(TrialSetup, StepLimits), PassError> {
    pass.settings.check(grid, pass.tool)?;
    let voxel = grid.voxel;
    let in_voxels = |length: f64| (length / voxel) as f32;
    let settings = pass.settings;
    let mut setup: TrialSetup = bytemuck::Zeroable::zeroed();
    setup.grid_origin = [grid.origin.x, grid.origin.y, grid.origin.z, 0];
    setup.grid_dims = [grid.dims.x as u32, grid.dims.y as u32, grid.dims.z as u32, 0];
    let (x, y) = pass.tool.half_footprint(SINK * voxel);
    setup.extent = [-in_voxels(x), in_voxels(x), -in_voxels(y), in_voxels(y)];
    let (x, y) = pass.tool.half_footprint(f64::INFINITY);
    setup.whole_extent = [in_voxels(x), in_voxels(y), 0.0, 0.0];
    (setup.voxel, setup.band_length, setup.band) = (voxel as f32, grid.band, in_voxels(grid.band.into()));
    setup.kept_length = (KEPT_VOXELS * voxel) as f32;
    setup.infinity = f32::INFINITY;
    place_tool(&mut setup, pass.tool, voxel);
    place_controller(&mut setup, settings.controller, voxel);
    setup.force_setpoint = settings.force_setpoint as f32;
    setup.spindle_speed = settings.spindle_speed as f32;
    let step_limits = scheme.step_limits(pass, voxel);
    (setup.step_way, setup.write_back_way) = (in_voxels(step_limits.step_way), in_voxels(step_limits.height_field_way));
    setup.search_reach = in_voxels(settings.search_reach);
    setup.coating = settings.coating as f32;
    let longest_step = settings.longest_step(pass.model)?;
    settings.check_steps(pass.path.duration(), longest_step)?;
    setup.longest_step = longest_step as f32;
    setup.quasi_static = settings.quasi_static.into();
    (setup.grinds, setup.sands) = (scheme.recedes().into(), physics.sands().into());
    setup.bends = physics.may_bend().into();
    setup.pass_row = pass.row as u32;
    setup.most_steps = settings.most_steps.map_or(0, |most| most.max(1) as u32);
    (setup.approach_blocks, setup.approach_rest) = clock(pass.approach);
    (setup.duration_blocks, setup.duration_rest) = clock(pass.path.duration());
    setup.trial_time = pass.trial_time as f32;
    setup.path_length = pass.path.length() as f32;
    Ok((setup, step_limits))
}

/// Id and radius [m] of a tool's shape in the shaders; `None` if they lack it.
pub(super) fn shape_on_device(tool: &Tool) -> Option<(u32, f64)> {
    match tool {
        Tool::Wheel(wheel) => Some((TOOL_WHEEL, wheel.radius)),
        Tool::Pad(pad) => Some((TOOL_PAD, pad.radius)),
        Tool::Sphere(sphere) => Some((TOOL_SPHERE, sphere.radius)),
        _ => None,
    }
}

fn place_tool(setup: &mut TrialSetup, tool: &Tool, voxel: f64) {
    let in_voxels = |length: f64| (length / voxel) as f32;
    let (shape, radius) = shape_on_device(tool).expect("other shapes are refused");
    (setup.tool, setup.tool_radius) = (shape, in_voxels(radius));
    if let Tool::Wheel(wheel) = tool {
        setup.tool_half_width = in_voxels(0.5 * wheel.width);
        setup.tool_crown = (wheel.crown * voxel) as f32;
    }
    setup.rim_radius = in_voxels(tool.rim_radius());
    setup.drop = in_voxels(tool.drop());
}

fn place_controller(setup: &mut TrialSetup, controller: Controller, voxel: f64) {
    setup.controller = controller_kind(controller);
    if let Controller::Admittance { mass, damping, period } = controller {
        setup.mass = (mass * voxel) as f32;
        setup.damping = (damping * voxel) as f32;
        setup.period = period as f32;
    }
}

fn controller_kind(controller: Controller) -> u32 {
    match controller {
        Controller::Ideal => CONTROLLER_IDEAL,
        Controller::Admittance { .. } => CONTROLLER_ADMITTANCE,
        Controller::Replay => CONTROLLER_REPLAY,
    }
}

/// State of a trial before its first step.
pub(super) fn state(pass: &Pass, setup: &TrialSetup) -> TrialState {
    let mut state: TrialState = bytemuck::Zeroable::zeroed();
    let controller = if pass.approach > 0.0 { Controller::Replay } else { pass.settings.controller };
    state.controller = controller_kind(controller);
    state.up = 1;
    state.axis = 2;
    state.extent = setup.extent;
    state.dt_limit = LONGEST_STEP as f32;
    state.scale = 1.0;
    if controller == Controller::Ideal {
        state.in_air = 1;
        state.coarse = setup.search_reach.floor();
        state.fine = setup.search_reach - state.coarse;
    }
    state
}

/// Values of a trial: variables of the step, parameters, states.
pub(super) fn values(pass: &Pass, states: &States, model: &DeviceModel) -> Vec<f32> {
    let mut step = StepValues::new();
    let face_area = ToolCells::of(pass.tool).face_areas().iter().sum();
    step.set(Variable::PassNumber, pass.number as f64)
        .set(Variable::ForceSetpoint, pass.settings.force_setpoint)
        .set(Variable::SpindleSetpoint, pass.settings.spindle_speed)
        .set(Variable::SpindleSpeed, pass.settings.spindle_speed)
        .set(Variable::ToolRadius, pass.tool.rim_radius())
        .set(Variable::ToolWidth, pass.tool.width())
        .set(Variable::ToolFaceArea, face_area);
    Readings::new(pass.model, pass.measured).set_step(0.0, &mut step);
    let mut values = vec![0.0; model.values + PARTIALS as usize];
    for variable in Variable::ALL.iter().filter(|variable| variable.row().per == effects::Per::Step) {
        values[*variable as usize] = step.get(*variable) as f32;
    }
    let mut fill = |first: usize, from: &[f64]| {
        values[first..first + from.len()].iter_mut().zip(from).for_each(|(to, from)| *to = *from as f32);
    };
    let (tool, cells) = states.values();
    fill(model.parameters, pass.model.values());
    fill(model.tool_states, tool);
    fill(model.cell_states, &cells.concat());
    values
}
