//! The trial with the greatest expected information per minute about the hypotheses in play.
//!
//! 1. `menu` has some fifty variants of a trial that was made (`design`): other settings
//!    (`trial_simulation::PassPlan`), steps, pauses, dressing, direction, place, scans.
//! 2. `prediction` simulates each variant with every hypothesis in play (`hypothesis`), the hypothesis that none of the
//!    effects is the cause among them, and with each of their parameters moved.
//! 3. `score` computes the expected information of a variant; the one with the most per minute is proposed, and the
//!    next step after it.

mod design;
mod hypothesis;
mod menu;
mod prediction;
mod score;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use rayon::prelude::*;
use serde::Serialize;

use super::diagnose::Diagnosis;
use super::evidence::EvidenceError;
use super::scans::ScanEvidence;
use crate::criteria::{NAMED_PROBABILITY, NEXT_TRIAL_RUNNERS_UP};
use design::Design;
use prediction::{Outline, Predictor, TEMPLATE};
use score::{Belief, Predicted, Score};
use trial_simulation::without_scans;
use trials::trial::{Pass, RPM, Trial};

pub use hypothesis::Hypothesis;
pub(super) use score::left_after_refit;

/// A proposed trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextTrial {
    /// Description of the trial.
    pub summary: String,
    /// Force of each pass [N].
    pub force_n: Vec<f64>,
    /// Feed of each pass [mm/s].
    pub feed_mm_s: Vec<f64>,
    /// Spindle speed of each pass [rpm].
    pub spindle_rpm: Vec<f64>,
    /// Hypotheses that it would distinguish, most probable first; or the one effect whose prediction it would test.
    pub separates: Vec<String>,
    /// Expected difference of χ² between the first two; for one effect, between the models with and without it.
    pub expected_delta_chi2: f64,
    /// Lower bound of the expected probability that the most probable hypothesis is right afterwards.
    pub probability_right: f64,
    /// Cost, expected information and alternatives from the menu; absent for tables.
    #[serde(flatten)]
    pub choice: Option<MenuChoice>,
}

/// A trial chosen from a menu.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MenuChoice {
    /// Cost and information of the trial.
    #[serde(flatten)]
    pub worth: Worth,
    /// Box and Hill's discrimination [nat].
    pub discrimination_nats: f64,
    /// Entropy of the present probabilities: the most information that any trial can give [nat].
    pub entropy_nats: f64,
    /// Number of trials on the menu that could be simulated.
    pub menu: usize,
    /// The next best trials of the menu.
    pub runners_up: Vec<MenuLine>,
    /// The trial that would follow it; absent where it is expected to settle the question.
    pub then: Option<MenuLine>,
    /// Number of scans of each surface that are averaged.
    pub scans_per_surface: usize,
    /// The trial without its scans; two trials if the tool is dressed in between.
    #[serde(skip)]
    pub plan: Vec<Trial>,
}

/// Cost and information of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Worth {
    /// Expected time [min].
    pub minutes: f64,
    /// Number of new workpieces.
    pub workpieces: usize,
    /// Lower bound of the expected fall of the entropy of the probabilities [nat].
    pub expected_information_nats: f64,
    /// The same per minute.
    pub nats_per_minute: f64,
}

/// One trial of the menu.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MenuLine {
    /// Difference from the trial that was made.
    pub summary: String,
    /// Cost and information.
    #[serde(flatten)]
    pub worth: Worth,
}

/// A trial of the menu with an upper bound of its information.
struct Outlined<'a> {
    design: Design,
    outline: Outline<'a>,
    bound: Score,
}

/// A trial of the menu with its expected information.
struct Rated {
    design: Design,
    predicted: Vec<Predicted>,
    score: Score,
}

impl NextTrial {
    /// The same trial as a test of its first effect, for which no rival is left.
    pub(super) fn into_test(mut self) -> Self {
        self.separates.truncate(1);
        self
    }
}

