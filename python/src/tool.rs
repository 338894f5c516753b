//! Tools, their paths, and the records of passes.

use std::sync::Arc;

use glam::DVec3;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1};
use pyo3::prelude::*;
use robot::{Controller, ToolText};
use sim::{CurvePoint, PassRecord, PathSample};

use crate::arrays::{Triples, from_vectors, vectors};
use crate::errors::{of, refused};

/// A rigid abrasive tool.
#[pyclass(frozen, module = "robofin")]
pub struct Tool {
    pub inner: robot::Tool,
    text: String,
}

#[pymethods]
impl Tool {
    /// A tool such as "wheel:radius=50mm,width=20mm", "pad:radius=25mm" or "sphere:radius=10mm".
    #[new]
    fn new(text: &str) -> PyResult<Self> {
        match text.parse::<ToolText>().map_err(refused)? {
            ToolText::Solid(inner) => Ok(Self { inner, text: text.to_owned() }),
            ToolText::Mesh(_) => Err(refused("only `robofin press` accepts a tool from a mesh file")),
        }
    }

    /// Width across the feed [m].
    #[getter]
    fn width(&self) -> f64 {
        self.inner.width()
    }

    fn __repr__(&self) -> String {
        format!("Tool({:?})", self.text)
    }
}

/// The path of a tool's nominal contact point.
#[pyclass(frozen, module = "robofin")]
pub struct Path {
    pub inner: Arc<sim::Path>,
}

impl Path {
    pub fn of(path: sim::Path) -> Self {
        Self { inner: Arc::new(path) }
    }
}

#[pymethods]
impl Path {
    /// A path from samples: times [s], shape `[n]`; nominal contact points [m], approach axes out of the part and tool
    /// axes across the feed, shape `[n, 3]` each.
    #[new]
    fn new(
        times: PyArrayLike1<'_, f64, AllowTypeChange>,
        positions: Triples,
        approach: Triples,
        axis: Triples,
    ) -> PyResult<Self> {
        let times = times.as_array();
        let columns = [("positions", &positions), ("approach", &approach), ("axis", &axis)];
        let [positions, approach, axis] = columns.map(|(name, array)| vectors(name, array));
        let (positions, approach, axis) = (positions?, approach?, axis?);
        for (name, rows) in [("positions", &positions), ("approach", &approach), ("axis", &axis)] {
            if rows.len() != times.len() {
                return Err(refused(format!("{name} has {} rows, and times has {}", rows.len(), times.len())));
            }
        }
        let sample = |(k, &time): (usize, &f64)| {
            let (position, approach, axis) = (positions[k], approach[k].normalize(), axis[k].normalize());
            PathSample { time, position, approach, axis }
        };
        let samples: Vec<PathSample> = times.iter().enumerate().map(sample).collect();
        if !samples.iter().all(|sample| (sample.position + sample.approach + sample.axis).is_finite()) {
            return Err(refused("a path of finite numbers is accepted, with directions that are not zero"));
        }
        sim::Path::from_samples(samples).map(Self::of).map_err(of)
    }

    /// Follows a curve of positions [m] with normals, shape `[n, 3]` each, at a feed [m/s], with the tool's axis across
    /// it.
    #[staticmethod]
    fn along(positions: Triples, normals: Triples, feed: f64) -> PyResult<Self> {
        let (positions, normals) = (vectors("positions", &positions)?, vectors("normals", &normals)?);
        if positions.len() != normals.len() {
            return Err(refused(format!("{} positions have {} normals", positions.len(), normals.len())));
        }
        let point = |(position, normal): (DVec3, DVec3)| CurvePoint { position, normal };
        let curve: Vec<CurvePoint> = positions.into_iter().zip(normals).map(point).collect();
        sim::Path::along(&curve, feed).map(Self::of).map_err(of)
    }

    /// The same path in the other direction.
    fn reversed(&self) -> Self {
        Self::of(self.inner.reversed())
    }

