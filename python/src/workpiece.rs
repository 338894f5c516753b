//! Workpieces: a field that tools change, and its welds.

use std::path::PathBuf;
use std::sync::Arc;

use files::folder::StagedFolder;
use files::output::OutputPath;
use glam::DVec3;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robofin::asset::{self, ASSET, AssetFields, Extras, Manifest, UsdMode, WeldTruth, Welds};
use robofin::console::Console;
use robofin::finishing::followed;
use robofin::workpiece::WeldingOptions;
use sdf_bake::BrickGrid;
use sim::CurvePoint;

use crate::arrays::from_vectors;
use crate::errors::{failed, of, refused};
use crate::field::Field;
use crate::tool::{Path, Tool};

/// A welded part with the result of its welding.
pub struct WeldedPart {
    pub workpiece: robofin::workpiece::Workpiece,
    pub options: WeldingOptions,
}

/// A part that tools change.
#[pyclass(module = "robofin")]
pub struct Workpiece {
    pub part: Arc<BrickGrid>,
    pub target: Option<Arc<BrickGrid>>,
    pub welds: Vec<WeldTruth>,
    made: Option<Arc<WeldedPart>>,
}

/// State of a workpiece at one moment; it shares the bricks until the workpiece changes.
#[pyclass(frozen, module = "robofin")]
pub struct Snapshot {
    part: Arc<BrickGrid>,
}

impl Workpiece {
    /// Makes a workpiece without a weld.
    pub fn of(part: Arc<BrickGrid>) -> Self {
        Self { part, target: None, welds: Vec::new(), made: None }
    }

    /// Makes a workpiece from a welded part.
    pub fn welded(made: WeldedPart) -> Self {
        let robofin::workpiece::Workpiece { welded, target, welds, .. } = &made.workpiece;
        Self {
            part: Arc::new(welded.clone()),
            target: Some(Arc::new(target.clone())),
            welds: Welds::of(welds).welds,
            made: Some(Arc::new(made)),
        }
    }

    /// Returns the workpiece with another field in place of its own.
    pub fn with_part(&self, part: Arc<BrickGrid>) -> Self {
        Self { part, target: self.target.clone(), welds: self.welds.clone(), made: None }
    }

    /// Returns a weld by its number, from 0.
    pub fn weld_at(&self, number: usize) -> PyResult<&WeldTruth> {
        let count = self.welds.len();
        self.welds.get(number).ok_or_else(|| refused(format!("there is no weld {number}; the workpiece has {count}")))
    }
}

#[pymethods]
impl Workpiece {
    /// A workpiece without a weld; it shares the field's bricks.
    #[new]
    fn new(field: &Field) -> Self {
        Self::of(field.inner.clone())
    }

    /// Opens an asset folder: the welded field, the target and the welds.
    #[staticmethod]
    fn from_asset(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let open = || {
            Manifest::read(&folder)?;
            anyhow::Ok((AssetFields::open(&folder)?, Welds::read(&folder)?.welds))
        };
        let (fields, welds) = py.detach(open).map_err(|error| failed(&error.context(folder.display().to_string())))?;
        Ok(Self { part: Arc::new(fields.welded), target: Some(Arc::new(fields.target)), welds, made: None })
    }

    /// The current field; it shares the bricks until the workpiece changes.
    #[getter]
    fn field(&self) -> Field {
        Field::of(self.part.clone())
    }

    /// The part without its welds, if known.
    #[getter]
    fn target(&self) -> Option<Field> {
        self.target.clone().map(Field::of)
    }

    /// Sizes [m, m³] and centrelines of the welds: `position` [m], `tangent`, `normal`, `side`, shape `[n, 3]` each.
    #[getter]
    fn welds<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        self.welds.iter().map(|weld| facts(py, weld)).collect()
    }

    /// The path that `robofin simulate` follows on a weld at a feed [m/s], and the search range for the tool above and
    /// below it [m].
    #[pyo3(signature = (tool, feed, weld = 0))]
    fn weld_path(&self, tool: &Tool, feed: f64, weld: usize) -> PyResult<(Path, f64)> {
        let (curve, reach): (Vec<CurvePoint>, f64) = followed(self.weld_at(weld)?, &tool.inner);
        Ok((Path::of(sim::Path::along(&curve, feed).map_err(of)?), reach))
    }

    /// The current state of the workpiece. Bricks are shared, so nothing is copied now; the next change copies them
    /// once.
    fn snapshot(&self) -> Snapshot {
        Snapshot { part: self.part.clone() }
    }

    /// Restores a state, bit for bit.
    fn restore(&mut self, snapshot: &Snapshot) {
        self.part = snapshot.part.clone();
    }

    /// Writes the asset folder of a workpiece that `weld` made, without USD. `force` replaces an earlier asset.
    #[pyo3(signature = (folder, *, force = false))]
    fn save(&self, py: Python<'_>, folder: PathBuf, force: bool) -> PyResult<PathBuf> {
        let Some(made) = &self.made else {
            return Err(refused("only a workpiece that `weld` made is an asset; write its field instead"));
        };
        let write = || {
            let staged = StagedFolder::new(&OutputPath { force, ..OutputPath::fresh(&folder) }, &ASSET)?;
            asset::write(&made.workpiece, &made.options, staged, Extras::full(UsdMode::Off), &Console::silent())
        };
        py.detach(write).map_err(|error| failed(&error))
    }

    fn __repr__(&self) -> String {
        format!("Workpiece({} welds, voxel {} mm)", self.welds.len(), self.part.voxel * 1e3)
    }
}

/// Returns sizes and centreline of a weld in SI units.
fn facts<'py>(py: Python<'py>, weld: &WeldTruth) -> PyResult<Bound<'py, PyDict>> {
    let facts = PyDict::new(py);
    facts.set_item("id", weld.id)?;
    for (name, value) in [
        ("width", weld.width_mm * 1e-3),
        ("height", weld.height_mm * 1e-3),
        ("length", weld.length_mm * 1e-3),
        ("volume", weld.volume_mm3 * 1e-9),
        ("toe_height", weld.toe_height_mm * 1e-3),
    ] {
        facts.set_item(name, value)?;
    }
    let curve = &weld.curve;
    let columns: [(&str, &Vec<DVec3>); 4] =
        [("position", &curve.position), ("tangent", &curve.tangent), ("normal", &curve.normal), ("side", &curve.side)];
    for (name, vectors) in columns {
        facts.set_item(name, from_vectors(py, vectors.iter().copied())?)?;
    }
    Ok(facts)
}
