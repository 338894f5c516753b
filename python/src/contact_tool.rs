//! A tool that a robot of another simulation carries.

use std::sync::{Arc, Mutex, PoisonError};

use effects::{CompiledModel, States};
use glam::DVec3;
use numpy::PyArray1;
use pyo3::prelude::*;
use robot::Controller;
use sdf_bake::BrickGrid;
use sim::{Pass, PassRecord, PassSettings, Path, PathSample, TOOL_CELLS, Underway, WrenchGauge, run_stretch};

use crate::errors::{of, refused};
use crate::model::Model;
use crate::tool::Tool;
use crate::workpiece::Workpiece;

/// Time for which the surface ahead of the tool is read [s]; if the tool moves otherwise, it is read again.
const AHEAD: f64 = 0.2;
/// Greatest error of a rotation's products of columns [1].
const ORTHONORMAL: f64 = 1e-6;

/// A tool whose motion another simulation gives, step by step.
#[pyclass(module = "robofin.robot")]
pub struct ContactTool {
    workpiece: Py<Workpiece>,
    part: Arc<BrickGrid>,
    tool: robot::Tool,
    model: Arc<CompiledModel>,
    settings: PassSettings,
    states: States,
    friction: f64,
    underway: Mutex<Underway>,
    place: Option<PathSample>,
    totals: Totals,
}

/// Sums over all steps.
#[derive(Default)]
struct Totals {
    time: f64,
    contact_time: f64,
    removed_volume: f64,
    impulse: f64,
}

impl Totals {
    fn add(&mut self, record: &PassRecord, duration: f64) {
        self.time += duration;
        self.contact_time += record.contact_time;
        self.removed_volume += record.removed_volume;
        self.impulse += record.impulse;
    }
}

#[pymethods]
impl ContactTool {
    /// A tool on a copy of a workpiece; bricks are shared until they change. `friction` is the coefficient of friction
    /// against the slip of the working surface [1]; `spindle_speed` [rad/s] and `coating` [m] have the program's
    /// defaults.
    #[new]
    #[pyo3(signature = (workpiece, tool, model, *, friction = 0.0, spindle_speed = None, coating = None))]
    fn new(
        py: Python<'_>,
        workpiece: Py<Workpiece>,
        tool: &Tool,
        model: &Model,
        friction: f64,
        spindle_speed: Option<f64>,
        coating: Option<f64>,
    ) -> PyResult<Self> {
        if !(friction >= 0.0 && friction.is_finite()) {
            return Err(refused(format!("friction is {friction}, and zero or a positive number is accepted")));
        }
        let usual = PassSettings::default();
        let settings = PassSettings {
            controller: Controller::Replay,
            spindle_speed: spindle_speed.unwrap_or(usual.spindle_speed),
            coating: coating.unwrap_or(usual.coating),
            ..usual
        };
        let part = workpiece.try_borrow(py)?.part.clone();
        let (tool, model) = (tool.inner.clone(), model.compiled.clone());
        settings.check(&part, &tool).map_err(of)?;
        Ok(Self {
            workpiece,
            part,
            states: States::new(&model, TOOL_CELLS),
            tool,
            model,
            settings,
            friction,
            underway: Mutex::default(),
            place: None,
            totals: Totals::default(),
        })
    }

    /// Moves the tool to a pose in the workpiece's frame in `duration` [s], removes material on the way, and returns
    /// the wrench on the tool at its end: force [N] and torque [N m] about `position`, shape `[6]`, in the workpiece's
    /// frame.
    ///
    /// `position` [m] is the tool's reference point: the centre of a wheel or ball, the middle of a pad's face. The
    /// columns of `rotation`, shape `[3, 3]`, are the tool's axes: x forward, y the axis of a wheel, z away from the
    /// part. From the last pose to this one the tool moves at a constant velocity; the first pose is where it begins.
    fn step<'py>(
        &mut self,
        py: Python<'py>,
        position: [f64; 3],
        rotation: [[f64; 3]; 3],
        duration: f64,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(refused(format!("duration is {duration} s, and a positive one is accepted")));
        }
        let end = self.sample(position, rotation, self.totals.time + duration)?;
        let begin = self.place.map_or(PathSample { time: self.totals.time, ..end }, |place| place);
        let path = Path::from_samples(vec![begin, end, beyond(&begin, &end)]).map_err(of)?;
        let Self { part, tool, model, settings, states, underway, .. } = self;
        let underway = underway.get_mut().unwrap_or_else(PoisonError::into_inner);
        let friction = self.friction;
        let done = py.detach(|| {
            let gauge = WrenchGauge::new(friction);
            let pass = Pass { gauge: Some(&gauge), ..Pass::first(tool, &path, settings, model) };
            let record = run_stretch(Arc::make_mut(part), pass, states, (underway, end.time))?;
            Ok((record, gauge.read()))
        });
        let (record, wrench) = done.map_err(|error: sim::PassError| of(error))?;
        self.totals.add(&record, duration);
        self.place = Some(end);
        let values = [wrench.force.to_array(), wrench.torque.to_array()].concat();
        Ok(PyArray1::from_vec(py, values))
    }

    /// The workpiece as it is now; it shares the bricks until either changes. What the tool removed since the last call
    /// is written into the field here, by which the further steps differ in rounding.
    fn workpiece(&mut self, py: Python<'_>) -> PyResult<Workpiece> {
        let Self { part, underway, .. } = self;
        let underway = underway.get_mut().unwrap_or_else(PoisonError::into_inner);
        py.detach(|| underway.settle(Arc::make_mut(part)));
        Ok(self.workpiece.try_borrow(py)?.with_part(self.part.clone()))
    }

    /// Time of all steps [s].
    #[getter]
    fn time(&self) -> f64 {
        self.totals.time
    }

    /// Time in contact [s].
    #[getter]
    fn contact_time(&self) -> f64 {
        self.totals.contact_time
    }

    /// Volume removed so far by Eq. (1) [m³].
    #[getter]
    fn removed_volume(&self) -> f64 {
        self.totals.removed_volume
    }

    /// Impulse of the normal force so far, ∫ F dt [N s].
    #[getter]
    fn impulse(&self) -> f64 {
        self.totals.impulse
    }
}

impl ContactTool {
    /// Returns the path's sample of a pose.
    fn sample(&self, position: [f64; 3], rotation: [[f64; 3]; 3], time: f64) -> PyResult<PathSample> {
        let centre = DVec3::from_array(position);
        let [x, y, z] = [0, 1, 2].map(|axis| DVec3::from_array(rotation.map(|row| row[axis])));
        let is_turn = (x.cross(y) - z).length() < ORTHONORMAL && [x, y, z].iter().all(|axis| is_unit(*axis));
        if !(centre.is_finite() && is_turn) {
            return Err(refused("a finite position is accepted, and a rotation with right-handed columns of length 1"));
        }
        Ok(PathSample::from_centre(time, centre, (z, y), &self.tool))
    }
}

fn is_unit(axis: DVec3) -> bool {
    (axis.length_squared() - 1.0).abs() < ORTHONORMAL
}

/// Extrapolates the tool's motion; the surface is read up to there.
fn beyond(begin: &PathSample, end: &PathSample) -> PathSample {
    let velocity = (end.position - begin.position) / (end.time - begin.time);
    PathSample { time: end.time + AHEAD, position: end.position + velocity * AHEAD, ..*end }
}
