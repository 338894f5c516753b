//! Changes to the text of a model file that preserve the rest of it, comments included.

use toml_edit::{Array, DocumentMut, Item, Table, TableLike, Value};

use super::definition::{Effect, Kind, Parameter, Rows};
use super::error::{EffectError, Problem};
use super::library::Library;
use super::model::{Model, ModelError, ModelPart};
use super::nearest::hint;
use super::process::Process;
use super::toml_text::{Source, parse_quantity};

/// A model file after a change, with one sentence per change.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// The new text.
    pub text: String,
    /// The model that the new text states.
    pub model: Model,
    /// Descriptions of the changes.
    pub changes: Vec<String>,
}

impl Model {
    /// Adds an effect to the text of a model. Its free parameters are written with their typical values; `given`
    /// replaces values, as parameter name and text with unit.
    ///
    /// # Errors
    /// A fault in the file, an unknown effect or parameter, or an effect that is already present or does nothing in
    /// this process.
    pub fn add_to_text(
        source: (&str, &str),
        name: &str,
        given: &[(String, String)],
        library: &Library,
    ) -> Result<Edit, ModelError> {
        let (file, text) = source;
        let mut model = Self::parse(file, text, library)?;
        model.effects.push(ModelPart { name: name.to_owned(), values: Vec::new() });
        model.resolve_effects(library)?;
        let effect = library.find(name).expect("the name is resolved above");
        let values = written_values(effect, model.process, given)?;

        let mut document = open(file, text)?;
        let mut table = Table::new();
        for (parameter, value) in &values {
            table.insert(&parameter.name, Item::Value(toml_value(parameter, &[*value])));
        }
        let mut implicit = Table::new();
        implicit.set_implicit(true);
        let effects = document.entry("effect").or_insert(Item::Table(implicit));
        if let Some(effects) = effects.as_table_like_mut() {
            effects.insert(name, Item::Table(table));
        }
        let mut changes = vec![format!("added {name}: {}", effect.title)];
        changes.extend(values.iter().map(|(parameter, value)| describe(parameter, *value, model.process)));
        let free: Vec<String> = effect
            .parameters
            .iter()
            .filter(|parameter| parameter.free.of(model.process))
            .map(|parameter| format!("{name}.{}", parameter.name))
            .collect();
        if let Some(list) = document.get_mut("free").and_then(Item::as_array_mut) {
            free.iter().for_each(|path| list.push(path));
            changes.push(format!("free for fits: {}", free.join(", ")));
        }
        finish(file, &document, changes, library)
    }

    /// Removes an effect from the text of a model, with all other entries of the file for its parameters.
    ///
    /// # Errors
    /// A fault in the file, or an effect that is not in it.
    pub fn remove_from_text(source: (&str, &str), name: &str, library: &Library) -> Result<Edit, ModelError> {
        let (file, text) = source;
        let model = Self::parse(file, text, library)?;
        if !model.effects.iter().any(|part| part.name == name) {
            let known: Vec<&str> = model.effects.iter().map(|part| part.name.as_str()).collect();
            let hint = if known.is_empty() { "the model has none".to_owned() } else { hint(name, &known) };
            return Err(ModelError::UnknownPart { kind: "effect", name: name.to_owned(), hint });
        }
        let mut document = open(file, text)?;
        let mut changes = vec![format!("removed {name}")];
        if let Some(effects) = document.get_mut("effect").and_then(Item::as_table_like_mut) {
            effects.remove(name);
        }
        let prefix = format!("{name}.");
        if let Some(free) = document.get_mut("free").and_then(Item::as_array_mut) {
            free.retain(|path| !path.as_str().is_some_and(|path| path.starts_with(&prefix)));
        }
        if let Some(ranges) = document.get_mut("range").and_then(Item::as_table_like_mut) {
            let paths: Vec<String> =
                ranges.iter().map(|(path, _)| path.to_owned()).filter(|path| path.starts_with(&prefix)).collect();
            for path in paths {
                ranges.remove(&path);
                changes.push(format!("removed the range of {path}"));
            }
        }
        finish(file, &document, changes, library)
    }

