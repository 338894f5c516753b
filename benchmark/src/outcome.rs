//! One case: made, diagnosed, judged.

use std::time::Instant;

use effects::{Effect, EffectError, Library, Model, Scale};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::cases::{Case, Design, Instruments, Sized, effect_process};
use lab::{
    Detectable, Diagnosis, DiagnosisSummary, EffectSummary, Evidence, EvidenceError, LabError, ScanEvidence, Sides,
    Verdict, calibrate_scans, separating_trial,
};
use virtual_lab::{Choice, Experiment, Hidden, HiddenEffect, Instrument, MakeError, Robot, Size};

/// The reason why a case gave no answer.
#[derive(Debug, Error)]
pub enum BenchError {
    /// Its experiment is none.
    #[error(transparent)]
    Experiment(#[from] EffectError),
    /// It could not be made.
    #[error(transparent)]
    Made(#[from] MakeError),
    /// It could not be diagnosed.
    #[error(transparent)]
    Diagnosed(#[from] LabError),
}

impl From<EvidenceError> for BenchError {
    fn from(error: EvidenceError) -> Self {
        Self::Diagnosed(error.into())
    }
}

/// What came out of a case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Outcome {
    /// The case.
    pub case: Case,
    /// What was hidden, with its values.
    pub truth: Vec<HiddenEffect>,
    /// Whether the campaign could show an effect of this size; `None` where that was not asked.
    pub testable: Option<bool>,
    /// The verdict.
    pub verdict: Verdict,
    /// Effects that were named.
    pub named: Vec<String>,
    /// Probability of the first.
    pub probability: Option<f64>,
    /// What the data cannot tell from each of them.
    pub alike: Vec<Vec<String>>,
    /// Errors of base and final model on the evaluation passes, and the noise floor [µm].
    pub evaluation_um: [Option<f64>; 2],
    /// The noise floor [µm].
    pub floor_um: f64,
    /// The most probable effects of each search, with what they leave held out, for people.
    pub suspects: Vec<String>,
    /// Whether a next trial was proposed.
    pub next_trial: bool,
    /// Least size of each effect that this campaign could show.
    pub detectable: Vec<Detectable>,
    /// Time that the diagnosis took [s].
    pub seconds: f64,
}

/// Makes a case, diagnoses it with the default settings and notes what came out.
///
/// - `detectable`: what the same design without an effect could show, for sizes that are multiples of it
///
/// # Errors
/// When it cannot be made or diagnosed.
pub fn run(case: &Case, detectable: &[Detectable], size: Size, library: &Library) -> Result<Outcome, BenchError> {
    let hide = |name: &String| hidden(case, name, detectable, library);
    let hidden: Vec<(Hidden, Option<bool>)> = case.hidden.iter().map(hide).collect();
    let testable = hidden.iter().map(|(_, testable)| *testable).reduce(|a, b| Some(a? && b?)).flatten();
    let hidden: Vec<Hidden> = hidden.into_iter().map(|(hidden, _)| hidden).collect();
    let Diagnosed { summary, truth, next_trial, seconds } = diagnosed(case, hidden, size, library)?;
    let evaluation = |step: Option<&lab::WaterfallStep>| step.and_then(|step| step.evaluation_rms_um);
    Ok(Outcome {
        case: case.clone(),
        truth,
        testable,
        verdict: summary.verdict,
        named: summary.effects.iter().map(|effect| effect.name.clone()).collect(),
        probability: summary.effects.first().map(|effect| effect.probability),
        alike: summary.effects.iter().map(|effect| effect.indistinguishable_from.clone()).collect(),
        evaluation_um: [evaluation(summary.waterfall.first()), evaluation(summary.waterfall.last())],
        floor_um: summary.noise_floor_um,
        suspects: summary.suspects.iter().map(suspect).collect(),
        next_trial,
        detectable: summary.detectable,
        seconds,
    })
}

fn suspect(suspect: &EffectSummary) -> String {
    let held_out =
        [suspect.evaluation_rms_um_before, suspect.evaluation_rms_um_after].map(|rms| rms.unwrap_or(f64::NAN));
    format!("{}; held out {:.2} -> {:.2} µm", suspect.shown(), held_out[0], held_out[1])
}

/// What a diagnosis of a synthetic campaign gives.
struct Diagnosed {
    summary: DiagnosisSummary,
    truth: Vec<HiddenEffect>,
    next_trial: bool,
    seconds: f64,
}

fn diagnosed(case: &Case, hidden: Vec<Hidden>, size: Size, library: &Library) -> Result<Diagnosed, BenchError> {
    let Design { process, plan, instruments, seed } = case.design;
    let (instrument, robot) = match instruments {
        Instruments::Clean => (Instrument::clean(), Robot::clean()),
        Instruments::Hard => (Instrument::hard(), Robot::hard()),
    };
    let new = Experiment::new(process, library, seed)?;
    let trials = plan.usual_trials();
    let made = Experiment { plan, trials, size, choice: Choice::These(hidden), instrument, robot, ..new }.make()?;
    let known = match case.left_out {
        true => library.without(&case.hidden.iter().map(String::as_str).collect::<Vec<_>>()),
        false => library.clone(),
    };
    let started = Instant::now();
    let mut evidence = ScanEvidence::new(&made.trials, None)?;
    let model = Model::new(evidence.process());
    let fit = calibrate_scans(&mut evidence, &model, &known)?.last().fit.clone();
    let diagnosis = Diagnosis::new(&evidence, (&model, fit), &known, (seed, &|_, _, _| {}))?;
    let summary = DiagnosisSummary::new(&evidence, &diagnosis, &|name| name.to_owned())?;
    evidence.fix_observation(&diagnosis.fit.model)?;
    let next_trial = diagnosis.verdict == Verdict::Ambiguous && separating_trial(&evidence, &diagnosis)?.is_some();
    Ok(Diagnosed { summary, truth: made.answer.effects, next_trial, seconds: started.elapsed().as_secs_f64() })
}

/// A hidden effect with its size, and whether the campaign could show it.
fn hidden(case: &Case, name: &str, detectable: &[Detectable], library: &Library) -> (Hidden, Option<bool>) {
    let Sized::Detectable(multiple) = case.size else { return (Hidden::effect(name), None) };
    let known = detectable.iter().find(|least| least.effect == name);
    let effect = library.find(name).filter(|effect| effect.acts_in(effect_process(case.design.process)));
    let (Some(least), Some(effect)) = (known, effect) else { return (Hidden::effect(name), Some(false)) };
    let Some(size) = least.size.filter(|_| least.testable) else { return (Hidden::effect(name), Some(false)) };
    let (value, within) = sized(effect, least, multiple * size, size / multiple, case);
    (Hidden::effect(name).with(&least.parameter, &format!("{value} {}", unit_of(least))), Some(within))
}

/// A value that departs from the null by so much, or lies so low where the null is infinite, and whether it had to be kept
/// within the parameter's range for that [the parameter's unit].
fn sized(effect: &Effect, least: &Detectable, departs: f64, low: f64, case: &Case) -> (f64, bool) {
    let process = effect_process(case.design.process);
    let parameter = effect.parameters.iter().find(|parameter| parameter.name == least.parameter);
    let Some(parameter) = parameter else { return (departs, false) };
    let [from, to] = parameter.range.of(process).map(|end| parameter.unit.from_si(end));
    let null = parameter.null.map_or(0.0, |null| parameter.unit.from_si(null));
    let wanted = match parameter.scale {
        _ if null.is_infinite() => low,
        Scale::Log => null + departs,
        Scale::Linear if null + departs <= to && least.sides != Sides::Below => null + departs,
        Scale::Linear => null - departs,
    };
    let value = wanted.clamp(from, to);
    (value, (value - wanted).abs() <= 1e-9 * wanted.abs())
}

fn unit_of(least: &Detectable) -> &str {
    if least.unit == "1" { "" } else { &least.unit }
}
