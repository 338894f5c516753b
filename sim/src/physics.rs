//! Evaluation of a model in a contact: its hooks run over the cells in contact, one lane each.

use shaders::constants::HALF_GAUSS;
use std::collections::HashMap;

use glam::DVec3;

use crate::clock::{Clock, Phase};
use crate::contact::{Contact, ContactCells, Ground, HeightFieldFrame};
use crate::covariates::Covariates;
use crate::height_field::HeightField;
use crate::lines::{Lines, Run};
use crate::pose::Placement;
use crate::tool_cells::ToolCells;
use effects::{CompiledModel, Hook, Lanes, Per, PoseChange, RunError, Signal, States, StepValues, Variable};
use robot::Tool;
use sdf_bake::simd::in_wide_lanes;

/// Cells of a height field on which formulas are evaluated, one lane each.
#[derive(Clone, Copy)]
pub struct InContact<'a> {
    /// The height field.
    pub height_field: &'a HeightField,
    /// Their depths and shares under the tool, if measured.
    pub contact_cells: Option<&'a ContactCells>,
    /// Their column indices.
    pub lines: &'a Lines,
}

/// A model with the states of its tool and the values of the current step.
pub struct Physics<'a> {
    /// Laws and effects.
    pub model: &'a CompiledModel,
    /// States of the tool.
    pub states: &'a mut States,
    /// Timer of the phases of a step.
    pub clock: Option<&'a Clock>,
    /// Values of the step.
    pub step: StepValues,
    /// Coating thickness h_c [m].
    pub coating: f64,
    /// True if the model's laws may be nonlinear in the depth.
    may_bend: bool,
    /// Values of the cells by [`Variable`], for those that a hook reads.
    lanes: Vec<Vec<f64>>,
    /// Cell variables that any hook reads.
    wanted: Vec<Variable>,
    /// Those of them that influence the force balance.
    balancing: Vec<Variable>,
    /// The others.
    following: Vec<Variable>,
    /// Fractional index among the tool's cells for each lane.
    tool_cell: Vec<f64>,
    /// States of the workpiece's cells by lattice indices.
    cells: HashMap<(i32, i32), Vec<f64>>,
    /// The same for each lane, by state.
    cell_lanes: Vec<Vec<f64>>,
}

/// Memory of a model's formulas between two stretches of a pass, besides the tool's states.
#[derive(Clone, Debug)]
pub(crate) struct FormulaMemory {
    step: StepValues,
    cells: HashMap<(i32, i32), Vec<f64>>,
}

impl<'a> Physics<'a> {
    /// A model and its tool's states before the first step.
    pub fn new(model: &'a CompiledModel, states: &'a mut States, coating: f64) -> Self {
        let of_cells = |hooks: &[Hook]| {
            let read = hooks.iter().flat_map(|&place| model.needs(place)).copied();
            let mut read: Vec<Variable> = read.filter(|variable| variable.row().per == Per::Cell).collect();
            read.sort_unstable_by_key(|&variable| variable as usize);
            read.dedup();
            read
        };
        let balancing = of_cells(&[Hook::Shape, Hook::Pressure, Hook::Rate]);
        let mut following = of_cells(&[Hook::Dose, Hook::WorkpieceCell]);
        following.retain(|variable| !balancing.contains(variable));
        let wanted = [balancing.as_slice(), &following].concat();
        let lanes = vec![Vec::new(); Variable::COUNT];
        let cell_lanes = vec![Vec::new(); model.cell_states().len()];
        Self {
            model,
            states,
            clock: None,
            step: StepValues::new(),
            coating,
            may_bend: model.may_bend(),
            lanes,
            wanted,
            balancing,
            following,
            tool_cell: Vec::new(),
            cells: HashMap::new(),
            cell_lanes,
        }
    }

    /// Takes out the memory for the next stretch of a pass.
    pub(crate) fn take_memory(&mut self) -> FormulaMemory {
        FormulaMemory { step: self.step.clone(), cells: std::mem::take(&mut self.cells) }
    }

    /// Restores the memory of the previous stretch.
    pub(crate) fn take_up(&mut self, FormulaMemory { step, cells }: FormulaMemory) {
        (self.step, self.cells) = (step, cells);
    }