    /// Writes parameter values [SI] into the text of a model, as owner, parameter and one value or one per row.
    ///
    /// # Errors
    /// A fault in the file, or a parameter that the model does not have.
    pub fn set_in_text(
        source: (&str, &str),
        values: &[(String, String, Vec<f64>)],
        library: &Library,
    ) -> Result<Edit, ModelError> {
        let (file, text) = source;
        let model = Self::parse(file, text, library)?;
        let mut document = open(file, text)?;
        let mut changes = Vec::new();
        for (owner, name, values) in values {
            let key = if model.laws.iter().any(|part| part.name == *owner) { "law" } else { "effect" };
            let known = model.laws.iter().chain(&model.effects).any(|part| part.name == *owner);
            let effect = library.find(owner).filter(|_| known);
            let Some(effect) = effect else {
                return Err(ModelError::UnknownPart {
                    kind: "law or effect",
                    name: owner.clone(),
                    hint: "the file states none of this name".to_owned(),
                });
            };
            let parameter = find_parameter(effect, name)?;
            let table = table_at(document.as_table_mut(), &[key, owner]);
            table.insert(name, Item::Value(toml_value(parameter, values)));
            changes.push(format!("{owner}.{name} = {}", show_all(parameter, values)));
        }
        finish(file, &document, changes, library)
    }

    /// Writes the model as the text of a file.
    ///
    /// # Panics
    /// If the model names laws, effects or parameters that the library does not have; [`Model::parse`] and
    /// `CompiledModel::new` reject such a model.
    pub fn to_text(&self, library: &Library) -> String {
        let mut document = DocumentMut::new();
        document.insert("process", Item::Value(self.process.name().into()));
        if let Some(free) = &self.free {
            document.insert("free", Item::Value(free.iter().collect::<Array>().into()));
        }
        let parameter = |owner: &str, name: &str| {
            library.find(owner).and_then(|effect| effect.parameter(name)).expect("the library has the parameter")
        };
        for (path, range) in &self.ranges_with_values(library) {
            let (owner, name) = path.split_once('.').expect("a range belongs to effect.parameter");
            let table = table_at(document.as_table_mut(), &["range"]);
            let values = range.iter().map(|value| toml_value(parameter(owner, name), &[*value]));
            table.insert(path, Item::Value(values.collect::<Array>().into()));
        }
        for (key, parts) in [("law", &self.laws), ("effect", &self.effects)] {
            for part in parts {
                let table = table_at(document.as_table_mut(), &[key, &part.name]);
                for (name, values) in &part.values {
                    table.insert(name, Item::Value(toml_value(parameter(&part.name, name), values)));
                }
            }
        }
        document.to_string()
    }
}

/// Factor by which a written range extends past a value that lies outside the library's range.
const RANGE_MARGIN: f64 = 3.0;

impl Model {
    /// The model's own ranges, and wider ones for values that lie outside the library's ranges.
    fn ranges_with_values(&self, library: &Library) -> Vec<(String, [f64; 2])> {
        let mut ranges = self.ranges.clone();
        for part in self.laws.iter().chain(&self.effects) {
            for (name, values) in &part.values {
                let path = format!("{}.{name}", part.name);
                let parameter = library.find(&part.name).and_then(|effect| effect.parameter(name));
                let Some(parameter) = parameter.filter(|_| self.range_of(&path).is_none()) else { continue };
                let accepted = parameter.accepted(self.process, None);
                let outside = values.iter().copied().filter(|value| accepted.check(*value).is_err());
                let listed = parameter.range.of(self.process);
                let needed = outside.fold(listed, with_room);
                if needed != listed {
                    ranges.push((path, needed));
                }
            }
        }
        ranges
    }
}

/// Widens a range to contain a value outside it, with a margin.
fn with_room([low, high]: [f64; 2], value: f64) -> [f64; 2] {
    match value > high {
        true => [low, value + (RANGE_MARGIN - 1.0) * value.abs()],
        false if value > 0.0 => [value / RANGE_MARGIN, high],
        false => [RANGE_MARGIN * value, high],
    }
}

fn open(file: &str, text: &str) -> Result<DocumentMut, EffectError> {
    Source { file, text }.document().map(toml_edit::Document::into_mut)
}