    /// Time of the last sample [s].
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration()
    }

    /// Length [m].
    #[getter]
    fn length(&self) -> f64 {
        self.inner.length()
    }

    /// Times of the samples [s].
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.inner.samples().iter().map(|sample| sample.time))
    }

    /// Nominal contact points [m], shape `[n, 3]`.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        from_vectors(py, self.inner.samples().iter().map(|sample| sample.position))
    }

    fn __repr__(&self) -> String {
        format!("Path({:.1} mm in {:.2} s)", self.inner.length() * 1e3, self.inner.duration())
    }
}

/// Log and integrals of a pass.
#[pyclass(frozen, module = "robofin")]
pub struct Record {
    inner: PassRecord,
}

impl Record {
    pub fn of(inner: PassRecord) -> Self {
        Self { inner }
    }

    fn column<'py>(&self, py: Python<'py>, value: fn(&robot::LogRow) -> f64) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.inner.log.iter().map(value))
    }
}

#[pymethods]
impl Record {
    /// Volume removed by Eq. (1) [m³].
    #[getter]
    fn removed_volume(&self) -> f64 {
        self.inner.removed_volume
    }

    /// Volume of coating removed by Eq. (2) [m³].
    #[getter]
    fn coating_volume(&self) -> f64 {
        self.inner.coating_volume
    }

    /// Impulse ∫ F dt [N s].
    #[getter]
    fn impulse(&self) -> f64 {
        self.inner.impulse
    }

    /// Load impulse ∫∫ p dA dt [N s].
    #[getter]
    fn load_impulse(&self) -> f64 {
        self.inner.load_impulse
    }

    /// Root mean square of force minus setpoint in contact [N].
    #[getter]
    fn force_rms_error(&self) -> f64 {
        self.inner.force_rms_error
    }

    /// Time in contact [s].
    #[getter]
    fn contact_time(&self) -> f64 {
        self.inner.contact_time
    }

    /// Greatest pressure [Pa].
    #[getter]
    fn pressure_max(&self) -> f64 {
        self.inner.pressure_max
    }

    /// Greatest area under pressure [m²].
    #[getter]
    fn area_max(&self) -> f64 {
        self.inner.area_max
    }

    /// Simulated time [s].
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration
    }

    /// Number of steps.
    #[getter]
    fn steps(&self) -> usize {
        self.inner.steps
    }

    /// Times of the log [s], shape `[n]`.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.time)
    }

    /// Normal forces of the log [N], shape `[n]`.
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.force)
    }

    /// Spindle speeds of the log [rad/s], shape `[n]`.
    #[getter]
    fn spindle_speeds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.spindle_speed)
    }

    /// Positions of the tool's reference point in the log [m], shape `[n, 3]`.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        from_vectors(py, self.inner.log.iter().map(|row| row.position))
    }

    /// Approach axes of the log, shape `[n, 3]`.
    #[getter]
    fn approaches<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        from_vectors(py, self.inner.log.iter().map(|row| row.approach))
    }

    /// The log in the program's CSV format.
    fn log_csv(&self) -> String {
        robofin::finishing::log_csv(&self.inner)
    }

    fn __repr__(&self) -> String {
        let Self { inner } = self;
        format!(
            "Record({} steps, {:.3} mm³ removed in {:.2} s)",
            inner.steps,
            inner.removed_volume * 1e9,
            inner.duration
        )
    }
}

/// Makes a controller from its name and parameters.
pub fn controller(kind: &str, mass: f64, damping: f64, period: f64) -> PyResult<Controller> {
    Ok(match kind {
        "ideal" => Controller::Ideal,
        "replay" => Controller::Replay,
        "admittance" => Controller::Admittance { mass, damping, period },
        _ => {
            let accepted = "\"ideal\", \"admittance\" or \"replay\"";
            return Err(refused(format!("controller is {kind:?}, and {accepted} is accepted")));
        }
    })
}