    /// Sets the variables of a tool that is held still and pressed on with `setpoint` [N].
    pub fn hold(&mut self, tool: &Tool, setpoint: f64) {
        let face_area = ToolCells::of(tool).face_areas().iter().sum();
        self.step
            .set(Variable::ToolRadius, tool.rim_radius())
            .set(Variable::ToolWidth, tool.width())
            .set(Variable::ToolFaceArea, face_area)
            .set(Variable::ForceSetpoint, setpoint);
    }

    /// Sets the variables of such a tool after a contact whose patch is `patch_width` [m] wide along the tool's y.
    pub fn has_met(&mut self, contact: &Contact, patch_width: f64) {
        self.step
            .set(Variable::Force, contact.force)
            .set(Variable::ContactArea, contact.area)
            .set(Variable::PressureMean, contact.pressure_mean())
            .set(Variable::PatchWidth, patch_width);
    }

    /// Adds the time since the last call to a phase.
    pub(crate) fn lap(&self, phase: Phase) {
        if let Some(clock) = self.clock {
            clock.lap(phase);
        }
    }

    /// True if the surface recedes.
    pub fn grinds(&self) -> bool {
        self.model.process().signal() == Signal::Height || self.model.has(Hook::Rate)
    }

    /// True if pressure or recession may be nonlinear in the depth.
    pub fn may_bend(&self) -> bool {
        self.grinds() && self.may_bend
    }

    /// True if coating is removed.
    pub fn sands(&self) -> bool {
        self.model.process().signal() == Signal::Dose
    }

    /// True if the part has to store the removed depth: a hook of the contact or of the scanner reads it.
    pub(crate) fn keeps_removed(&self) -> bool {
        self.wants(Variable::RemovedDepth) || self.model.needs(Hook::Height).contains(&Variable::RemovedDepth)
    }

    /// True if a hook reads a variable of the cells.
    fn wants(&self, variable: Variable) -> bool {
        self.wanted.contains(&variable)
    }

    /// Offset and tilt that effects add to the tool's pose in this step.
    ///
    /// # Errors
    /// A formula that gives no finite number; the same for all hooks.
    pub fn pose_change(&self) -> Result<PoseChange, RunError> {
        if !self.model.has(Hook::Pose) {
            return Ok(PoseChange { offset: [0.0; 3], roll: 0.0, pitch: 0.0 });
        }
        self.model.pose(&self.step, self.states)
    }

    /// Force reading of the controller [N] for a true `force`.
    pub fn force_reading(&mut self, force: f64) -> Result<f64, RunError> {
        if !self.model.has(Hook::Force) {
            return Ok(force);
        }
        self.step.set(Variable::ForceReading, force);
        self.model.force_reading(&self.step, self.states)
    }

    /// True if effects change the tool's shape or the workpiece's.
    pub(crate) fn changes_shape(&self) -> bool {
        self.model.has(Hook::Shape)
    }

    /// Computes the distance that effects add between tool and workpiece [m], one value for each column of a region and
    /// around it; empty if no effect changes the shape.
    pub fn gap(&mut self, place: &Placement, ground: &Ground, out: &mut Vec<f64>) -> Result<(), RunError> {
        out.clear();
        if !self.changes_shape() {
            return Ok(());
        }
        let mut lines = Lines::default();
        let Ground { height_field, region } = *ground;
        region.grown().lines(height_field.window.size[1]).for_each(|line| lines.push(line));
        self.place(place, &InContact { height_field, contact_cells: None, lines: &lines });
        out.resize(lines.len(), 0.0);
        self.run(Hook::Shape, &[], out)
    }

    /// Gathers the variables that influence the force balance, for the cells under a tool.
    pub fn place(&mut self, place: &Placement, at: &InContact) {
        let balancing = std::mem::take(&mut self.balancing);
        self.fill(&balancing, place, at);
        self.balancing = balancing;
        self.tool_cell.clear();
        let InContact { height_field, lines, .. } = *at;
        if self.model.needs_tool_cells() {
            let (cells, frame) = (ToolCells::of(place.tool), HeightFieldFrame::new(&place.pose, height_field));
            let place = |&line: &u32| cells.place(frame.local(height_field.point(line as usize)));
            self.tool_cell.extend(lines.list().iter().map(place));
        }
        for (number, state) in self.model.cell_states().iter().enumerate() {
            let value = |&line: &u32| {
                let cell = self.cells.get(&height_field.window.place(line as usize));
                cell.map_or(state.initial, |values| values[number])
            };
            self.cell_lanes[number].clear();
            self.cell_lanes[number].extend(lines.list().iter().map(value));
        }
    }

