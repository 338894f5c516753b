//! Prediction of table rows with a model: one contact of mean pressure, integrated over time.
//!
//! Within a row the states of the tool are advanced by the midpoint rule; steps are halved until the removal rate
//! changes little in half a step.

use std::collections::BTreeMap;

use effects::{CompiledModel, Dimension, Holder, Hook, Lanes, Reset, RunError, Signal, States, StepValues, Variable};

use super::table_library::{COLUMN_STATE, column_of};
use trials::table::{Removed, Row, Table, Usage};

/// Area of the contact where the table does not give it [m²].
pub(super) const NOMINAL_AREA: f64 = 1e-4;
/// Sliding speed where the table does not give it [m/s].
pub(super) const NOMINAL_SPEED: f64 = 1.0;
/// Thickness of the coating where the table does not give it [m].
pub(super) const NOMINAL_COATING: f64 = 50e-6;
/// Temperature that counts as no rise, if a column measures the temperature [K].
pub(super) const ROOM: f64 = 293.15;
/// Dimension of a temperature.
pub(super) const KELVIN: Dimension = Dimension::whole([0, 0, 0, 1]);
/// Dimension of a distance.
const LENGTH: Dimension = Dimension::whole([0, 1, 0, 0]);
/// Key of the columns that measure the use of a tool.
const USAGE: &str = "usage";
/// Largest relative change of the removal rate in half a step.
const CHANGE: f64 = 0.02;
/// Initial number of steps of a row, and most halvings.
const STEPS: (f64, i32) = (4.0, 10);
/// Most iterations of the search for the true force of a force reading.
const FORCE_ROUNDS: usize = 20;
/// Relative tolerance of that force.
const FORCE_SAME: f64 = 1e-10;

/// A state of the tool that a column measures.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Measured {
    /// Index among the model's tool states.
    state: usize,
    /// Index in [`Table::usage`].
    usage: usize,
    /// Value of the column at which the state is zero [SI].
    zero: f64,
}

/// A table's rows with a model.
pub(super) struct Rows<'a> {
    table: &'a Table,
    model: &'a CompiledModel,
    area: f64,
    coating: f64,
    measured: Vec<Measured>,
    /// Values of variables that hooks read per cell of the workpiece; a row has one value for all cells.
    neutral: BTreeMap<Variable, [f64; 1]>,
}

/// Time and progress within a row.
#[derive(Clone, Copy)]
struct Clock {
    /// Time since the first row [s].
    trial: f64,
    /// Time since the row began [s].
    row: f64,
    /// Removal since the row began: depth [m] and dose.
    depth: f64,
    dose: f64,
}

/// Rates of the contact at an instant.
struct Instant {
    step: StepValues,
    /// Recession, or coating taken off, per time [m/s].
    speed: f64,
    dose_rate: f64,
}

/// Index in [`Table::usage`] of the column that measures a state: by name, else the only one of its dimension. Any
/// length may have the dimension of a sliding distance, so the column must be declared as `usage`.
pub(super) fn measuring(table: &Table, effect: &str, state: &effects::State) -> Option<usize> {
    if state.per != Holder::Tool {
        return None;
    }
    if state.name == COLUMN_STATE
        && let Some((own, _)) = column_of(table, effect)
    {
        return Some(own);
    }
    let full = format!("{effect}.{}", state.name);
    let is_named =
        |usage: &Usage| [&usage.name, &usage.key].into_iter().any(|name| *name == state.name || *name == full);
    let dimension = state.unit.dimension;
    let fits = |usage: &Usage| usage.dimension == dimension && (usage.key == USAGE || dimension != LENGTH);
    let mut alike = (0..table.usage.len()).filter(|&k| fits(&table.usage[k]) && !dimension.is_none());
    let by_dimension = || alike.next().filter(|_| alike.next().is_none());
    table.usage.iter().position(is_named).or_else(by_dimension)
}

/// The column that measures the temperature.
pub(super) fn temperature(table: &Table) -> Option<usize> {
    table.usage.iter().position(|usage| usage.dimension == KELVIN)
}

