//! An effect from one line, such as `rate * exp(-ground_volume / a)`: the value that it changes, the states that it
//! needs, and its parameters with units, null values and ranges.

mod dimensions;
mod parameters;

use super::definition::{Formula, Holder, Motion, Reset, State};
use super::dimension::Dimension;
use super::library::Library;
use super::nearest::{hint, near};
use super::parse::{SyntaxError, parse};
use super::process::Process;
use super::syntax::Expr;
use super::variable::{Hook, Variable};
use dimensions::Dimensions;
pub use parameters::Extent;

/// Number of letters from which an unknown name similar to a known one is treated as a typing error, not as a
/// parameter.
const LONG_NAME: usize = 4;

/// Reason why a line defines no effect.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OneLineError {
    /// The line is not a formula.
    #[error("{line}: at character {at}, found {found}, {expected} is expected")]
    Syntax {
        /// The line.
        line: String,
        /// Character position, from 1.
        at: usize,
        /// The text found there.
        found: String,
        /// The accepted text.
        expected: String,
    },
    /// The line names no value that an effect may change, or several.
    #[error(
        "{line}: names {found} that an effect may change; begin it with one of {accepted}, as in `rate = rate * (1 + a)`"
    )]
    Value {
        /// The line.
        line: String,
        /// The value found.
        found: String,
        /// Values of the process.
        accepted: String,
    },
    /// A name that is known only at other hooks, or that is similar to a known one.
    #[error("`{name}`: {why}")]
    Name {
        /// The name.
        name: String,
        /// The fault, with a hint.
        why: String,
    },
    /// Two parts with different dimensions.
    #[error("`{part}` has the dimension {found}, and {expected} is needed there")]
    Dimension {
        /// The part of the formula.
        part: String,
        /// Its dimension.
        found: Dimension,
        /// Required dimension.
        expected: Dimension,
    },
    /// A line without parameters.
    #[error("{0}: every name is known, so there is nothing to fit; a parameter is any other name, such as a")]
    NoParameter(String),
    /// A parameter whose magnitude cannot be inferred.
    #[error(
        "`{name}` [{unit}]: nothing in the formula says how large it may be; give a value with --set \"{name}=1 {unit}\""
    )]
    NoExtent {
        /// The parameter.
        name: String,
        /// Its unit.
        unit: String,
    },
    /// A line that is the identity for no parameter at 0, 1 or infinity.
    #[error(
        "{line}: is not `{value}` for any parameter at 0, 1 or infinity, so the model without it is not part of it; write it \
         as {value} * (1 + a * ...) or {value} + a * ..."
    )]
    NoNull {
        /// The line.
        line: String,
        /// The value.
        value: &'static str,
    },
}

/// A state that a line may read by its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedState {
    name: String,
    per: Holder,
    dimension: Dimension,
    /// Its section in an effect file.
    section: String,
}

impl NamedState {
    /// States of a library's effects that depend on variables alone; of equal names, the first.
    pub fn of_library(library: &Library) -> Vec<Self> {
        let mut known: Vec<Self> = Vec::new();
        for state in library.effects().iter().flat_map(|effect| &effect.states) {
            let is_new = known.iter().all(|other| other.name != state.name);
            known.extend(Self::of(state).filter(|_| is_new));
        }
        known
    }

    /// A state that holds a value given by the data, such as a column of a table.
    pub fn measured(name: &str, unit: &str, dimension: Dimension) -> Self {
        let section = format!("[state.{name}]\nper = \"tool\"\nunit = \"{unit}\"\nrate = \"0\"\nreset = \"never\"\n\n");
        Self { name: name.to_owned(), per: Holder::Tool, dimension, section }
    }

