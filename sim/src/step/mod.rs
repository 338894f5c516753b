//! One step of a pass, with the equations' numbers in `docs/grinding.md`.

mod force_balance;
mod guide;
mod suspended;
mod workpiece;

use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;
use shaders::constants::WRITE_BACK_RECESSION;

use self::guide::Guide;
pub(crate) use self::suspended::Suspended;
use self::workpiece::Workpiece;
use crate::clock::Phase;
use crate::contact::Contact;
use crate::control::Motion;
use crate::measured::Readings;
use crate::physics::Physics;
use crate::pose::Placement;
use crate::record::PassRecord;
use crate::scheme::{AppliedRemoval, Scheme, StepLimits, scheme_of};
use crate::settings::{Pass, PassError};
use crate::step_values::Moment;
use crate::tool_cells::{CellSums, ToolCells};
use crate::wrench::Wrench;
use effects::{RunError, States, Variable};

/// An accepted step: its motion, the mean contact over it, and the removal.
pub(crate) struct AcceptedStep {
    pub(crate) motion: Motion,
    /// Length of the step [s].
    pub(crate) dt: f64,
    pub(crate) contact: Contact,
    /// Force at its end [N].
    pub(crate) end_force: f64,
    pub(crate) applied: AppliedRemoval,
}

/// A pass in progress.
pub(crate) struct Runner<'a> {
    pass: Pass<'a>,
    workpiece: Workpiece<'a>,
    guide: Guide<'a>,
    physics: Physics<'a>,
    moment: Moment,
    readings: Readings<'a>,
    scheme: Box<dyn Scheme>,
    step_limits: StepLimits,
    record: PassRecord,
}

impl<'a> Runner<'a> {
    /// A pass before its first step; no step is longer than `longest_step` [s].
    pub(crate) fn new(grid: &'a mut BrickGrid, pass: Pass<'a>, states: &'a mut States, longest_step: f64) -> Self {
        if let Some(clock) = pass.clock {
            clock.skip();
        }
        let mut physics = Physics::new(pass.model, states, pass.settings.coating);
        physics.clock = pass.clock;
        if physics.sands() {
            grid.scalar_or_zero(Scalar::Dose);
        }
        if physics.keeps_removed() {
            grid.scalar_or_zero(Scalar::Removed);
        }
        let scheme = scheme_of(&physics);
        Self {
            step_limits: scheme.step_limits(&pass, grid.voxel),
            workpiece: Workpiece::new(grid, pass.tool),
            guide: Guide::new(pass, longest_step),
            moment: Moment::new(&pass),
            readings: Readings::new(pass.model, pass.measured),
            record: PassRecord::default(),
            pass,
            physics,
            scheme,
        }
    }

    /// Time since the pass began [s].
    pub(crate) fn time(&self) -> f64 {
        self.guide.time
    }

    /// Steps taken.
    pub(crate) fn steps(&self) -> usize {
        self.record.steps
    }

    /// One step. Returns the force at its end [N].
    pub(crate) fn step(&mut self) -> Result<f64, RunError> {
        // Variables of formulas in this step, the spindle speed, and the pose change by effects.
        let longest = self.enter()?;
        // Pressure, Eq. (3), force, Eq. (4), recession, Eqs. (1) and (5), and the controller, Eq. (6), solved together.
        let (motion, dt) = self.find_balance(longest)?;
        let Some(motion) = motion else { return self.stay_in_air(dt) };
        let middle = Placement::still(self.pass.tool, self.guide.middle(motion, dt));
        // Dose, Eq. (2).
        self.scheme.complete(&middle, self.workpiece.height_field(), &mut self.physics, dt)?;
        // Force, Eq. (4), load and area, as means over the step.
        let (contact, end_force) = self.scheme.step().contact(self.workpiece.height_field());
        self.gauge(motion, dt);
        // Sums for each tool cell and each surface point, and the states of the workpiece's cells.
        let sums = self.advance_cells(&middle, dt)?;
        // The surface recedes, Eq. (1), and the coating gains its dose, Eq. (2).
        let applied = self.scheme.apply(self.workpiece.height_field_mut(), self.pass.settings.coating);
        // Variables of formulas after this step, and the tool's states.
        let taken = AcceptedStep { motion, dt, contact, end_force, applied };
        self.leave(&middle, &taken, &sums)?;
        // The log and, when due, the write-back into the field.
        self.go_on(&taken);
        Ok(end_force)
    }

    /// Sets the variables of formulas before a step. Returns the longest step that may be taken [s].
    fn enter(&mut self) -> Result<f64, RunError> {
        let Self { pass, guide, physics, moment, readings, step_limits, .. } = self;
        guide.take_over(physics.step.get(Variable::Force));
        moment.enter(pass, guide.nominal(guide.time, 0.0), guide.time, &mut physics.step);
        readings.set_states(physics.model, guide.time, physics.states);
        readings.set_step(guide.time, &mut physics.step);
        let spindle = physics.model.spindle_speed(&physics.step, physics.states)?;
        moment.set_spindle(spindle, &mut physics.step);
        guide.pose_change = physics.pose_change()?;
        Ok(guide.step_length(step_limits.longest_steps[pass.path.piece(guide.time)]))
    }

