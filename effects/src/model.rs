//! A model: a process, its base laws, and the assumed effects with their parameter values.
//!
//! ```
//! use effects::{Library, Model};
//!
//! let text = r#"
//! process = "grinding"
//!
//! [law.preston-threshold]
//! grind_rate = "1.4 mm/(MPa s)"
//!
//! [effect.grit-dulling]
//! dulling_volume = "350 mm^3"
//! "#;
//! let model = Model::parse("model.toml", text, Library::builtin()).unwrap();
//! assert_eq!(model.values("grit-dulling", "dulling_volume"), [350e-9]);
//! ```

use super::definition::{Effect, Kind, Rows};
use super::error::{EffectError, Problem};
use super::library::Library;
use super::nearest::hint;
use super::process::Process;
use super::toml_text::{BareNumber, Entry, Section, Source};
use super::variable::{Hook, Variable};

/// A law or effect of a model, with the values that differ from its defaults.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelPart {
    /// Name in the library.
    pub name: String,
    /// Parameters and their values [SI]: one, or one for each pass or scan.
    pub values: Vec<(String, Vec<f64>)>,
}

/// Contents of a model file.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The process.
    pub process: Process,
    /// Base laws.
    pub laws: Vec<ModelPart>,
    /// Effects.
    pub effects: Vec<ModelPart>,
    /// Parameters that fits may vary, as `effect.parameter`; `None` for those that the library marks as free.
    pub free: Option<Vec<String>>,
    /// Bounds that replace the library's [SI], by `effect.parameter`.
    pub ranges: Vec<(String, [f64; 2])>,
}

/// Reason why a model cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A fault in the file.
    #[error(transparent)]
    File(#[from] EffectError),
    /// An unknown law or effect.
    #[error("no {kind} is called `{name}`; {hint}")]
    UnknownPart {
        /// Law or effect.
        kind: &'static str,
        /// The name.
        name: String,
        /// A likely intended name, or the known names.
        hint: String,
    },
    /// An unknown parameter.
    #[error("`{owner}` has no parameter `{name}`; it has {known}")]
    UnknownParameter {
        /// Law or effect.
        owner: String,
        /// The name.
        name: String,
        /// Known names.
        known: String,
    },
    /// Several values for a parameter that has one.
    #[error("`{owner}.{name}` has {found} values; it has one for the whole model")]
    TooManyValues {
        /// Law or effect.
        owner: String,
        /// The parameter.
        name: String,
        /// Number of values given.
        found: usize,
    },
    /// A value that is not accepted.
    #[error("`{owner}.{name}`: {problem}")]
    BadValue {
        /// Law or effect.
        owner: String,
        /// The parameter.
        name: String,
        /// The fault.
        problem: Box<Problem>,
    },
    /// A law or effect that does nothing in this process.
    #[error("`{name}` does nothing when {process}", process = .process.name())]
    WrongProcess {
        /// Law or effect.
        name: String,
        /// The model's process.
        process: Process,
    },
    /// A law or effect named twice.
    #[error("`{0}` is in the model twice")]
    Twice(String),
    /// A value given by no law or by more than one.
    #[error("{found} laws of the model give `{value}`; exactly one is expected")]
    Laws {
        /// The value.
        value: &'static str,
        /// Number of laws that give it.
        found: usize,
    },
    /// Formulas that are too large in total.
    #[error("the formulas at the hook {place} are too large together: simplify or remove an effect")]
    TooLarge {
        /// The hook.
        place: Hook,
    },
}

impl Model {
    /// The base model of a process, with no effects.
    pub fn new(process: Process) -> Self {
        let law = |name: &&str| ModelPart { name: (*name).to_owned(), values: Vec::new() };
        let laws = process.laws().iter().map(law).collect();
        Self { process, laws, effects: Vec::new(), free: None, ranges: Vec::new() }
    }

    /// Adds an effect with default values.
    #[must_use]
    pub fn with(mut self, effect: &str) -> Self {
        self.effects.push(ModelPart { name: effect.to_owned(), values: Vec::new() });
        self
    }

    /// Sets all values of a parameter [SI].
    pub fn set(&mut self, owner: &str, parameter: &str, values: &[f64]) {
        let mut parts = self.laws.iter_mut().chain(&mut self.effects);
        if let Some(part) = parts.find(|part| part.name == owner) {
            part.values.retain(|(name, _)| name != parameter);
            part.values.push((parameter.to_owned(), values.to_vec()));
        }
    }

    /// Values that the model gives for a parameter [SI]; empty if the default is used.
    pub fn values(&self, owner: &str, parameter: &str) -> &[f64] {
        let parts = self.laws.iter().chain(&self.effects);
        let values = parts.filter(|part| part.name == owner).flat_map(|part| &part.values);
        values.filter(|(name, _)| name == parameter).map(|(_, values)| values.as_slice()).next().unwrap_or_default()
    }

