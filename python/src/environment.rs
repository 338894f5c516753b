//! Environments of policies.

use std::sync::{Arc, Mutex};

use environments::{Limits, METRICS, Observation, Outputs, Randomisation, Setup, WeldFacts};
use glam::DVec3;
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2, PyReadwriteArrayDyn};
use pyo3::prelude::*;
use robot::Controller;

use crate::errors::{of, refused};
use crate::model::Model;
use crate::tool::Tool;
use crate::workpiece::Workpiece;

/// A weld to be finished.
#[pyclass(frozen, module = "robofin")]
pub struct Task {
    inner: Arc<environments::Task>,
}

#[pymethods]
impl Task {
    /// The task to grind off a weld of a workpiece whose part before welding is known.
    #[staticmethod]
    #[pyo3(signature = (workpiece, weld = 0))]
    fn grinding(py: Python<'_>, workpiece: &Workpiece, weld: usize) -> PyResult<Self> {
        let (facts, points) = weld_of(workpiece, weld)?;
        let target = target_of(workpiece)?;
        let part = &workpiece.part;
        let task = py.detach(|| environments::Task::grinding(part, target, facts, &points)).map_err(of)?;
        Ok(Self { inner: Arc::new(task) })
    }

    /// The task to sand the coating off a strip along a weld that was ground flush.
    #[staticmethod]
    #[pyo3(signature = (workpiece, weld = 0))]
    fn sanding(py: Python<'_>, workpiece: &Workpiece, weld: usize) -> PyResult<Self> {
        let (facts, points) = weld_of(workpiece, weld)?;
        let target = target_of(workpiece)?;
        let task = py.detach(|| environments::Task::sanding(target, facts, &points)).map_err(of)?;
        Ok(Self { inner: Arc::new(task) })
    }

    /// "grinding" or "sanding".
    #[getter]
    fn process(&self) -> &'static str {
        self.inner.process.name()
    }

    /// Volume of the bead above the target [m³].
    #[getter]
    fn volume(&self) -> f64 {
        self.inner.volume
    }

    /// Length of the weld [m].
    #[getter]
    fn length(&self) -> f64 {
        self.inner.curve.length()
    }

    /// Width of the weld [m].
    #[getter]
    fn width(&self) -> f64 {
        self.inner.weld.width
    }

    /// Bytes that an environment copies when its workpiece first changes.
    #[getter]
    fn nbytes(&self) -> usize {
        self.inner.part.bytes()
    }
}

/// Returns the sizes of a weld, and its centreline.
fn weld_of(workpiece: &Workpiece, number: usize) -> PyResult<(WeldFacts, Vec<(DVec3, DVec3)>)> {
    let weld = workpiece.weld_at(number)?;
    let points = weld.curve.position.iter().copied().zip(weld.curve.normal.iter().copied()).collect();
    Ok((WeldFacts { width: weld.width_mm * 1e-3, height: weld.height_mm * 1e-3 }, points))
}

fn target_of(workpiece: &Workpiece) -> PyResult<&sdf_bake::BrickGrid> {
    workpiece.target.as_deref().ok_or_else(|| refused("the workpiece has no target; `weld` and assets give one"))
}

/// Many environments, stepped together on several threads.
#[pyclass(module = "robofin")]
pub struct Batch {
    inner: Mutex<environments::Batch>,
    observation: Observation,
}

/// State of an environment at one moment.
#[pyclass(frozen, module = "robofin")]
pub struct EnvironmentSnapshot {
    inner: Mutex<environments::Snapshot>,
}

/// An array of any shape that is written in place.
type Written<'py> = PyReadwriteArrayDyn<'py, f32>;

