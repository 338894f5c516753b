//! Laws and effects formatted for reading and as JSON. Values are in the units of their files.

use crate::{Effect, Holder, Kind, Motion, Parameter, Process, Reset, Rows, Scale, State};
use serde::Serialize;

/// A law or effect for JSON.
#[derive(Debug, Serialize)]
pub struct EffectAnswer {
    name: String,
    title: String,
    kind: &'static str,
    processes: Vec<&'static str>,
    source: String,
    signature: String,
    confused_with: Vec<String>,
    formulas: Vec<FormulaAnswer>,
    definitions: Vec<FormulaAnswer>,
    parameters: Vec<ParameterAnswer>,
    states: Vec<StateAnswer>,
}

#[derive(Debug, Serialize)]
struct FormulaAnswer {
    /// The hook of the formula, if any.
    hook: Option<&'static str>,
    value: String,
    formula: String,
}

/// A parameter for JSON. Infinite numbers are texts, because JSON has no number for them.
#[derive(Debug, Serialize)]
struct ParameterAnswer {
    name: String,
    symbol: String,
    unit: String,
    null: Option<String>,
    scale: &'static str,
    per: &'static str,
    about: String,
    by_process: Vec<ProcessAnswer>,
}

#[derive(Debug, Serialize)]
struct ProcessAnswer {
    process: &'static str,
    default: String,
    range: [String; 2],
    free: bool,
}

#[derive(Debug, Serialize)]
struct StateAnswer {
    name: String,
    unit: String,
    per: &'static str,
    motion: String,
    initial: String,
    reset: &'static str,
}

impl EffectAnswer {
    /// Collects everything that the file states.
    pub fn new(effect: &Effect) -> Self {
        let formulas = effect.changes.iter().map(|change| FormulaAnswer {
            hook: Some(change.hook.name()),
            value: change.value.name().to_owned(),
            formula: change.formula.text.trim().to_owned(),
        });
        let definitions = effect.definitions.iter().map(|item| FormulaAnswer {
            hook: None,
            value: item.name.clone(),
            formula: item.formula.text.trim().to_owned(),
        });
        Self {
            name: effect.name.clone(),
            title: effect.title.clone(),
            kind: if effect.kind == Kind::Law { "law" } else { "effect" },
            processes: processes(effect).map(Process::name).collect(),
            source: effect.source.clone(),
            signature: effect.signature.clone(),
            confused_with: effect.confused_with.clone(),
            formulas: formulas.collect(),
            definitions: definitions.collect(),
            parameters: effect.parameters.iter().map(|parameter| parameter_answer(effect, parameter)).collect(),
            states: effect.states.iter().map(state_answer).collect(),
        }
    }
}

fn processes(effect: &Effect) -> impl Iterator<Item = Process> {
    Process::ALL.into_iter().filter(|process| effect.acts_in(*process))
}

fn parameter_answer(effect: &Effect, parameter: &Parameter) -> ParameterAnswer {
    let show = |value: f64| parameter.unit.show(value);
    let by_process = processes(effect).map(|process| ProcessAnswer {
        process: process.name(),
        default: show(parameter.default.of(process)),
        range: parameter.range.of(process).map(show),
        free: parameter.free.of(process),
    });
    ParameterAnswer {
        name: parameter.name.clone(),
        symbol: parameter.symbol.clone(),
        unit: parameter.unit_text.clone(),
        null: parameter.null.map(show),
        scale: if parameter.scale == Scale::Log { "log" } else { "linear" },
        per: match parameter.per {
            Rows::Model => "model",
            Rows::Pass => "pass",
            Rows::Scan => "scan",
        },
        about: parameter.about.clone(),
        by_process: by_process.collect(),
    }
}

fn state_answer(state: &State) -> StateAnswer {
    StateAnswer {
        name: state.name.clone(),
        unit: state.unit_text.clone(),
        per: match state.per {
            Holder::Tool => "tool",
            Holder::ToolCell => "tool cell",
            Holder::WorkpieceCell => "workpiece cell",
        },
        motion: motion(state),
        initial: state.unit.show(state.initial),
        reset: match state.reset {
            Reset::FreshTool => "fresh tool",
            Reset::Trial => "trial",
            Reset::Pass => "pass",
            Reset::Never => "never",
        },
    }
}

fn motion(state: &State) -> String {
    match &state.motion {
        Motion::Rate(rate) => format!("d {}/dt = {}", state.name, rate.text),
        Motion::Relax { target, time } => format!("nears {} within {}", target.text, time.text),
    }
}

/// Describes a law or effect as paragraphs, each with its topic.
pub fn describe(effect: &Effect) -> Vec<(&'static str, String)> {
    let answer = EffectAnswer::new(effect);
    let mut page = vec![(answer.kind, format!("{}: {}", answer.name, answer.title))];
    page.push(("acts when", answer.processes.join(", ")));
    let formulas = answer.formulas.iter().chain(&answer.definitions);
    let lines: Vec<String> =
        formulas.map(|formula| format!("{} = {}", formula.value, one_line(&formula.formula))).collect();
    page.push(("formulas", lines.join("\n")));
    let states: Vec<String> = answer.states.iter().map(state_line).collect();
    if !states.is_empty() {
        page.push(("states", states.join("\n")));
    }
    for parameter in &answer.parameters {
        page.push(("parameter", parameter_lines(parameter)));
    }
    if !answer.signature.is_empty() {
        page.push(("leaves", answer.signature));
    }
    if !answer.confused_with.is_empty() {
        page.push(("looks like", answer.confused_with.join(", ")));
    }
    page.push(("source", answer.source));
    page
}

fn one_line(formula: &str) -> String {
    formula.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn state_line(state: &StateAnswer) -> String {
    format!(
        "{} [{}] per {}: {}, {} at first, reset: {}",
        state.name, state.unit, state.per, state.motion, state.initial, state.reset
    )
}

fn parameter_lines(parameter: &ParameterAnswer) -> String {
    let per = if parameter.per == "model" { String::new() } else { format!(", one per {}", parameter.per) };
    let null = parameter.null.as_ref().map_or(String::new(), |null| format!(", vanishes at {null}"));
    let mut lines = vec![
        format!("{} ({}) [{}]{per}{null}", parameter.name, parameter.symbol, parameter.unit),
        parameter.about.clone(),
    ];
    let same = parameter.by_process.windows(2).all(|pair| {
        (&pair[0].default, &pair[0].range, pair[0].free) == (&pair[1].default, &pair[1].range, pair[1].free)
    });
    for values in parameter.by_process.iter().take(if same { 1 } else { 2 }) {
        let process = if same { String::new() } else { format!("{}: ", values.process) };
        let [low, high] = &values.range;
        let free = if values.free { "free in fits" } else { "fixed in fits" };
        lines.push(format!("{process}default {}, range {low} to {high} ({}), {free}", values.default, parameter.scale));
    }
    lines.join("\n")
}
