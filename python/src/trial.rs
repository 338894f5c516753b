//! Measured trials, simulated as they were logged.

use std::path::PathBuf;
use std::sync::Arc;

use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sdf_bake::PixelGrid;
use trial_simulation::{SimulatedPass, Simulation};
use trials::trial::{PassScan, Trial as MeasuredTrial};

use crate::errors::of;
use crate::field::Field;
use crate::model::Model;
use crate::tool::Record;
use crate::workpiece::Workpiece;

/// A trial folder: scans, logs, tool and controller.
#[pyclass(frozen, module = "robofin")]
pub struct Trial {
    inner: MeasuredTrial,
}

/// A pass of a simulated trial: its record, and the scan as the instrument would see it.
type Pass = (Record, Py<PyAny>);

#[pymethods]
impl Trial {
    /// Reads a trial folder and checks it.
    #[staticmethod]
    fn read(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        py.detach(|| MeasuredTrial::read(&folder)).map(|inner| Self { inner }).map_err(of)
    }

    /// Name of the trial.
    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    /// "grinding" or "sanding".
    #[getter]
    fn process(&self) -> &'static str {
        self.inner.process.name()
    }

    /// Number of passes.
    #[getter]
    fn passes(&self) -> usize {
        self.inner.passes.len()
    }

    /// Measured scans after each pass: `heights` [m] or `exposed`, shape `[ny, nx]`, NaN where missing; `origin` and
    /// `pitch` [m].
    fn scans<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        self.inner.passes.iter().map(|pass| scan(py, &pass.scan)).collect()
    }

    /// The workpiece in the scan before the first pass; `voxel` [m] defaults to the pitch of the scan.
    #[pyo3(signature = (voxel = None))]
    fn workpiece(&self, py: Python<'_>, voxel: Option<f64>) -> PyResult<Workpiece> {
        let voxel = voxel.unwrap_or(self.inner.scans.before.pixels.pitch);
        let part = py.detach(|| Simulation::new(&self.inner, voxel, false).map(|simulation| simulation.part));
        Ok(Workpiece::of(part.map_err(of)?))
    }

    /// Simulates the trial as it was logged. Returns record and scan of each pass, and the final field.
    #[pyo3(signature = (model, *, voxel = None, replay = false))]
    fn simulate(
        &self,
        py: Python<'_>,
        model: &Model,
        voxel: Option<f64>,
        replay: bool,
    ) -> PyResult<(Vec<Pass>, Field)> {
        let voxel = voxel.unwrap_or(self.inner.scans.before.pixels.pitch);
        let compiled = model.for_passes(self.inner.passes.len())?;
        let run = || {
            let simulation = Simulation::new(&self.inner, voxel, replay)?;
            simulation.run(&compiled, &mut Simulation::fresh_states(&compiled), 0, &mut |_, _| {})
        };
        let (passes, part) = py.detach(run).map_err(of)?;
        let each = |SimulatedPass { record, scan: seen, .. }| Ok((Record::of(record), scan(py, &seen)?.unbind()));
        Ok((passes.into_iter().map(each).collect::<PyResult<_>>()?, Field::of(Arc::new(part))))
    }

    fn __repr__(&self) -> String {
        format!("Trial({:?}, {}, {} passes)", self.inner.name, self.process(), self.passes())
    }
}

/// Returns the values of a scan, shape `[ny, nx]`, with its pixels: heights [m], or 1 where exposed; NaN where missing.
fn scan<'py>(py: Python<'py>, scan: &PassScan) -> PyResult<Bound<'py, PyAny>> {
    let heights = scan.heights().map(|map| ("heights", map.heights.clone()));
    let exposed = scan.mask().map(|mask| {
        let value = |exposed: &Option<bool>| exposed.map_or(f64::NAN, f64::from);
        ("exposed", mask.exposed.iter().map(value).collect())
    });
    let Some((name, values)) = heights.or(exposed) else { return Ok(py.None().into_bound(py)) };
    let PixelGrid { origin, pitch, nx, ny } = scan.pixels();
    let shown = PyDict::new(py);
    shown.set_item("origin", (origin.x, origin.y))?;
    shown.set_item("pitch", pitch)?;
    shown.set_item(name, PyArray1::from_vec(py, values).reshape([ny, nx])?)?;
    Ok(shown.into_any())
}
