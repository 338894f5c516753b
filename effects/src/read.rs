//! Reads an effect's file to an [`Effect`]: keys, values, units and formulas. `check` verifies the formulas.

use super::definition::{Change, Definition, Effect, Holder, Kind, Motion, Parameter, Reset, Rows, Scale, State};
use super::error::{EffectError, Problem};
use super::process::{ByProcess, Process};
use super::toml_text::{BareNumber, Entry, Section, Source, named};
use super::unit::Unit;
use super::variable::{Hook, Variable};

/// Greatest total number of nodes in a file's formulas: each is evaluated for every cell of every step. The longest
/// built-in file has a tenth of it.
const MOST_PARTS: usize = 4096;
/// Greatest number of entries of each of `[parameters]`, `[let]` and `[state]`.
const MOST_ENTRIES: usize = 256;

const KEYS: [&str; 12] = [
    "name",
    "title",
    "process",
    "source",
    "signature",
    "confused_with",
    "order",
    "parameters",
    "let",
    "state",
    "modify",
    "law",
];
/// Order of files that state none: they act after all others.
const LAST: u32 = u32::MAX;
const PARAMETER_KEYS: [&str; 9] = ["symbol", "unit", "null", "range", "scale", "default", "free", "per", "about"];
const STATE_KEYS: [&str; 9] = ["per", "unit", "rate", "target", "time", "initial", "reset", "min", "max"];

/// Reads an effect's file.
pub fn read(source: Source) -> Result<Effect, EffectError> {
    let document = source.document()?;
    let root = Section::root(source, &document);
    root.accept(&KEYS)?;
    let kind = match (root.get("modify"), root.get("law")) {
        (Some(_), None) => Kind::Effect,
        (None, Some(_)) => Kind::Law,
        (None, None) => {
            return Err(root.need("modify").err().unwrap_or_else(|| root.error(Problem::Missing("modify".into()))));
        }
        (Some(_), Some(law)) => return Err(law.unfit("[modify] and [law]", "one of them")),
    };
    let parameters = root.tables("parameters")?;
    let states = root.tables("state")?;
    for key in ["parameters", "let", "state"] {
        bounded(&root, key)?;
    }
    let name = name(&root)?;
    let effect = Effect {
        title: root.optional_text("title")?.unwrap_or_else(|| name.clone()),
        name,
        source: root.optional_text("source")?.unwrap_or_default(),
        kind,
        process: process(&root)?,
        signature: root.optional_text("signature")?.unwrap_or_default(),
        confused_with: root.get("confused_with").map(|entry| entry.texts()).transpose()?.unwrap_or_default(),
        order: root.get("order").map(|entry| entry.whole()).transpose()?.unwrap_or(LAST),
        parameters: parameters.iter().map(|(name, table)| parameter(name, table)).collect::<Result<_, _>>()?,
        definitions: definitions(&root)?,
        states: states.iter().map(|(name, table)| state(name, table)).collect::<Result<_, _>>()?,
        changes: changes(&root, if kind == Kind::Law { "law" } else { "modify" })?,
        file: source.file.to_owned(),
        text: source.text.to_owned(),
    };
    let parts: usize = effect.formulas().map(|formula| formula.tree.size()).sum();
    if parts > MOST_PARTS {
        let found = format!("formulas of {parts} parts together");
        return Err(root.error(Problem::Value { found, expected: format!("at most {MOST_PARTS} parts in a file") }));
    }
    Ok(effect)
}

/// Rejects a table with too many entries.
fn bounded(root: &Section, key: &str) -> Result<(), EffectError> {
    let Some(entry) = root.get(key) else { return Ok(()) };
    match entry.section()?.entries().count() {
        0..=MOST_ENTRIES => Ok(()),
        count => Err(entry.unfit(format!("{count} entries"), format!("at most {MOST_ENTRIES}"))),
    }
}

