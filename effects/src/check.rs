//! Checks that every file must pass before use: known names, matching dimensions, no circular definitions, and an
//! effect that vanishes at its null value.

use super::definition::{Effect, Formula, Kind, Motion, State};
use super::dimension::Dimension;
use super::error::{EffectError, Problem};
use super::interpret::lag;
use super::null::check_null;
use super::process::Process;
use super::scope::{Scope, Symbol, motion_formulas};
use super::toml_text::Source;
use super::unit::Unit;
use super::variable::{Hook, Variable};

/// Checks an effect with the base laws whose parameters it may use.
///
/// # Errors
/// The first fault, with its position in the file.
pub fn check(effect: &Effect, laws: &[Effect]) -> Result<(), EffectError> {
    check_names(effect, laws)?;
    check_formulas(effect, &|place| Scope::new(effect, place, laws))?;
    match effect.kind {
        Kind::Law => check_law(effect, laws),
        Kind::Effect if effect.parameters.iter().all(|parameter| parameter.null.is_none()) => {
            let problem = Problem::Missing("null".to_owned());
            Err(source(effect).error(0, "parameters", problem))
        }
        Kind::Effect => check_null(effect, laws),
    }
}

/// Checks an effect with the laws of a model.
///
/// # Errors
/// A parameter of a base law that the model's laws do not have.
pub fn check_in_model(effect: &Effect, laws: &[Effect], process: Process) -> Result<(), EffectError> {
    check_formulas(effect, &|place| Scope::new(effect, place, laws).within(process))
}

/// Checks names and dimensions at every hook that a process of the scope reaches.
fn check_formulas<'a>(effect: &'a Effect, scope: &dyn Fn(Hook) -> Scope<'a>) -> Result<(), EffectError> {
    for change in effect.changes.iter().filter(|change| scope(change.hook).is_reached()) {
        let of = format!("the value `{}`", change.value.name());
        scope(change.hook).expect(&change.formula, change.value.dimension(), &of)?;
        check_lags(&scope(change.hook), &change.formula)?;
    }
    for state in &effect.states {
        for (formula, dimension, of) in motion_formulas(state) {
            scope(state.per.place()).expect(formula, dimension, &of)?;
        }
    }
    Ok(())
}

/// Gives each state without a unit the SI unit implied by its evolution formula.
///
/// # Errors
/// A formula that needs the state itself, or whose dimension cannot be determined.
pub fn infer_units(effect: &mut Effect, laws: &[Effect]) -> Result<(), EffectError> {
    let open = |state: &State| state.unit_text.is_empty();
    while let Some(index) = effect.states.iter().position(open) {
        let state = &effect.states[index];
        let scope = Scope::new(effect, state.per.place(), laws);
        let (formula, second) = match &state.motion {
            Motion::Rate(rate) => (rate, Dimension::whole([0, 0, 1, 0])),
            Motion::Relax { target, .. } => (target, Dimension::NONE),
        };
        if let Some((_, span)) = formula.tree.names().into_iter().find(|(name, _)| *name == state.name) {
            return Err(scope.error(formula, &span, Problem::Missing(format!("state.{}.unit", state.name))));
        }
        let dimension = scope.dimension(formula)?.unwrap_or(Dimension::NONE) * second;
        effect.states[index].unit = Unit::si(dimension);
        effect.states[index].unit_text = dimension.to_string();
    }
    Ok(())
}

fn source(effect: &Effect) -> Source<'_> {
    Source { file: &effect.file, text: &effect.text }
}

/// Checks that no name has two meanings.
fn check_names(effect: &Effect, laws: &[Effect]) -> Result<(), EffectError> {
    let parameters = effect.parameters.iter().map(|parameter| &parameter.name);
    let definitions = effect.definitions.iter().map(|item| &item.name);
    let states = effect.states.iter().map(|state| &state.name);
    let names: Vec<&String> = parameters.chain(definitions).chain(states).collect();
    for (index, name) in names.iter().enumerate() {
        let variable = Variable::ALL.iter().any(|variable| variable.name() == **name);
        let mut other_laws = laws.iter().filter(|law| law.name != effect.name && effect.kind == Kind::Effect);
        let law = other_laws.find(|law| law.parameter(name).is_some());
        let owner = match law {
            _ if variable => Some("a variable of the simulation".to_owned()),
            Some(law) => Some(format!("a parameter of the law {}", law.name)),
            None => names[..index].contains(name).then(|| "another entry of this file".to_owned()),
        };
        if let Some(owner) = owner {
            let problem = Problem::Taken { name: (*name).clone(), owner };
            let byte = effect.text.find(&format!(".{name}]")).or_else(|| effect.text.find(&format!("\n{name} ")));
            return Err(source(effect).error(byte.map_or(0, |at| at + 1), name, problem));
        }
    }
    Ok(())
}

/// Checks that definitions and lags do not depend on each other in a circle.
///
/// # Errors
/// The first circle, with its names.
pub fn check_circles(effect: &Effect) -> Result<(), EffectError> {
    let definitions = effect.definitions.iter().map(|item| (item.name.as_str(), &item.formula));
    let lags = effect.states.iter().filter_map(|state| Some((state.name.as_str(), lag(effect, state)?.1)));
    let formulas: Vec<(&str, &Formula)> = definitions.chain(lags).collect();
    let mut done: Vec<&str> = Vec::new();
    for &(name, _) in &formulas {
        follow(effect, &formulas, &mut done, &mut vec![name])?;
    }
    Ok(())
}

fn follow<'a>(
    effect: &Effect,
    formulas: &[(&'a str, &'a Formula)],
    done: &mut Vec<&'a str>,
    trail: &mut Vec<&'a str>,
) -> Result<(), EffectError> {
    let name = trail[trail.len() - 1];
    let Some((_, formula)) = formulas.iter().find(|(known, _)| *known == name) else { return Ok(()) };
    if done.contains(&name) {
        return Ok(());
    }
    for (used, span) in formula.tree.names() {
        let circle = trail.iter().position(|before| *before == used);
        trail.push(used);
        if let Some(from) = circle {
            let scope = Scope::new(effect, Hook::ToolState, &[]);
            return Err(scope.error(formula, &span, Problem::Cycle(trail[from..].join(" -> "))));
        }
        follow(effect, formulas, done, trail)?;
        trail.pop();
    }
    done.push(name);
    Ok(())
}

/// Checks lags. At null a lag equals its target, so the target must be valid at every hook that reads the lag.
fn check_lags(scope: &Scope, formula: &Formula) -> Result<(), EffectError> {
    for (name, _) in formula.tree.names() {
        let Some(Symbol::State(index)) = scope.find(name) else { continue };
        let state = &scope.effect.states[index];
        if let Some((_, target)) = lag(scope.effect, state) {
            scope.expect(target, state.unit.dimension, &format!("the state `{name}`"))?;
        }
    }
    Ok(())
}

/// Checks that no formula of a law reads the value that it defines.
fn check_law(law: &Effect, laws: &[Effect]) -> Result<(), EffectError> {
    for change in &law.changes {
        let scope = Scope::new(law, change.hook, laws);
        for (name, span) in change.formula.tree.names() {
            if name == change.value.name() {
                let expected = "a formula without the value that the law gives".to_owned();
                let problem = Problem::Value { found: format!("`{name}`"), expected };
                return Err(scope.error(&change.formula, &span, problem));
            }
        }
    }
    Ok(())
}