    /// Name in formulas.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn of(state: &State) -> Option<Self> {
        let is_variable = |name: &str| Variable::find(name, state.per.place()).is_some();
        let own = |formula: &Formula| formula.tree.names().iter().all(|(name, _)| is_variable(name));
        let motion = match &state.motion {
            Motion::Rate(rate) if own(rate) => format!("rate = \"{}\"\n", rate.text),
            Motion::Relax { target, time } if own(target) && own(time) => {
                format!("target = \"{}\"\ntime = \"{}\"\n", target.text, time.text)
            }
            _ => return None,
        };
        if state.initial != 0.0 || state.bounds != [f64::NEG_INFINITY, f64::INFINITY] {
            return None;
        }
        let per = match state.per {
            Holder::Tool => "tool",
            Holder::ToolCell => "tool_cell",
            Holder::WorkpieceCell => "workpiece_cell",
        };
        let reset = match state.reset {
            Reset::FreshTool => "fresh_tool",
            Reset::Trial => "trial",
            Reset::Pass => "pass",
            Reset::Never => "never",
        };
        let (name, unit) = (state.name.clone(), &state.unit_text);
        let section = format!("[state.{name}]\nper = \"{per}\"\nunit = \"{unit}\"\n{motion}reset = \"{reset}\"\n\n");
        Some(Self { name, per: state.per, dimension: state.unit.dimension, section })
    }
}

/// A parameter of one line.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// Name in the formula.
    pub name: String,
    /// Dimension, inferred from the formula.
    pub dimension: Dimension,
}

/// An effect from one line.
#[derive(Clone, Debug, PartialEq)]
pub struct OneLine {
    line: String,
    process: Process,
    value: Variable,
    formula: String,
    /// Its parameters.
    pub unknowns: Vec<Unknown>,
    /// Declared names in it, with their dimensions.
    declared: Vec<(String, Dimension)>,
    states: Vec<NamedState>,
}

impl OneLine {
    /// Parses a line: a formula of a value that an effect may change, or `value = formula`.
    ///
    /// - `states`: states that it may read by name, beside the variables of the simulation
    ///
    /// # Errors
    /// The first fault of the line.
    pub fn parse(line: &str, process: Process, states: &[NamedState], library: &Library) -> Result<Self, OneLineError> {
        let (named, formula) = sides(line);
        let tree = parse(formula).map_err(|error| syntax(line, formula, &error))?;
        let (hook, value) = value_of(line, named, &tree, process)?;
        let laws = process.laws().into_iter().filter_map(|law| library.find(law));
        let law_parameters: Vec<(&str, Dimension)> =
            laws.flat_map(|law| &law.parameters).map(|own| (own.name.as_str(), own.unit.dimension)).collect();
        let readable = |state: &&NamedState| state.per.is_readable_at(hook);
        let dimension_of = |name: &str| {
            let state = states.iter().filter(readable).find(|state| state.name == name).map(|state| state.dimension);
            let law = || law_parameters.iter().find(|(own, _)| *own == name).map(|(_, dimension)| *dimension);
            Variable::find(name, hook).map(Variable::dimension).or(state).or_else(law)
        };
        let (mut unknowns, mut declared) = (Vec::new(), Vec::new());
        for (name, _) in tree.names() {
            match dimension_of(name) {
                Some(dimension) if declared.iter().all(|(own, _)| own != name) => {
                    declared.push((name.to_owned(), dimension));
                }
                Some(_) => {}
                None => {
                    check_unknown(name, hook, states)?;
                    if !unknowns.contains(&name.to_owned()) {
                        unknowns.push(name.to_owned());
                    }
                }
            }
        }
        if unknowns.is_empty() {
            return Err(OneLineError::NoParameter(line.to_owned()));
        }
        let found = Dimensions::solve((formula, &tree), value.dimension(), &unknowns, &dimension_of)?;
        let unknowns = unknowns.into_iter().zip(found).map(|(name, dimension)| Unknown { name, dimension }).collect();
        let states = states.iter().filter(|state| declared.iter().any(|(name, _)| *name == state.name)).cloned();
        let states = states.collect();
        Ok(Self { line: line.to_owned(), process, value, formula: formula.to_owned(), unknowns, declared, states })
    }