fn name(root: &Section) -> Result<String, EffectError> {
    let entry = root.need("name")?;
    let name = entry.text()?;
    let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if name.starts_with(|c: char| c.is_ascii_lowercase()) && name.chars().all(fits) {
        Ok(name.to_owned())
    } else {
        Err(entry.unfit(format!("`{name}`"), "lower-case letters, digits and hyphens, a letter first"))
    }
}

fn process(root: &Section) -> Result<Option<Process>, EffectError> {
    let Some(entry) = root.get("process") else { return Ok(None) };
    let name = entry.text()?;
    Process::from_name(name).map(Some).ok_or_else(|| entry.unfit(format!("`{name}`"), "grinding or sanding"))
}

/// Returns a name if formulas can use it.
fn formula_name(name: &str, table: &Section) -> Result<String, EffectError> {
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(fits) {
        Ok(name.to_owned())
    } else {
        let expected = "letters, digits and underscores, a letter first".to_owned();
        Err(table.error(Problem::Value { found: format!("`{name}`"), expected }))
    }
}

fn parameter(name: &str, table: &Section) -> Result<Parameter, EffectError> {
    table.accept(&PARAMETER_KEYS)?;
    let (unit, unit_text) = unit(table)?;
    let scale = table.choice("scale", &[("linear", Scale::Linear), ("lin", Scale::Linear), ("log", Scale::Log)])?;
    let null = table.get("null").map(|entry| entry.quantity(unit, BareNumber::InUnit)).transpose()?;
    let range = by_process(&table.need("range")?, |entry| range(entry, unit, scale))?;
    let default = match table.get("default") {
        Some(entry) => by_process(&entry, |entry| entry.quantity(unit, BareNumber::InUnit))?,
        None => ByProcess { grinding: middle(range.grinding, scale), sanding: middle(range.sanding, scale) },
    };
    let free = match table.get("free") {
        Some(entry) => by_process(&entry, |entry| entry.truth())?,
        None => ByProcess::both(true),
    };
    for process in Process::ALL {
        let (value, [low, high]) = (default.of(process), range.of(process));
        if !(low..=high).contains(&value) && Some(value) != null {
            let expected = format!("a value within the range, {} to {} {unit_text}", unit.show(low), unit.show(high));
            return Err(table.need("default")?.unfit(unit.show(value), expected));
        }
    }
    Ok(Parameter {
        name: formula_name(name, table)?,
        symbol: table.optional_text("symbol")?.unwrap_or_else(|| name.to_owned()),
        unit,
        unit_text,
        null,
        range,
        scale,
        default,
        free,
        per: table.choice("per", &[("model", Rows::Model), ("pass", Rows::Pass), ("scan", Rows::Scan)])?,
        about: table.optional_text("about")?.unwrap_or_default(),
        line: table.line(),
    })
}

fn unit(table: &Section) -> Result<(Unit, String), EffectError> {
    let entry = table.need("unit")?;
    let text = entry.text()?;
    let unit = Unit::parse(text).map_err(|error| entry.error(error.into()))?;
    Ok((unit, text.to_owned()))
}

fn range(entry: &Entry, unit: Unit, scale: Scale) -> Result<[f64; 2], EffectError> {
    let values = entry.quantities(unit, BareNumber::InUnit)?;
    let expected = match scale {
        Scale::Linear => "two finite numbers, the lesser first",
        Scale::Log => "two finite numbers above zero, the lesser first",
    };
    match values[..] {
        [low, high] if low < high && high.is_finite() && low.is_finite() && (low > 0.0 || scale == Scale::Linear) => {
            Ok([low, high])
        }
        _ => Err(entry.unfit(format!("{values:?}"), expected)),
    }
}

fn middle([low, high]: [f64; 2], scale: Scale) -> f64 {
    match scale {
        Scale::Linear => 0.5 * (low + high),
        Scale::Log => (low * high).sqrt(),
    }
}