#[pymethods]
impl Batch {
    /// Makes environments with consecutive seeds.
    #[new]
    #[pyo3(signature = (tasks, tool, model, count, *, seed = 0, observation = "state", randomise = Vec::new(),
                        controller = (2.0, 1500.0, 4e-3), time_limit = None, limits = Vec::new()))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of Python")]
    fn new(
        py: Python<'_>,
        tasks: Vec<Py<Task>>,
        tool: &Tool,
        model: &Model,
        count: usize,
        seed: u64,
        observation: &str,
        randomise: Vec<(String, Option<[f64; 2]>)>,
        controller: (f64, f64, f64),
        time_limit: Option<f64>,
        limits: Vec<(String, f64)>,
    ) -> PyResult<Self> {
        let draw = |(name, range): &(String, Option<[f64; 2]>)| Randomisation::new(&model.compiled, name, *range);
        let (mass, damping, period) = controller;
        let observation = observation_of(observation)?;
        let setup = Setup {
            tasks: tasks.iter().map(|task| task.get().inner.clone()).collect(),
            tool: tool.inner.clone(),
            model: model.compiled.clone(),
            randomisations: randomise.iter().map(draw).collect::<Result<_, _>>().map_err(of)?,
            limits: limits_of(&limits)?,
            controller: Controller::Admittance { mass, damping, period },
            observation,
            time_limit,
        };
        if let Some(task) = setup.tasks.iter().find(|task| task.process.name() != model.process()) {
            return Err(refused(format!(
                "the model is for {}, and a task for {}",
                model.process(),
                task.process.name()
            )));
        }
        let inner = py.detach(|| environments::Batch::new(setup, count, seed)).map_err(of)?;
        Ok(Self { inner: Mutex::new(inner), observation })
    }

    /// Begins episodes where `mask` is true: the first one of a seed, or the next one. Writes all observations.
    fn reset(
        &mut self,
        py: Python<'_>,
        seeds: Vec<Option<u64>>,
        mask: PyReadonlyArray1<bool>,
        mut observations: Written,
    ) -> PyResult<()> {
        let (mask, seen) = (mask.as_slice()?, observations.as_slice_mut()?);
        let batch = batch(&mut self.inner);
        py.detach(|| batch.reset((&seeds, mask), seen)).map_err(of)
    }

    /// Steps all environments under actions, shape `[n, 5]`, and writes the results into the other arrays.
    #[expect(clippy::too_many_arguments, reason = "arrays that are written in place")]
    fn step(
        &mut self,
        py: Python<'_>,
        actions: PyReadonlyArray2<f32>,
        mut observations: Written,
        mut rewards: PyReadwriteArray1<f64>,
        mut terminated: PyReadwriteArray1<bool>,
        mut truncated: PyReadwriteArray1<bool>,
        mut metrics: PyReadwriteArray2<f64>,
    ) -> PyResult<()> {
        let actions = actions.as_slice()?;
        let mut outputs = Outputs {
            observations: observations.as_slice_mut()?,
            rewards: rewards.as_slice_mut()?,
            terminated: terminated.as_slice_mut()?,
            truncated: truncated.as_slice_mut()?,
            metrics: metrics.as_slice_mut()?,
        };
        let batch = batch(&mut self.inner);
        py.detach(|| batch.step(actions, &mut outputs)).map_err(of)
    }

    /// Shape of one environment's observation.
    #[getter]
    fn observation_shape(&self) -> Vec<usize> {
        self.observation.shape()
    }

    /// Names of the columns of `metrics`.
    #[staticmethod]
    fn metric_names() -> Vec<&'static str> {
        METRICS.to_vec()
    }

    /// The current workpiece of an environment; it shares the bricks.
    fn workpiece(&mut self, number: usize) -> PyResult<Workpiece> {
        let batch = batch(&mut self.inner);
        Ok(Workpiece::of(environment(batch, number)?.part().clone()))
    }

    /// The current state of an environment, for `restore`.
    fn snapshot(&mut self, number: usize) -> PyResult<EnvironmentSnapshot> {
        let inner = environment(batch(&mut self.inner), number)?.snapshot();
        Ok(EnvironmentSnapshot { inner: Mutex::new(inner) })
    }

    /// Restores an environment's state; its next step is that of the snapshot, bit for bit.
    fn restore(&mut self, number: usize, snapshot: &EnvironmentSnapshot) -> PyResult<()> {
        let batch = batch(&mut self.inner);
        environment(batch, number)?;
        let snapshot = snapshot.inner.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        batch.environment_mut(number).restore(&snapshot);
        Ok(())
    }

    /// Observation of one environment, as one row of numbers.
    fn observe<'py>(&mut self, py: Python<'py>, number: usize) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let mut seen = vec![0.0; self.observation.size()];
        environment(batch(&mut self.inner), number)?.observe(&mut seen);
        Ok(PyArray1::from_vec(py, seen))
    }
}

/// Returns the batch behind the lock with exclusive access.
fn batch(inner: &mut Mutex<environments::Batch>) -> &mut environments::Batch {
    inner.get_mut().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn environment(batch: &environments::Batch, number: usize) -> PyResult<&environments::Environment> {
    let count = batch.environments().len();
    let found = batch.environments().get(number);
    found.ok_or_else(|| refused(format!("there is no environment {number}; the batch has {count}")))
}

fn observation_of(name: &str) -> PyResult<Observation> {
    Ok(match name {
        "state" => Observation::State,
        "heights" => Observation::Heights,
        "depth" => Observation::Depth,
        "rgb" => Observation::Rgb,
        _ => {
            let accepted = "\"state\", \"heights\", \"depth\" or \"rgb\"";
            return Err(refused(format!("observation is {name:?}, and {accepted} is accepted")));
        }
    })
}

/// Returns the default limits, with the given ones replaced.
fn limits_of(given: &[(String, f64)]) -> PyResult<Limits> {
    let mut limits = Limits::default();
    for (name, value) in given {
        let place = match name.as_str() {
            "period" => &mut limits.period,
            "feed" => &mut limits.feed,
            "across" => &mut limits.across,
            "turning" => &mut limits.turning,
            "tilt" => &mut limits.tilt,
            "force" => &mut limits.force,
            "least_force" => &mut limits.least_force,
            "slew" => &mut limits.slew,
            _ => {
                let accepted = "period, feed, across, turning, tilt, force, least_force or slew";
                return Err(refused(format!("limit {name:?}: {accepted} is accepted")));
            }
        };
        if !(*value > 0.0 && value.is_finite()) {
            return Err(refused(format!("limit {name} is {value}, and a positive one is accepted")));
        }
        *place = *value;
    }
    Ok(limits)
}