/// Parses the written text again, so that no unreadable file is returned.
fn finish(file: &str, document: &DocumentMut, changes: Vec<String>, library: &Library) -> Result<Edit, ModelError> {
    let text = document.to_string();
    let model = Model::parse(file, &text, library)?;
    Ok(Edit { text, model, changes })
}

/// Returns the table under these keys; creates it if absent.
fn table_at<'a>(root: &'a mut Table, keys: &[&str]) -> &'a mut dyn TableLike {
    let mut table: &mut dyn TableLike = root;
    for (depth, key) in keys.iter().enumerate() {
        let mut fresh = Table::new();
        fresh.set_implicit(depth + 1 < keys.len());
        table = table.entry(key).or_insert(Item::Table(fresh)).as_table_like_mut().expect("the file is a valid model");
    }
    table
}

/// Values that an effect's table gets: those given, and typical values of the other free parameters.
fn written_values<'a>(
    effect: &'a Effect,
    process: Process,
    given: &[(String, String)],
) -> Result<Vec<(&'a Parameter, f64)>, ModelError> {
    for (name, _) in given {
        find_parameter(effect, name)?;
    }
    let mut values = Vec::new();
    for parameter in &effect.parameters {
        let text = given.iter().find(|(name, _)| *name == parameter.name).map(|(_, text)| text);
        if let Some(text) = text {
            let value = parse_quantity(text, parameter.unit).map_err(|problem| unfit(effect, parameter, problem))?;
            parameter.accepted(process, None).check(value).map_err(|problem| unfit(effect, parameter, problem))?;
            values.push((parameter, value));
        } else if parameter.free.of(process) && parameter.per == Rows::Model {
            values.push((parameter, parameter.default.of(process)));
        } else if parameter.free.of(process) {
            // One value per pass or scan: initially all at null, which a single value states.
            values.push((parameter, parameter.null.unwrap_or(parameter.default.of(process))));
        }
    }
    Ok(values)
}

fn unfit(effect: &Effect, parameter: &Parameter, problem: Problem) -> ModelError {
    ModelError::BadValue { owner: effect.name.clone(), name: parameter.name.clone(), problem: Box::new(problem) }
}

fn find_parameter<'a>(effect: &'a Effect, name: &str) -> Result<&'a Parameter, ModelError> {
    effect.parameter(name).ok_or_else(|| {
        let known: Vec<&str> = effect.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        ModelError::UnknownParameter { owner: effect.name.clone(), name: name.to_owned(), known: known.join(", ") }
    })
}

fn toml_value(parameter: &Parameter, values: &[f64]) -> Value {
    let one = |value: &f64| -> Value {
        let shown = parameter.unit.show(*value);
        let number = shown.parse().unwrap_or(*value);
        let plain = value.is_infinite() || parameter.unit_text == "1";
        if plain { Value::from(number) } else { format!("{shown} {}", parameter.unit_text).into() }
    };
    match values {
        [value] => one(value),
        list => list.iter().map(one).collect::<Array>().into(),
    }
}

fn show_all(parameter: &Parameter, values: &[f64]) -> String {
    let shown: Vec<String> = values.iter().map(|value| parameter.unit.show(*value)).collect();
    let unit = if parameter.unit_text == "1" { String::new() } else { format!(" {}", parameter.unit_text) };
    format!("{}{unit}", shown.join(", "))
}

fn describe(parameter: &Parameter, value: f64, process: Process) -> String {
    let [low, high] = parameter.range.of(process);
    let show = |value: f64| parameter.unit.show(value);
    let null = parameter.null.map_or(String::new(), |null| format!(", vanishes at {}", show(null)));
    let value = show_all(parameter, &[value]);
    format!("{} = {value}   range {} to {}{null}", parameter.name, show(low), show(high))
}

/// Effects of a library that act in the model's process and are not in the model.
pub fn candidates<'l>(model: &Model, library: &'l Library) -> Vec<&'l Effect> {
    let is_new = |effect: &&Effect| !model.effects.iter().any(|part| part.name == effect.name);
    let acts = |effect: &&Effect| effect.kind == Kind::Effect && effect.acts_in(model.process);
    library.effects().iter().filter(acts).filter(is_new).collect()
}