/// Reads one value, or a table `{ grinding = …, sanding = … }`.
fn by_process<T: Copy>(
    entry: &Entry,
    read: impl Fn(&Entry) -> Result<T, EffectError>,
) -> Result<ByProcess<T>, EffectError> {
    if !entry.is_table() {
        return Ok(ByProcess::both(read(entry)?));
    }
    let table = entry.section()?;
    table.accept(&Process::ALL.map(Process::name))?;
    let of = |process: Process| read(&table.need(process.name())?);
    Ok(ByProcess { grinding: of(Process::Grinding)?, sanding: of(Process::Sanding)? })
}

fn definitions(root: &Section) -> Result<Vec<Definition>, EffectError> {
    let Some(entry) = root.get("let") else { return Ok(Vec::new()) };
    let table = entry.section()?;
    table
        .entries()
        .map(|(name, entry)| Ok(Definition { name: formula_name(name, &table)?, formula: entry.formula()? }))
        .collect()
}

fn state(name: &str, table: &Section) -> Result<State, EffectError> {
    table.accept(&STATE_KEYS)?;
    let (unit, unit_text) = if table.get("unit").is_some() { unit(table)? } else { (Unit::ONE, String::new()) };
    let holders = [Holder::Tool, Holder::ToolCell, Holder::WorkpieceCell].map(|holder| (holder.name(), holder));
    let resets =
        [("fresh_tool", Reset::FreshTool), ("trial", Reset::Trial), ("pass", Reset::Pass), ("never", Reset::Never)];
    let bound = |key: &str, open: f64| match table.get(key) {
        Some(entry) => entry.quantity(unit, BareNumber::InUnit),
        None => Ok(open),
    };
    let initial = bound("initial", 0.0)?;
    let bounds = [bound("min", f64::NEG_INFINITY)?, bound("max", f64::INFINITY)?];
    if !(bounds[0]..=bounds[1]).contains(&initial) {
        return Err(table.error(Problem::Value {
            found: format!("initial {}", unit.show(initial)),
            expected: "a value from min to max".to_owned(),
        }));
    }
    table.need("per")?;
    Ok(State {
        name: formula_name(name, table)?,
        per: table.choice("per", &holders)?,
        unit,
        unit_text,
        motion: motion(table)?,
        initial,
        reset: table.choice("reset", &resets)?,
        bounds,
        line: table.line(),
    })
}

fn motion(table: &Section) -> Result<Motion, EffectError> {
    match (table.get("rate"), table.get("target")) {
        (Some(rate), None) => Ok(Motion::Rate(rate.formula()?)),
        (None, Some(target)) => Ok(Motion::Relax { target: target.formula()?, time: table.need("time")?.formula()? }),
        _ => {
            let expected = "either `rate`, or `target` and `time`".to_owned();
            Err(table.error(Problem::Value { found: "neither or both of rate and target".to_owned(), expected }))
        }
    }
}

fn changes(root: &Section, key: &str) -> Result<Vec<Change>, EffectError> {
    let mut changes = Vec::new();
    for (name, entry) in root.need(key)?.section()?.entries() {
        let Some((hook, value)) = Variable::modified_by(name) else {
            let values = Hook::HOOKS.iter().flat_map(|hook| hook.values());
            let accepted: Vec<&str> = values.map(|value| value.name()).collect();
            return Err(
                entry.error(Problem::UnknownKey { found: named(name, &accepted), accepted: accepted.join(", ") })
            );
        };
        if changes.iter().any(|change: &Change| change.value == value) {
            return Err(entry.unfit(format!("a second formula for {}", value.name()), "one"));
        }
        changes.push(Change { hook, value, formula: entry.formula()? });
    }
    if changes.is_empty() {
        return Err(root.need(key)?.unfit("no formula", "at least one, such as rate = \"rate * 0.9\""));
    }
    changes.sort_by_key(|change| (change.hook, change.value));
    Ok(changes)
}