/// The trial on which the effect that was found last changes the prediction most, as a test of the effect; `None` where
/// nothing was found.
///
/// # Errors
/// If the campaign cannot be simulated.
pub fn testing_trial(evidence: &ScanEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>, EvidenceError> {
    let Some((round, found)) = diagnosis.last_found() else { return Ok(None) };
    let with = Hypothesis { name: found.suspect.name(), probability: 0.5, fit: &found.suspect.fit };
    let without = Hypothesis { name: "without it", probability: 0.5, fit: &round.base };
    Ok(next_trial(evidence, &[with, without], round.spread)?.map(NextTrial::into_test))
}

/// The trial with the most information about the hypotheses of a diagnosis, where several are still in play.
///
/// # Errors
/// If the campaign cannot be simulated.
pub fn separating_trial(evidence: &ScanEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>, EvidenceError> {
    let Some((round, live)) = diagnosis.live_hypotheses() else { return Ok(None) };
    next_trial(evidence, &live, round.spread)
}

/// The variant of the first trial with the greatest expected information per minute about hypotheses; `None` if no
/// variant can be simulated.
///
/// - `spread`: standard deviation of whitened residuals that is attributed to noise
///
/// # Errors
/// If the last trial of the campaign cannot be simulated with a hypothesis.
pub fn next_trial(
    evidence: &ScanEvidence,
    hypotheses: &[Hypothesis],
    spread: f64,
) -> Result<Option<NextTrial>, EvidenceError> {
    let sum: f64 = hypotheses.iter().map(|hypothesis| hypothesis.probability).sum();
    let beliefs: Vec<Belief> = hypotheses.iter().map(|hypothesis| hypothesis.belief(sum, spread)).collect();
    let predictor = Predictor::new(evidence, hypotheses, spread)?;
    let designs = menu::menu(evidence.simulation.trials[TEMPLATE].trial);
    let outlined = |design: Design| {
        let outline = predictor.outline(&design).ok()?;
        Some(Outlined { bound: Score::bound(&beliefs, &outline.data), design, outline })
    };
    let menu: Vec<Outlined> = designs.into_par_iter().filter_map(outlined).collect();
    let count = menu.len();
    let all = rated(&predictor, &beliefs, menu);
    let Some(best) = all.first() else { return Ok(None) };
    let mut trial = stated(evidence, hypotheses, best);
    let runners_up = all.iter().skip(1).take(NEXT_TRIAL_RUNNERS_UP).map(Rated::line).collect();
    trial.choice = Some(MenuChoice {
        worth: best.worth(),
        discrimination_nats: best.score.discrimination,
        entropy_nats: beliefs.iter().map(|belief| -belief.probability * belief.probability.ln()).sum(),
        menu: count,
        runners_up,
        then: if best.score.probability_right < NAMED_PROBABILITY { after(&beliefs, &all) } else { None },
        scans_per_surface: best.design.scans,
        plan: plan(evidence, &best.design),
    });
    Ok(Some(trial))
}

/// The best trials of a menu, the best first. Derivatives cost most of the time, so they are computed only for trials
/// with the highest upper bounds, until no other bound exceeds the information of the last reported trial.
fn rated(predictor: &Predictor, beliefs: &[Belief], mut menu: Vec<Outlined>) -> Vec<Rated> {
    menu.sort_by(|a, b| b.most().total_cmp(&a.most()));
    let mut all: Vec<Rated> = Vec::new();
    for batch in menu.chunks(1 + NEXT_TRIAL_RUNNERS_UP) {
        let last = all.get(NEXT_TRIAL_RUNNERS_UP).map(|last| last.worth().nats_per_minute);
        if last.is_some_and(|last| last >= batch[0].most()) {
            break;
        }
        let rated = |Outlined { design, outline, .. }: &Outlined| {
            let predicted = predictor.predicted(design, outline).ok()?;
            Some(Rated { score: Score::new(beliefs, &predicted), design: design.clone(), predicted })
        };
        all.par_extend(batch.par_iter().filter_map(rated));
        all.sort_by(Rated::better_first);
    }
    all
}

impl Outlined<'_> {
    /// Upper bound of its information per minute.
    fn most(&self) -> f64 {
        self.bound.information / self.design.minutes()
    }
}

impl Rated {
    fn worth(&self) -> Worth {
        Worth::new(&self.design, self.score.information)
    }

    fn line(&self) -> MenuLine {
        MenuLine { summary: self.design.what.clone(), worth: self.worth() }
    }

    /// Orders by information per minute, descending; ties keep the order of rating.
    fn better_first(&self, other: &Self) -> Ordering {
        other.worth().nats_per_minute.total_cmp(&self.worth().nats_per_minute)
    }
}

impl Worth {
    fn new(design: &Design, information: f64) -> Self {
        let minutes = design.minutes();
        Self {
            minutes,
            workpieces: design.workpieces(),
            expected_information_nats: information,
            nats_per_minute: information / minutes,
        }
    }
}

/// The trial with the most information per minute after the first one, whatever its result.
fn after(beliefs: &[Belief], all: &[Rated]) -> Option<MenuLine> {
    let first = &all[0];
    let beside = |next: &Rated| {
        let joint: Vec<Predicted> = first.predicted.iter().zip(&next.predicted).map(|(a, b)| a.and(b)).collect();
        let information = Score::new(beliefs, &joint).information - first.score.information;
        MenuLine { summary: next.design.what.clone(), worth: Worth::new(&next.design, information.max(0.0)) }
    };
    let lines: Vec<MenuLine> = all.par_iter().map(beside).collect();
    lines.into_iter().reduce(|a, b| if b.worth.nats_per_minute > a.worth.nats_per_minute { b } else { a })
}

/// The planned trials under new names, without scans.
fn plan(evidence: &ScanEvidence, design: &Design) -> Vec<Trial> {
    let trials = &evidence.simulation.trials;
    let mut name = trials[trials.len() - 1].trial.name.clone();
    let named = |stage: &Trial| {
        name = successor(&name);
        let controller = trials[TEMPLATE].trial.controller;
        without_scans(Trial { name: name.clone(), controller, ..stage.clone() })
    };
    design.stages.iter().map(named).collect()
}

/// The name with its last number incremented.
fn successor(name: &str) -> String {
    let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = &name[stem.len()..];
    match digits.parse::<u64>() {
        Ok(number) => format!("{stem}{:0width$}", number + 1, width = digits.len()),
        Err(_) => format!("{name}-2"),
    }
}

fn stated(evidence: &ScanEvidence, hypotheses: &[Hypothesis], best: &Rated) -> NextTrial {
    let template = evidence.simulation.trials[TEMPLATE].trial;
    let each = |value: fn(&Pass) -> f64| best.design.passes().map(value).collect();
    NextTrial {
        summary: format!("Repeat {}: {}.", template.name, best.design.what),
        force_n: each(|pass| pass.force_setpoint),
        feed_mm_s: each(|pass| pass.feed * 1e3),
        spindle_rpm: each(|pass| pass.spindle_speed / RPM),
        separates: hypotheses.iter().map(|hypothesis| hypothesis.name.to_owned()).collect(),
        expected_delta_chi2: best.score.differences[(0, 1)],
        probability_right: best.score.probability_right,
        choice: None,
    }
}