    /// Bounds that the model gives for `effect.parameter` [SI].
    pub fn range_of(&self, path: &str) -> Option<[f64; 2]> {
        self.ranges.iter().find(|(name, _)| name == path).map(|(_, range)| *range)
    }

    /// Reads a model file. Values must lie within the range of their parameter, or within the model's own range if it
    /// states one.
    ///
    /// # Errors
    /// The first fault, with its position in the file.
    pub fn parse(file: &str, text: &str, library: &Library) -> Result<Self, ModelError> {
        let source = Source { file, text };
        let document = source.document()?;
        let root = Section::root(source, &document);
        let model = Self::read(&root, library)?;
        for key in ["law", "effect"] {
            model.check_ranges(&root, key, library)?;
        }
        Ok(model)
    }

    /// Reads a model file as [`Model::parse`] does, but accepts values outside the range of their parameter: for
    /// numbers that were checked against other bounds.
    ///
    /// # Errors
    /// The first fault, with its position in the file.
    pub fn parse_beyond_ranges(file: &str, text: &str, library: &Library) -> Result<Self, ModelError> {
        let source = Source { file, text };
        let document = source.document()?;
        Self::read(&Section::root(source, &document), library)
    }

    /// Rejects values of laws or effects that are out of range.
    fn check_ranges(&self, root: &Section, key: &str, library: &Library) -> Result<(), ModelError> {
        for (owner, table) in root.tables(key)? {
            for (name, entry) in table.entries() {
                let Some(parameter) = library.find(owner).and_then(|effect| effect.parameter(name)) else { continue };
                let accepted = parameter.accepted(self.process, self.range_of(&format!("{owner}.{name}")));
                for value in self.values(owner, name) {
                    accepted.check(*value).map_err(|problem| entry.error(problem))?;
                }
            }
        }
        Ok(())
    }

    fn read(root: &Section, library: &Library) -> Result<Self, ModelError> {
        root.accept(&["process", "free", "range", "law", "effect"])?;
        let process = root.need("process")?;
        let process = Process::from_name(process.text()?)
            .ok_or_else(|| process.unfit(format!("`{}`", process.text().unwrap_or_default()), "grinding or sanding"))?;
        let mut model = Self { laws: parts(root, "law", library)?, ..Self::new(process) };
        model.effects = parts(root, "effect", library)?;
        model.add_default_laws(library);
        model.resolve_laws(library)?;
        model.resolve_effects(library)?;
        if let Some(entry) = root.get("free") {
            let free = entry.texts()?;
            for path in &free {
                model.parameter(path, library).map_err(|_| unknown_path(&entry, path))?;
            }
            model.free = Some(free);
        }
        if let Some(entry) = root.get("range") {
            model.ranges = model.read_ranges(&entry.section()?, library)?;
        }
        Ok(model)
    }

    /// Adds the default laws whose value no law of the model gives.
    fn add_default_laws(&mut self, library: &Library) {
        for name in self.process.laws() {
            let gives = |name: &str, value: Variable| {
                library.find(name).is_some_and(|law| law.changes.iter().any(|change| change.value == value))
            };
            let Some(value) = library.find(name).and_then(|law| law.changes.first()).map(|change| change.value) else {
                continue;
            };
            if !self.laws.iter().any(|law| gives(&law.name, value)) {
                self.laws.push(ModelPart { name: name.to_owned(), values: Vec::new() });
            }
        }
    }

    fn read_ranges(&self, table: &Section, library: &Library) -> Result<Vec<(String, [f64; 2])>, ModelError> {
        let mut ranges = Vec::new();
        for (path, entry) in table.entries() {
            let unit = self.parameter(path, library).map_err(|_| unknown_path(&entry, path))?;
            match entry.quantities(unit, BareNumber::Refused)?[..] {
                [low, high] if low < high && low.is_finite() && high.is_finite() => {
                    ranges.push((path.to_owned(), [low, high]));
                }
                _ => return Err(entry.unfit("another list", "two finite values, the lesser first").into()),
            }
        }
        Ok(ranges)
    }

    /// Returns the unit of `effect.parameter` of this model.
    fn parameter(&self, path: &str, library: &Library) -> Result<super::unit::Unit, ()> {
        let (owner, name) = path.split_once('.').ok_or(())?;
        let mut parts = self.laws.iter().chain(&self.effects);
        parts.find(|part| part.name == owner).ok_or(())?;
        library.find(owner).and_then(|effect| effect.parameter(name)).map(|parameter| parameter.unit).ok_or(())
    }

