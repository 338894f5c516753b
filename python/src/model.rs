//! Laws and effects.

use std::path::PathBuf;
use std::sync::Arc;

use effects::{CompiledModel, Library, ModelPart, NamedState, OneLine, Process, RowCounts, Unit};
use files::input::{self, MOST_TEXT_BYTES};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{of, refused};

/// Laws and effects with their values, compiled.
#[pyclass(frozen, module = "robofin")]
pub struct Model {
    library: Arc<Library>,
    stated: effects::Model,
    pub compiled: Arc<CompiledModel>,
}

/// A value: an SI number, or text with a unit.
#[derive(FromPyObject)]
enum Value {
    Si(f64),
    Text(String),
}

impl Model {
    fn of(library: Arc<Library>, stated: effects::Model) -> PyResult<Self> {
        let compiled = CompiledModel::new(&stated, &library, RowCounts::default()).map_err(of)?;
        Ok(Self { library, stated, compiled: Arc::new(compiled) })
    }

    /// Compiles the model for a trial with `passes` passes.
    pub fn for_passes(&self, passes: usize) -> PyResult<CompiledModel> {
        CompiledModel::new(&self.stated, &self.library, RowCounts { passes, scans: passes }).map_err(of)
    }

    /// Returns the SI value of a parameter of a law or effect.
    fn si(&self, owner: &str, name: &str, value: &Value) -> PyResult<f64> {
        let text = match value {
            Value::Si(value) => return Ok(*value),
            Value::Text(text) => text,
        };
        let known = self.library.find(owner).and_then(|effect| effect.parameter(name));
        let known = known.ok_or_else(|| refused(format!("no law or effect has a parameter `{owner}.{name}`")))?;
        let (value, unit) = Unit::quantity(text).map_err(refused)?;
        if unit.dimension != known.unit.dimension {
            return Err(refused(format!(
                "`{owner}.{name}` is {text:?}, and a value in {} is accepted",
                known.unit_text
            )));
        }
        Ok(value)
    }
}

#[pymethods]
impl Model {
    /// The base laws of a process, "grinding" or "sanding", with their defaults.
    #[new]
    #[pyo3(signature = (process = "grinding"))]
    fn new(process: &str) -> PyResult<Self> {
        let process = process_of(process)?;
        Self::of(Arc::new(Library::builtin().clone()), effects::Model::new(process))
    }

    /// Reads a model file; `effects` are effect files of your own.
    #[staticmethod]
    #[pyo3(signature = (path, effects = Vec::new()))]
    fn read(path: PathBuf, effects: Vec<PathBuf>) -> PyResult<Self> {
        let read = |file: &PathBuf| input::read_text(file, MOST_TEXT_BYTES).map_err(of);
        let own = effects.iter().map(|file| Ok((file.display().to_string(), read(file)?)));
        let library = Library::builtin().with(&own.collect::<PyResult<Vec<_>>>()?).map_err(of)?;
        let stated = effects::Model::parse(&path.display().to_string(), &read(&path)?, &library).map_err(of)?;
        Self::of(Arc::new(library), stated)
    }

    /// Parses the text of a model file.
    #[staticmethod]
    fn parse(text: &str) -> PyResult<Self> {
        let library = Library::builtin();
        let stated = effects::Model::parse("the model", text, library).map_err(of)?;
        Self::of(Arc::new(library.clone()), stated)
    }

    /// The model with an effect of the library added. Values are SI numbers, or text with a unit such as "350 mm^3".
    #[pyo3(signature = (name, **values))]
    fn with_effect(&self, name: &str, values: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut given = Vec::new();
        for (parameter, value) in values.into_iter().flatten() {
            let parameter: String = parameter.extract()?;
            given.push((parameter.clone(), vec![self.si(name, &parameter, &value.extract()?)?]));
        }
        let mut stated = self.stated.clone();
        stated.effects.push(ModelPart { name: name.to_owned(), values: given });
        Self::of(self.library.clone(), stated)
    }

    /// The model with an effect from a formula added, such as `rate * exp(-ground_volume / a)`; its unknown names need
    /// values.
    #[pyo3(signature = (line, name = "formula", **values))]
    fn with_formula(&self, line: &str, name: &str, values: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let mut given = Vec::new();
        for (parameter, value) in values.into_iter().flatten() {
            let si = match value.extract()? {
                Value::Si(value) => value,
                Value::Text(text) => Unit::quantity(&text).map_err(refused)?.0,
            };
            given.push((parameter.extract::<String>()?, si));
        }
        let states = NamedState::of_library(&self.library);
        let read = OneLine::parse(line, self.stated.process, &states, &self.library).map_err(of)?;
        let text = read.file(name, &|_| None, &given).map_err(of)?;
        let library = self.library.with(&[(format!("{name}.toml"), text)]).map_err(of)?;
        Self::of(Arc::new(library), self.stated.clone().with(name))
    }

    /// The model with a new value of a parameter such as "winkler.stiffness".
    fn with_value(&self, path: &str, value: &Bound<'_, PyAny>) -> PyResult<Self> {
        let names = path.split_once('.');
        let (owner, name) =
            names.ok_or_else(|| refused(format!("{path:?}: a name such as \"winkler.stiffness\" is accepted")))?;
        let parts = self.stated.laws.iter().chain(&self.stated.effects);
        if !parts.into_iter().any(|part| part.name == owner) {
            return Err(refused(format!("the model has no law or effect `{owner}`")));
        }
        let mut stated = self.stated.clone();
        stated.set(owner, name, &[self.si(owner, name, &value.extract()?)?]);
        Self::of(self.library.clone(), stated)
    }

    /// "grinding" or "sanding".
    #[getter]
    pub fn process(&self) -> &'static str {
        self.stated.process.name()
    }

    /// The text of the model file.
    #[getter]
    fn text(&self) -> String {
        self.stated.to_text(&self.library)
    }

    /// Values of all parameters [SI] by `effect.parameter`.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for (index, slot) in self.compiled.parameters().iter().enumerate() {
            values.set_item(slot.name(), self.compiled.value(index))?;
        }
        Ok(values)
    }

    /// Plausible ranges of all parameters [SI] by `effect.parameter`, from their files.
    #[getter]
    fn ranges<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let ranges = PyDict::new(py);
        for slot in self.compiled.parameters() {
            ranges.set_item(slot.name(), (slot.range[0], slot.range[1]))?;
        }
        Ok(ranges)
    }

    fn __repr__(&self) -> String {
        let effects: Vec<&str> = self.stated.effects.iter().map(|part| part.name.as_str()).collect();
        format!("Model({}, effects [{}])", self.process(), effects.join(", "))
    }
}

fn process_of(name: &str) -> PyResult<Process> {
    Process::from_name(name)
        .ok_or_else(|| refused(format!("process is {name:?}, and \"grinding\" or \"sanding\" is accepted")))
}

/// Returns names and titles of the effects of the program's library.
#[pyfunction]
pub fn effects_of_library() -> Vec<(String, String)> {
    Library::builtin().effects().iter().map(|effect| (effect.name.clone(), effect.title.clone())).collect()
}
