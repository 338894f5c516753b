//! Simulation of passes: complete ones, or step by step.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use effects::States;
use glam::DVec3;
use pyo3::prelude::*;
use sdf_bake::BrickGrid;
use sim::{Pass, PassSettings, PathSample, TOOL_CELLS, Underway, run_pass, run_stretch};

use crate::errors::{of, refused};
use crate::model::Model;
use crate::tool::{Path, Record, Tool};
use crate::workpiece::Workpiece;

/// Nominal contact point [m], approach axis and tool axis [1] at the end of a step.
type Place = ([f64; 3], [f64; 3], [f64; 3]);

/// A tool at work on a workpiece.
#[pyclass(module = "robofin")]
pub struct Simulation {
    #[pyo3(get)]
    workpiece: Py<Workpiece>,
    tool: robot::Tool,
    model: Arc<effects::CompiledModel>,
    settings: PassSettings,
    states: States,
    /// Number of passes done.
    #[pyo3(get)]
    passes: usize,
    /// Duration of the passes done [s].
    time: f64,
    steps: Steps,
}

/// A pass that is run step by step.
#[derive(Default)]
struct Steps {
    underway: Mutex<Underway>,
    /// Time since the pass began [s].
    time: f64,
    /// Position of the tool.
    place: Option<PathSample>,
}

/// State of workpiece and tool at one moment.
#[pyclass(frozen, module = "robofin")]
pub struct SimulationSnapshot {
    part: Arc<BrickGrid>,
    states: States,
    passes: usize,
    time: f64,
    underway: Mutex<Underway>,
    step_time: f64,
    place: Option<PathSample>,
}

#[pymethods]
impl Simulation {
    /// A tool on a workpiece that its passes change. `force` [N] is the setpoint of the controller, which is "ideal",
    /// "replay", or "admittance" with `mass` [kg], `damping` [N s/m] and `period` [s]. `spindle_speed` [rad/s],
    /// `coating` and `search_reach` [m] have the program's defaults.
    #[new]
    #[pyo3(signature = (workpiece, tool, model, *, force = 15.0, controller = "ideal", mass = 2.0, damping = 1500.0,
                        period = 5e-4, spindle_speed = None, coating = None, search_reach = None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn new(
        workpiece: Py<Workpiece>,
        tool: &Tool,
        model: &Model,
        force: f64,
        controller: &str,
        mass: f64,
        damping: f64,
        period: f64,
        spindle_speed: Option<f64>,
        coating: Option<f64>,
        search_reach: Option<f64>,
    ) -> PyResult<Self> {
        let usual = PassSettings::default();
        let settings = PassSettings {
            controller: crate::tool::controller(controller, mass, damping, period)?,
            force_setpoint: force,
            spindle_speed: spindle_speed.unwrap_or(usual.spindle_speed),
            coating: coating.unwrap_or(usual.coating),
            search_reach: search_reach.unwrap_or(usual.search_reach),
            ..usual
        };
        let model = model.compiled.clone();
        Ok(Self {
            workpiece,
            tool: tool.inner.clone(),
            states: States::new(&model, TOOL_CELLS),
            model,
            settings,
            passes: 0,
            time: 0.0,
            steps: Steps::default(),
        })
    }

    /// Runs a complete pass along a path; tool wear continues from pass to pass.
    #[pyo3(signature = (path, *, force = None))]
    fn run(&mut self, py: Python<'_>, path: &Path, force: Option<f64>) -> PyResult<Record> {
        self.end_pass();
        let settings = PassSettings { force_setpoint: force.unwrap_or(self.settings.force_setpoint), ..self.settings };
        let (number, trial_time) = (self.passes + 1, self.time);
        let Self { workpiece, tool, model, states, .. } = self;
        let mut workpiece = workpiece.try_borrow_mut(py)?;
        let (grid, path) = (&mut workpiece.part, &*path.inner);
        let record = py.detach(|| {
            let pass = Pass { number, trial_time, ..Pass::first(tool, path, &settings, model) };
            run_pass(Arc::make_mut(grid), pass, states, &mut |_| {})
        });
        let record = record.map_err(of)?;
        self.passes += 1;
        self.time += record.duration;
        Ok(Record::of(record))
    }

