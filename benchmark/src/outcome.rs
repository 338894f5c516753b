//! Run of one case: made, written, read again, studied and judged.

use std::path::Path;
use std::time::Instant;

use effects::{EffectError, Library, Model};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

use super::answer::{CaseAnswer, Judgement, NamedEffect};
use super::baseline::regression;
use super::cases::{Case, Design};
use super::coverage::Interval;
use super::error_gap::Errors;
use super::forecast::Forecast;
use super::ladder::hidden;
use lab::{BASE_STEP, LabError, ParameterSummary, Verdict};
use study::{Measurements, StudyRecord, StudyState, inputs_sha256};
use virtual_lab::write::{WriteError, write};
use virtual_lab::{Choice, Experiment, HiddenEffect, Made, MakeError, Size};

/// Reason for which a case could not be studied.
#[derive(Debug, Error)]
pub enum BenchError {
    /// Its experiment is not valid.
    #[error(transparent)]
    Experiment(#[from] EffectError),
    /// It could not be made.
    #[error(transparent)]
    Made(#[from] MakeError),
    /// Its trials could not be written.
    #[error(transparent)]
    Written(#[from] WriteError),
}

/// Outcome of a case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    /// The case.
    pub case: Case,
    /// The hidden effects, with their values.
    pub truth: Vec<HiddenEffect>,
    /// Error with which the study refused the measurements or failed; absent if it ran to its end.
    pub refused: Option<String>,
    /// Verdict, named effects and hint of the study.
    pub said: CaseAnswer,
    /// Judgement of this answer, given the hidden effects.
    pub judgement: Judgement,
    /// Probabilities of its first search.
    pub forecast: Forecast,
    /// Answer of residual regression, a baseline, on the same measurements.
    pub regression: CaseAnswer,
    /// Parameters of the final model with their true values.
    pub intervals: Vec<Interval>,
    /// Errors of the held-out passes [m].
    pub errors: Errors,
    /// True if a next trial was proposed.
    pub next_trial: bool,
    /// The most probable effects of the first search, for display.
    pub suspects: Vec<String>,
    /// Duration of the study [s].
    pub seconds: f64,
}

/// Makes a case, runs a study with default settings to its end, and records the outcome. A refusal by the study is an
/// outcome too.
///
/// - `scratch`: path of a folder for the trials, which the study reads like any others; the caller removes it
///
/// # Errors
/// If the case cannot be made.
pub fn run(case: &Case, size: Size, library: &Library, scratch: &Path) -> Result<Outcome, BenchError> {
    let Design { process, plan, front, seed } = case.design;
    let new = Experiment::new(process, library, seed)?;
    let hide = |name: &String| hidden(name, (process, size), case.rung, &new.library);
    let choice = Choice::These(case.hidden.iter().map(hide).collect());
    let experiment = Experiment { plan, trials: plan.usual_trials(), size, choice, ..new }.behind(front);
    let made = experiment.make()?;
    write(&made, &experiment, scratch, None, true)?;
    let known = match case.is_left_out() {
        true => library.without(&case.hidden.iter().map(String::as_str).collect::<Vec<_>>()),
        false => library.clone(),
    };
    let started = Instant::now();
    let studied = StudyResults::new(scratch, known, seed);
    let seconds = started.elapsed().as_secs_f64();
    let (studied, refused) = match studied {
        Ok(studied) => (studied, None),
        Err(error) => (StudyResults::default(), Some(in_full(&error))),
    };
    Ok(studied.outcome((case, &made), refused, seconds))
}

/// Formats an error with its causes.
fn in_full(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(error.source(), |cause| cause.source()).map(|cause| format!(": {cause}"));
    causes.fold(error.to_string(), |text, cause| if text.contains(&cause[2..]) { text } else { text + &cause })
}

/// Results of a study, before they are judged.
#[derive(Default)]
struct StudyResults {
    said: CaseAnswer,
    first: Option<Value>,
    regression: CaseAnswer,
    parameters: Vec<ParameterSummary>,
    errors: Errors,
    next_trial: bool,
}

impl StudyResults {
    /// Studies a folder of trials to the end.
    fn new(folder: &Path, library: Library, seed: u64) -> Result<Self, LabError> {
        let measurements = Measurements::read(folder)?;
        let data = measurements.data()?;
        let library = data.library(library)?;
        let model = Model::new(data.evidence().process());
        let record = StudyRecord::new(inputs_sha256(folder)?, seed);
        let mut state = StudyState::new(data, &library, model, record)?;
        let mut studied = Self::default();
        let mut searches = 0;
        while state.step(&|_, _, _| {})?.is_some() {
            let done = state.record.done.iter().filter(|done| done.action == study::Action::Diagnose).count();
            if done > searches {
                searches = done;
                studied.note_search(&state);
            }
        }
        studied.said.verdict = state.record.verdict;
        // A wrong frame or clock is not an effect of a search.
        let is_named = |name: &&String| studied.said.named.iter().any(|named| named.name == **name);
        let beside: Vec<String> = state.record.added.iter().filter(|name| !is_named(name)).cloned().collect();
        studied.said.named.extend(beside.into_iter().map(|name| NamedEffect { name, alike: Vec::new() }));
        studied.parameters = state.parameters();
        let step = |name: Option<&str>| {
            let mut steps = state.record.waterfall.iter().rev();
            steps.find(|step| name.is_none_or(|name| step.step == name)).and_then(|step| step.evaluation_rms)
        };
        let floor = state.record.evaluation_noise_floor;
        studied.errors = Errors { base: step(Some(BASE_STEP)), found: step(None), floor };
        Ok(studied)
    }

    /// Records the result of a search.
    fn note_search(&mut self, state: &StudyState) {
        let Some(summary) = &state.record.diagnosis else { return };
        let named = |effect: &Value| {
            let alike = effect["indistinguishable_from"].as_array().into_iter().flatten();
            let alike = alike.filter_map(|name| name.as_str().map(str::to_owned)).collect();
            Some(NamedEffect { name: effect["name"].as_str()?.to_owned(), alike })
        };
        let effects = summary["effects"].as_array().map_or(&[][..], Vec::as_slice);
        // A study adds the first effect of each search; an uncertain one is named and not added.
        let is_added = state.record.to_add.is_some();
        if is_added || state.record.verdict == Some(Verdict::Ambiguous) {
            self.said.named.extend(effects.iter().take(1).filter_map(named));
        }
        self.next_trial |= !summary["next_trial"].is_null();
        let Some(diagnosis) = state.diagnosis() else { return };
        self.said.hint = diagnosis.hint().map(|(hint, _)| hint.suspect.name().to_owned());
        if self.first.is_none() {
            let of = |key: &str| summary[key].as_f64().unwrap_or(0.0);
            let errors = [of("base_rms"), of("noise_floor")];
            self.regression = regression(state.evidence(), diagnosis, errors);
            self.first = Some(summary.clone());
        }
    }

    fn outcome(self, (case, made): (&Case, &Made), refused: Option<String>, seconds: f64) -> Outcome {
        let first = self.first.unwrap_or_default();
        let suspects = first["suspects"].as_array().map_or(&[][..], Vec::as_slice);
        Outcome {
            case: case.clone(),
            truth: made.answer.effects.clone(),
            refused,
            judgement: self.said.judged(case),
            said: self.said,
            forecast: Forecast::of(&first),
            regression: self.regression,
            intervals: Interval::all(&self.parameters, &made.answer),
            errors: self.errors,
            next_trial: self.next_trial,
            suspects: suspects.iter().map(shown).collect(),
            seconds,
        }
    }
}

/// Formats a suspect in one line.
fn shown(suspect: &Value) -> String {
    let scaled = |key: &str, digits: usize, scale: f64| {
        suspect[key].as_f64().map_or("-".to_owned(), |x| format!("{:.digits$}", scale * x))
    };
    let number = |key: &str, digits: usize| scaled(key, digits, 1.0);
    let held_out = ["evaluation_rms_before", "evaluation_rms_after"].map(|key| scaled(key, 2, 1e6));
    format!(
        "{}: probability {}, Δχ² {}, p-value {}; held out {} -> {} µm",
        suspect["name"].as_str().unwrap_or_default(),
        number("probability", 3),
        number("delta_chi2", 1),
        number("p_value", 3),
        held_out[0],
        held_out[1]
    )
}