    /// Variables and states that the formula reads.
    pub fn reads(&self) -> impl Iterator<Item = &str> {
        self.declared.iter().map(|(name, _)| name.as_str())
    }

    /// True if it reads a state of this name.
    pub fn has_state(&self, name: &str) -> bool {
        self.states.iter().any(|state| state.name == name)
    }

    /// States that it reads, as sections of an effect file.
    pub fn state_sections(&self) -> String {
        self.states.iter().map(|state| state.section.as_str()).collect()
    }
}

/// Splits a line into the text before a single `=`, and the formula.
fn sides(line: &str) -> (Option<&str>, &str) {
    match line.split_once('=') {
        Some((name, formula)) if is_name(name.trim()) && !formula.starts_with('=') => {
            (Some(name.trim()), formula.trim())
        }
        _ => (None, line.trim()),
    }
}

fn is_name(text: &str) -> bool {
    !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn syntax(line: &str, formula: &str, error: &SyntaxError) -> OneLineError {
    let before = line.find(formula).unwrap_or(0) + error.span.start;
    let at = 1 + line.get(..before).map_or(0, |before| before.chars().count());
    OneLineError::Syntax { line: line.to_owned(), at, found: error.found.clone(), expected: error.expected.clone() }
}

/// Returns the value that a line changes: the assigned one, or the only one in the formula.
fn value_of(line: &str, named: Option<&str>, tree: &Expr, process: Process) -> Result<(Hook, Variable), OneLineError> {
    let hooks = Hook::HOOKS.into_iter().filter(|hook| process.has(*hook));
    let all: Vec<(Hook, Variable)> =
        hooks.flat_map(|hook| hook.values().iter().map(move |value| (hook, *value))).collect();
    let read = |name: &str| tree.names().iter().any(|(own, _)| *own == name);
    let of_name = |name: &str| all.iter().find(|(hook, value)| value.name() == name || hook.name() == name).copied();
    let found: Vec<(Hook, Variable)> = match named {
        Some(name) => of_name(name).into_iter().collect(),
        // Formulas begin with their value; otherwise it is the last, because later hooks may read the values of earlier
        // ones.
        None => {
            let begun = tree.names().first().and_then(|(name, _)| all.iter().find(|(_, value)| value.name() == *name));
            let last = || all.iter().rfind(|(_, value)| read(value.name()));
            begun.or_else(last).copied().into_iter().collect()
        }
    };
    let Some(&(hook, value)) = found.first() else {
        let accepted: Vec<&str> = all.iter().map(|(_, value)| value.name()).collect();
        let what = match named {
            Some(name) => format!("`{name}`, which is not a value of {}", process.name()),
            None => format!("no value of {}", process.name()),
        };
        return Err(OneLineError::Value { line: line.to_owned(), found: what, accepted: accepted.join(", ") });
    };
    Ok((hook, value))
}

/// Rejects a name that is known only at another hook, or that is similar to a known one.
fn check_unknown(name: &str, hook: Hook, states: &[NamedState]) -> Result<(), OneLineError> {
    let refused = |why: String| Err(OneLineError::Name { name: name.to_owned(), why });
    if let Some(variable) = Variable::ALL.iter().find(|variable| variable.name() == name) {
        let places: Vec<&str> = variable.row().places.iter().map(|place| place.name()).collect();
        return refused(format!("is not known at the hook {}; it is at {}", hook.name(), places.join(", ")));
    }
    let mut known: Vec<&str> = states.iter().map(NamedState::name).collect();
    known.extend(Variable::at(hook).map(|variable| variable.name()));
    if name.len() >= LONG_NAME && !near(name, known.iter().copied()).is_empty() {
        return refused(format!("{}; choose a parameter name that differs more", hint(name, &known)));
    }
    Ok(())
}

#[cfg(test)]
mod tests;