    /// Moves the tool within a pass to a nominal contact point [m] with an approach and a tool axis, in `duration` [s].
    /// The controller continues from the state of the previous step.
    #[pyo3(signature = (to, duration, *, force = None))]
    fn step(&mut self, py: Python<'_>, to: Place, duration: f64, force: Option<f64>) -> PyResult<Record> {
        let end = sample(to, self.steps.time + duration)?;
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(refused(format!("duration is {duration} s, and a positive one is accepted")));
        }
        let begin = self.steps.place.unwrap_or(PathSample { time: 0.0, ..end });
        let path = sim::Path::from_samples(vec![begin, end, beyond(&begin, &end)]).map_err(of)?;
        let settings = PassSettings { force_setpoint: force.unwrap_or(self.settings.force_setpoint), ..self.settings };
        let (number, trial_time) = (self.passes + 1, self.time);
        let Self { workpiece, tool, model, states, steps, .. } = self;
        let mut workpiece = workpiece.try_borrow_mut(py)?;
        let (grid, underway) = (&mut workpiece.part, lock(&mut steps.underway));
        let record = py.detach(|| {
            let pass = Pass { number, trial_time, ..Pass::first(tool, &path, &settings, model) };
            let grid = Arc::make_mut(grid);
            let record = run_stretch(grid, pass, states, (underway, end.time));
            underway.settle(grid);
            record
        });
        if record.is_ok() {
            (steps.time, steps.place) = (end.time, Some(end));
        } else {
            *steps = Steps::default();
        }
        record.map(Record::of).map_err(of)
    }

    /// Distance by which the controller has lifted the tool from its nominal position, along the approach axis [m].
    #[getter]
    fn travel(&self) -> f64 {
        held(&self.steps.underway).motion().travel
    }

    /// Ends a pass that was run step by step: the tool leaves the part.
    fn end_pass(&mut self) {
        if self.steps.place.is_some() {
            self.passes += 1;
            self.time += self.steps.time;
            self.steps = Steps::default();
        }
    }

    /// Current state of workpiece, tool and controller; bricks are shared.
    fn snapshot(&self, py: Python<'_>) -> PyResult<SimulationSnapshot> {
        let workpiece = self.workpiece.try_borrow(py)?;
        // Every step is complete at this point.
        let underway = held(&self.steps.underway).copy();
        Ok(SimulationSnapshot {
            part: workpiece.part.clone(),
            states: self.states.clone(),
            passes: self.passes,
            time: self.time,
            underway: Mutex::new(underway),
            step_time: self.steps.time,
            place: self.steps.place,
        })
    }

    /// Restores a state; the same steps give the same bytes.
    fn restore(&mut self, py: Python<'_>, snapshot: &SimulationSnapshot) -> PyResult<()> {
        self.workpiece.try_borrow_mut(py)?.part = snapshot.part.clone();
        let SimulationSnapshot { states, passes, time, underway, step_time, place, .. } = snapshot;
        let underway = held(underway).copy();
        (self.states, self.passes, self.time) = (states.clone(), *passes, *time);
        self.steps = Steps { underway: Mutex::new(underway), time: *step_time, place: *place };
        Ok(())
    }
}

/// Returns the value behind a lock with exclusive access.
fn lock(underway: &mut Mutex<Underway>) -> &mut Underway {
    underway.get_mut().unwrap_or_else(PoisonError::into_inner)
}

/// Locks the value for a short time.
fn held(underway: &Mutex<Underway>) -> MutexGuard<'_, Underway> {
    underway.lock().unwrap_or_else(PoisonError::into_inner)
}

fn sample((position, approach, axis): Place, time: f64) -> PyResult<PathSample> {
    let [position, approach, axis] = [position, approach, axis].map(DVec3::from_array);
    let (approach, axis) = (approach.normalize(), axis.normalize());
    if !(position + approach + axis).is_finite() || approach.dot(axis).abs() > 0.99 {
        return Err(refused(
            "a finite position is accepted, and an approach and an axis that are not along each other",
        ));
    }
    Ok(PathSample { time, position, approach, axis })
}

/// Extrapolates the tool's position by one more step; the surface is read up to there.
fn beyond(begin: &PathSample, end: &PathSample) -> PathSample {
    let way = end.position - begin.position;
    PathSample { time: 2.0 * end.time - begin.time, position: end.position + way, ..*end }
}