impl<'a> Rows<'a> {
    pub(super) fn new(table: &'a Table, model: &'a CompiledModel) -> Self {
        let measured = model.tool_states().enumerate().filter_map(|(number, (effect, state))| {
            let usage = measuring(table, &effect.name, state)?;
            let zero = if table.usage[usage].dimension == KELVIN { ROOM } else { 0.0 };
            Some(Measured { state: number, usage, zero })
        });
        let places = [Hook::Rate, Hook::Dose, Hook::ToolCell];
        let read = places.iter().flat_map(|&place| model.needs(place).iter().filter(move |v| v.is_lane_at(place)));
        let neutral = |&variable: &Variable| match variable {
            Variable::EdgeDistance => (variable, [1.0]),
            Variable::CellFaceArea => (variable, [NOMINAL_AREA]),
            _ => (variable, [0.0]),
        };
        Self {
            measured: measured.collect(),
            neutral: read.map(neutral).collect(),
            area: table.area.unwrap_or(NOMINAL_AREA),
            coating: table.coating.unwrap_or(NOMINAL_COATING),
            table,
            model,
        }
    }

    /// Mean removal rate of every row, as [`Row::removal_rate`].
    ///
    /// # Errors
    /// If a formula gives no finite number.
    pub(super) fn predicted(&self) -> Result<Vec<f64>, RunError> {
        let mut tools = vec![States::new(self.model, 1); self.table.tools.len()];
        let mut worked = 0.0;
        let each = self.table.rows.iter().map(|row| {
            let states = &mut tools[row.tool];
            if row.fresh {
                states.reset(self.model, Reset::FreshTool);
            }
            states.reset(self.model, Reset::Trial);
            let began = row.began.unwrap_or(worked);
            worked += row.duration.unwrap_or(0.0);
            let depth = self.work(row, began, states)?;
            Ok(if self.table.removed == Removed::Depth { depth } else { depth * self.area })
        });
        each.collect()
    }

    /// Integrates one row. Returns the mean recession speed [m/s].
    fn work(&self, row: &Row, began: f64, states: &mut States) -> Result<f64, RunError> {
        let mut clock = Clock { trial: began, row: 0.0, depth: 0.0, dose: 0.0 };
        self.read_in(row, states);
        let Some(duration) = row.duration else { return Ok(self.at(row, clock, states)?.speed) };
        let mut step = duration / STEPS.0;
        let least = step * 0.5f64.powi(STEPS.1);
        let mut now = self.at(row, clock, states)?;
        while duration - clock.row > 1e-9 * duration {
            let dt = step.min(duration - clock.row);
            let mut halfway = states.clone();
            self.advance(row, &mut halfway, &now, 0.5 * dt)?;
            let middle = self.at(row, clock.after(&now, 0.5 * dt), &halfway)?;
            if (middle.speed - now.speed).abs() > CHANGE * now.speed.max(middle.speed) && dt > least {
                step = 0.5 * dt;
                continue;
            }
            self.advance(row, states, &middle, dt)?;
            clock = clock.after(&middle, dt);
            now = self.at(row, clock, states)?;
            step *= 2.0;
        }
        Ok(clock.depth / duration)
    }

    fn advance(&self, row: &Row, states: &mut States, instant: &Instant, dt: f64) -> Result<(), RunError> {
        let lanes = self.neutral.iter().fold(Lanes::new(1), |lanes, (&v, value)| lanes.with(v, value));
        states.advance(self.model, dt, &instant.step, &lanes)?;
        self.read_in(row, states);
        Ok(())
    }

    /// Sets the states that columns measure.
    fn read_in(&self, row: &Row, states: &mut States) {
        for measured in &self.measured {
            states.measure(self.model, measured.state, row.usage[measured.usage] - measured.zero);
        }
    }