    /// Hands the wrench at the end of a step of `dt` [s] to the gauge of the pass.
    fn gauge(&self, motion: Motion, dt: f64) {
        let Some(gauge) = self.pass.gauge else { return };
        let pose = self.guide.pose(self.guide.time + dt, motion.travel);
        let drag = |point| {
            let slip = pose.frame.matrix() * self.physics.slip_velocity(self.pass.tool, pose.local(point));
            slip.normalize_or_zero() * -gauge.friction()
        };
        gauge.set(self.scheme.step().wrench(&pose, self.workpiece.height_field(), drag));
    }

    /// Sums the results of a step of `dt` [s] for each tool cell and each surface point; advances the states of the
    /// workpiece's cells.
    fn advance_cells(&mut self, middle: &Placement, dt: f64) -> Result<CellSums, RunError> {
        let Self { pass, workpiece, guide, physics, scheme, .. } = self;
        let (step, height_field) = (scheme.step(), workpiece.height_field());
        let sums = if physics.model.needs_tool_cells() {
            step.cell_sums(middle, height_field, physics, dt).means()
        } else {
            CellSums::default()
        };
        physics.advance_cells(step.lines, &step.means(), height_field, dt)?;
        if let Some(covariates) = pass.covariates {
            let slip_speed = |point| physics.slip_speed(pass.tool, middle.pose.local(point));
            let begun = pass.trial_time + guide.time;
            covariates.borrow_mut().add(height_field, step.contact_cells(), slip_speed, (begun, dt));
        }
        Ok(sums)
    }

    /// Sets the variables of formulas after a step, and advances the tool's states.
    fn leave(&mut self, middle: &Placement, taken: &AcceptedStep, sums: &CellSums) -> Result<(), RunError> {
        let extent = self.scheme.step().extent(&middle.pose, self.workpiece.height_field());
        self.workpiece.extent = extent.unwrap_or(self.workpiece.extent);
        let patch_width = extent.map_or(0.0, |extent| extent.y.1 - extent.y.0);
        self.moment.leave(taken, self.guide.motion, patch_width);
        self.moment.publish(&mut self.physics.step);
        self.advance_states(sums, taken.dt)
    }

    fn advance_states(&mut self, sums: &CellSums, dt: f64) -> Result<(), RunError> {
        let Physics { model, states, step, .. } = &mut self.physics;
        sums.advance(&ToolCells::of(self.pass.tool), model, states, (step, dt))
    }

    /// Advances to the step's end, records it, and writes the height field back when due.
    fn go_on(&mut self, taken: &AcceptedStep) {
        let AcceptedStep { motion, dt, contact, end_force, applied } = taken;
        let way = self.guide.follow(*motion, *dt);
        self.workpiece.travelled += way;
        let setpoint = self.pass.force_setpoint(self.guide.time..self.guide.time);
        let row = self.guide.log_row(*end_force, self.physics.step.get(Variable::SpindleSpeed));
        self.record.push(row, (contact, &applied.removal), *dt, setpoint);
        self.physics.lap(Phase::Apply);
        // Half a step of tolerance: steps of equal length would end on the limit itself, and rounding would decide.
        let is_far = self.workpiece.travelled + 0.5 * way > self.step_limits.height_field_way;
        let is_deep = applied.receded > WRITE_BACK_RECESSION * self.workpiece.grid.voxel;
        if self.scheme.recedes() && (is_far || is_deep) {
            self.write_back();
        }
    }

    /// A step of `dt` [s] without a surface to press on. Returns the force at its end [N].
    fn stay_in_air(&mut self, dt: f64) -> Result<f64, RunError> {
        self.write_back();
        self.workpiece.expect_touch(self.pass.tool);
        if let Some(gauge) = self.pass.gauge {
            gauge.set(Wrench::default());
        }
        self.moment.leave_air();
        self.moment.publish(&mut self.physics.step);
        self.advance_states(&CellSums::default(), dt)?;
        self.guide.stay_in_air(dt);
        let row = self.guide.log_row(0.0, self.physics.step.get(Variable::SpindleSpeed));
        self.record.push_air(row);
        Ok(0.0)
    }

    /// Writes the recession of the height field into the distance field and discards the height field.
    pub(crate) fn write_back(&mut self) {
        if self.workpiece.write_back(!self.scheme.recedes()) {
            self.physics.lap(Phase::Write);
        }
        self.scheme.leave_height_field();
    }

    /// Ends the pass.
    ///
    /// # Errors
    /// [`PassError::TooSoft`] if the tool reached the setpoint nowhere.
    pub(crate) fn finish(mut self) -> Result<PassRecord, PassError> {
        self.write_back();
        let Self { pass, workpiece, guide, scheme, physics, mut record, .. } = self;
        let Pass { settings, path, covariates, .. } = pass;
        if guide.is_too_soft && record.contact_time == 0.0 {
            return Err(PassError::TooSoft { setpoint: settings.force_setpoint, reach: settings.search_reach });
        }
        if scheme.recedes() {
            workpiece.grid.release_uniform_bricks();
        }
        if let Some(covariates) = covariates {
            physics.hand_over_states(&mut covariates.borrow_mut());
        }
        record.finish(path.duration());
        Ok(record)
    }
}