    /// Gathers the other variables that hooks read, once the forces are balanced.
    pub fn place_rest(&mut self, place: &Placement, at: &InContact) {
        let following = std::mem::take(&mut self.following);
        self.fill(&following, place, at);
        self.following = following;
    }

    /// Fills the lanes of the given variables.
    fn fill(&mut self, variables: &[Variable], place: &Placement, at: &InContact) {
        let InContact { height_field, contact_cells, lines } = *at;
        let motion = self.motion();
        let frame = HeightFieldFrame::new(&place.pose, height_field);
        let local = |line: usize| frame.local(height_field.point(line));
        for &variable in variables {
            let lane = &mut self.lanes[variable as usize];
            lane.clear();
            if variable == Variable::SlipSpeed {
                lane.resize(lines.len(), 0.0);
                in_wide_lanes(
                    #[inline(always)]
                    || slip_speeds((place.tool, &frame), motion, at, lane),
                );
                continue;
            }
            let value = |line: usize| -> f64 {
                match variable {
                    Variable::X => height_field.facing.world(height_field.point(line)).x,
                    Variable::Y => height_field.facing.world(height_field.point(line)).y,
                    Variable::Z => height_field.facing.world(height_field.point(line)).z,
                    Variable::ToolX => local(line).x,
                    Variable::ToolY => local(line).y,
                    Variable::DepthLaplacian => {
                        contact_cells.map_or(0.0, |contact_cells| contact_cells.laplacian(height_field, line))
                    }
                    Variable::RemovedDepth => height_field.removed[line],
                    Variable::Dose => height_field.dose[line],
                    Variable::CoatingRemoved => height_field.dose[line].min(1.0) * self.coating,
                    Variable::EdgeDistance => height_field.edge_distances()[line],
                    Variable::Slope => height_field.slope_against(line, place.pose.approach),
                    Variable::Label => f64::from(height_field.label[line]),
                    _ => 0.0,
                }
            };
            lane.extend(lines.list().iter().map(|&line| value(line as usize)));
        }
    }

    /// Advances the states of the workpiece's cells in contact by `dt` [s], with the given `means` of their variables.
    ///
    /// # Errors
    /// A formula that gives no finite number.
    pub fn advance_cells(
        &mut self,
        lines: &Lines,
        means: &[(Variable, &[f64])],
        height_field: &HeightField,
        dt: f64,
    ) -> Result<(), RunError> {
        if self.cell_lanes.is_empty() {
            return Ok(());
        }
        let mut moved = self.cell_lanes.clone();
        let old: Vec<&[f64]> = self.cell_lanes.iter().map(Vec::as_slice).collect();
        let lanes = self.lanes(lines.len(), means).with_states(&old);
        let mut out: Vec<&mut [f64]> = moved.iter_mut().map(Vec::as_mut_slice).collect();
        self.model.advance_cells(dt, (&self.step, self.states), &lanes, &mut out)?;
        for (lane, &line) in lines.list().iter().enumerate() {
            let values = moved.iter().map(|values| values[lane]).collect();
            self.cells.insert(height_field.window.place(line as usize), values);
        }
        Ok(())
    }

    /// Writes the states of the workpiece's cells into the covariates.
    pub(crate) fn hand_over_states(&self, covariates: &mut Covariates) {
        covariates.keep_states(&self.cells, self.cell_lanes.len());
    }

    /// Spindle speed [rad/s] and feed in the tool's frame [m/s].
    fn motion(&self) -> (f64, DVec3) {
        let feed = DVec3::new(self.step.get(Variable::FeedAlong), self.step.get(Variable::FeedAcross), 0.0);
        (self.step.get(Variable::SpindleSpeed), feed * self.step.get(Variable::FeedSpeed))
    }

    /// Slip speed [m/s] at a point in the tool's frame [m].
    pub fn slip_speed(&self, tool: &Tool, at: DVec3) -> f64 {
        let (spindle, feed) = self.motion();
        tool.slip_speed(at, spindle, feed)
    }