    /// Returns the laws of this model.
    ///
    /// # Errors
    /// An unknown law, or a value that no law or more than one gives.
    pub fn resolve_laws<'l>(&self, library: &'l Library) -> Result<Vec<&'l Effect>, ModelError> {
        let laws = self.resolve(&self.laws, (Kind::Law, "law"), library)?;
        for value in [Variable::Pressure, self.process.signal().rate()] {
            let found = laws.iter().filter(|law| law.changes.iter().any(|change| change.value == value)).count();
            if found != 1 {
                return Err(ModelError::Laws { value: value.name(), found });
            }
        }
        Ok(laws)
    }

    /// Returns the effects of this model in the order in which they act.
    ///
    /// # Errors
    /// An unknown effect, or one that does nothing in the process.
    pub fn resolve_effects<'l>(&self, library: &'l Library) -> Result<Vec<&'l Effect>, ModelError> {
        let mut effects = self.resolve(&self.effects, (Kind::Effect, "effect"), library)?;
        let order = |effect: &&Effect| library.effects().iter().position(|known| known.name == effect.name);
        effects.sort_by_key(order);
        Ok(effects)
    }

    fn resolve<'l>(
        &self,
        parts: &[ModelPart],
        (kind, kind_name): (Kind, &'static str),
        library: &'l Library,
    ) -> Result<Vec<&'l Effect>, ModelError> {
        let known: Vec<&str> = library
            .all()
            .filter(|effect| effect.kind == kind && effect.acts_in(self.process))
            .map(|effect| effect.name.as_str())
            .collect();
        let find = |(index, part): (usize, &ModelPart)| {
            let name = part.name.clone();
            let Some(effect) = library.find(&name).filter(|effect| effect.kind == kind) else {
                let hint = hint(&name, &known);
                return Err(ModelError::UnknownPart { kind: kind_name, name, hint });
            };
            if !effect.acts_in(self.process) {
                return Err(ModelError::WrongProcess { name, process: self.process });
            }
            if parts[..index].iter().any(|other| other.name == name) {
                return Err(ModelError::Twice(name));
            }
            Ok(effect)
        };
        parts.iter().enumerate().map(find).collect()
    }

    /// Checks the values that the model gives for a law or effect.
    pub(super) fn check_values(&self, effect: &Effect) -> Result<(), ModelError> {
        let parts = self.laws.iter().chain(&self.effects).filter(|part| part.name == effect.name);
        for (name, values) in parts.flat_map(|part| &part.values) {
            let (owner, name) = (effect.name.clone(), name.clone());
            let Some(parameter) = effect.parameter(&name) else {
                let known: Vec<&str> = effect.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
                return Err(ModelError::UnknownParameter { owner, name, known: known.join(", ") });
            };
            if parameter.per == Rows::Model && values.len() != 1 {
                return Err(ModelError::TooManyValues { owner, name, found: values.len() });
            }
            if let Some(value) = values.iter().find(|value| value.is_nan()) {
                let problem = Problem::Value { found: value.to_string(), expected: "a number".to_owned() };
                return Err(ModelError::BadValue { owner, name, problem: Box::new(problem) });
            }
        }
        Ok(())
    }

    /// Returns true if fits may vary a parameter.
    pub(super) fn is_free(&self, path: &str, by_library: bool) -> bool {
        self.free.as_ref().map_or(by_library, |free| free.iter().any(|free| free == path))
    }
}

fn unknown_path(entry: &Entry, path: &str) -> EffectError {
    entry.unfit(format!("`{path}`"), "a parameter of this model, written as effect.parameter")
}

/// Reads the parts under `law` or `effect`, with their values.
fn parts(root: &Section, key: &str, library: &Library) -> Result<Vec<ModelPart>, ModelError> {
    let mut parts = Vec::new();
    for (name, table) in root.tables(key)? {
        let Some(effect) = library.find(name) else {
            let known: Vec<&str> = library.all().map(|effect| effect.name.as_str()).collect();
            let expected = format!("the name of a law or effect ({})", hint(name, &known));
            return Err(table.error(Problem::Value { found: format!("`{name}`"), expected }).into());
        };
        let names: Vec<&str> = effect.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        table.accept(&names)?;
        let values = table.entries().map(|(name, entry)| {
            let parameter = effect.parameter(name).expect("names are checked above");
            let values = entry.quantities(parameter.unit, BareNumber::Refused)?;
            if values.is_empty() || (parameter.per == Rows::Model && values.len() > 1) {
                return Err(entry.unfit(format!("{} values", values.len()), "one value"));
            }
            Ok((name.to_owned(), values))
        });
        parts.push(ModelPart { name: name.to_owned(), values: values.collect::<Result<_, EffectError>>()? });
    }
    Ok(parts)
}