    /// Evaluates the contact at an instant.
    fn at(&self, row: &Row, clock: Clock, states: &States) -> Result<Instant, RunError> {
        let mut step = StepValues::new();
        let reading = row.force.or(row.pressure.map(|pressure| pressure * self.area)).unwrap_or_default();
        for (variable, value) in [
            (Variable::Time, clock.row),
            (Variable::ContactTime, clock.row),
            (Variable::TrialTime, clock.trial + clock.row),
            (Variable::ContactArea, self.area),
            (Variable::ToolRadius, self.table.radius.unwrap_or_default()),
            (Variable::ForceSetpoint, reading),
            (Variable::Force, reading),
        ] {
            step.set(variable, value);
        }
        if let Some(usage) = temperature(self.table) {
            step.set(Variable::TemperatureLogged, row.usage[usage]);
        }
        self.spin(row, states, &mut step)?;
        let force = self.true_force(reading, states, &mut step)?;
        let pressure = force / self.area;
        step.set(Variable::Force, force).set(Variable::PressureMean, pressure);
        let (rate, dose_rate) = self.removal((pressure, clock), states, &step)?;
        step.set(Variable::RemovalRate, rate * self.area);
        step.set(Variable::DoseVolumeRate, dose_rate * self.coating * self.area);
        Ok(Instant { step, speed: rate + dose_rate * self.coating, dose_rate })
    }

    /// Sets the speeds from the model's spindle hook.
    fn spin(&self, row: &Row, states: &States, step: &mut StepValues) -> Result<(), RunError> {
        let speed = row.speed.unwrap_or(NOMINAL_SPEED);
        step.set(Variable::SlidingSpeed, speed);
        let Some(radius) = self.table.radius else { return Ok(()) };
        step.set(Variable::SpindleSetpoint, speed / radius).set(Variable::SpindleSpeed, speed / radius);
        if self.model.has(Hook::Spindle) {
            let spindle = self.model.spindle_speed(step, states)?;
            step.set(Variable::SpindleSpeed, spindle).set(Variable::SlidingSpeed, spindle.abs() * radius);
        }
        Ok(())
    }

    /// Force [N] that the sensor reads as `reading`, by the secant rule.
    fn true_force(&self, reading: f64, states: &States, step: &mut StepValues) -> Result<f64, RunError> {
        if !self.model.has(Hook::Force) {
            return Ok(reading);
        }
        let mut error = |force: f64| -> Result<f64, RunError> {
            step.set(Variable::ForceReading, force);
            Ok(self.model.force_reading(step, states)? - reading)
        };
        let (mut last, mut last_error) = (reading, error(reading)?);
        let mut force = reading - last_error;
        for _ in 0..FORCE_ROUNDS {
            let now = error(force)?;
            if now.abs() <= FORCE_SAME * reading.abs() || now == last_error {
                break;
            }
            let next = force - now * (force - last) / (now - last_error);
            (last, last_error, force) = (force, now, next);
        }
        Ok(force.max(0.0))
    }

    /// Recession speed [m/s] and dose per time [1/s].
    fn removal(
        &self,
        (pressure, clock): (f64, Clock),
        states: &States,
        step: &StepValues,
    ) -> Result<(f64, f64), RunError> {
        let grinds = self.model.process().signal() == Signal::Height;
        let place = if grinds { Hook::Rate } else { Hook::Dose };
        let own = [
            (Variable::Pressure, [pressure]),
            (Variable::SlipSpeed, [step.get(Variable::SlidingSpeed)]),
            (Variable::RemovedDepth, [clock.depth]),
            (Variable::Dose, [clock.dose]),
            (Variable::CoatingRemoved, [clock.dose.min(1.0) * self.coating]),
        ];
        let cells: Vec<[f64; 1]> = self.model.cell_states().iter().map(|state| [state.initial]).collect();
        let cells: Vec<&[f64]> = cells.iter().map(<[f64; 1]>::as_slice).collect();
        let lanes = Lanes::new(1).with_tool_cell(&[0.0]).with_states(&cells);
        let lanes = self.neutral.iter().fold(lanes, |lanes, (&variable, value)| lanes.with(variable, value));
        let lanes = own.iter().fold(lanes, |lanes, (variable, value)| lanes.with(*variable, value));
        let mut out = [0.0];
        self.model.at(place, step, states).run(&lanes, &mut out)?;
        let removal = out[0].max(0.0);
        Ok(if grinds { (removal, 0.0) } else { (0.0, removal) })
    }
}

impl Clock {
    fn after(self, instant: &Instant, dt: f64) -> Self {
        Self {
            trial: self.trial,
            row: self.row + dt,
            depth: self.depth + instant.speed * dt,
            dose: self.dose + instant.dose_rate * dt,
        }
    }
}