    /// The slip velocity itself, in the tool's frame [m/s].
    pub(crate) fn slip_velocity(&self, tool: &Tool, at: DVec3) -> DVec3 {
        let (spindle, feed) = self.motion();
        tool.slip_velocity(at, spindle, feed)
    }

    /// Pressure [Pa] at depths [m] that change by `depth_rate` [m/s].
    pub fn pressure(&self, depth: &[f64], depth_rate: &[f64], out: &mut Vec<f64>) -> Result<(), RunError> {
        out.resize(depth.len(), 0.0);
        self.run(Hook::Pressure, &[(Variable::Depth, depth), (Variable::DepthRate, depth_rate)], out)
    }

    /// Recession speed r [m/s].
    pub fn rate(&self, depth: &[f64], pressure: &[f64], out: &mut Vec<f64>) -> Result<(), RunError> {
        out.resize(depth.len(), 0.0);
        if !self.grinds() {
            out.fill(0.0);
            return Ok(());
        }
        self.run(Hook::Rate, &[(Variable::Depth, depth), (Variable::Pressure, pressure)], out)
    }

    /// Dose per time [1/s].
    pub fn dose_rate(&self, depth: &[f64], pressure: &[f64], out: &mut Vec<f64>) -> Result<(), RunError> {
        out.resize(depth.len(), 0.0);
        if !self.sands() {
            out.fill(0.0);
            return Ok(());
        }
        self.run(Hook::Dose, &[(Variable::Depth, depth), (Variable::Pressure, pressure)], out)
    }

    fn run(&self, place: Hook, own: &[(Variable, &[f64])], out: &mut [f64]) -> Result<(), RunError> {
        let states: Vec<&[f64]> = self.cell_lanes.iter().map(Vec::as_slice).collect();
        let lanes = self.lanes(out.len(), own).with_states(&states);
        self.model.at(place, &self.step, self.states).run(&lanes, out)
    }

    fn lanes<'l>(&'l self, len: usize, own: &[(Variable, &'l [f64])]) -> Lanes<'l> {
        let mut lanes = Lanes::new(len).with_tool_cell(&self.tool_cell);
        self.wanted.iter().for_each(|&variable| lanes.set(variable, &self.lanes[variable as usize]));
        own.iter().for_each(|&(variable, values)| lanes.set(variable, values));
        lanes
    }
}

/// Slip speeds [m/s] at cells. For a tool that sweeps over them, the mean over the time in which it is over the cell,
/// weighted with the depth.
#[inline(always)]
fn slip_speeds(
    (tool, frame): (&Tool, &HeightFieldFrame),
    (spindle, feed): (f64, DVec3),
    &InContact { height_field, contact_cells, lines }: &InContact,
    out: &mut [f64],
) {
    for Run { lines: run, lanes } in lines.runs() {
        let speeds = &mut out[lanes.clone()];
        let points = height_field.places()[run.clone()].iter().zip(&height_field.height[run.clone()]);
        let places = points.map(|([u, v], height)| frame.local(DVec3::new(*u, *v, *height)));
        let speeds = speeds.iter_mut().zip(places);
        match contact_cells.and_then(|contact_cells| Some((contact_cells, contact_cells.lag.get(run.clone())?))) {
            Some((ContactCells { way, mean_depth, share, .. }, lag)) => {
                let sinking = if matches!(tool, Tool::Pad(_)) { -way.z } else { 0.0 };
                let depths = mean_depth[run.clone()].iter().zip(&share[run.clone()]);
                for (((speed, at), lag), (depth, share)) in speeds.zip(lag).zip(depths) {
                    let slip_speed = |time: f64| tool.slip_speed(at - *way * time, spindle, feed);
                    let apart = HALF_GAUSS * (1.0 - 2.0 * lag.abs());
                    let sinks = sinking * apart * share;
                    // A cell in contact for only a part of the time counts where it is deepest.
                    let deeper = sinks.max(-depth).min(*depth) / depth.max(f64::MIN_POSITIVE);
                    *speed =
                        0.5 * ((1.0 - deeper) * slip_speed(lag - apart) + (1.0 + deeper) * slip_speed(lag + apart));
                }
            }
            None => speeds.for_each(|(speed, at)| *speed = tool.slip_speed(at, spindle, feed)),
        }
    }
}
