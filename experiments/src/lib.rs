//! The next experiment: the trial or the row of a table with the greatest expected information about the hypotheses
//! that a diagnosis leaves in play.
//!
//! 1. `menu` has some fifty variants of a trial that was made (`design`): other settings
//!    (`trial_simulation::PassPlan`), steps, pauses, dressing, direction, place, scans.
//! 2. `prediction` simulates each variant with every hypothesis in play (`hypothesis`), the hypothesis that none of the
//!    effects is the cause among them, and with each of their parameters moved.
//! 3. `score` computes the expected information of a variant; the one with the most per minute is proposed, and the
//!    next step after it.
//! 4. `next_row` does the same for the rows of a table, of which eight variants are enough.

mod design;
mod hypothesis;
mod menu;
mod next_row;
mod prediction;
mod score;
#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use lab::criteria::{NAMED_PROBABILITY, NEXT_TRIAL_RUNNERS_UP};
use lab::{Diagnosis, EvidenceError, MenuChoice, MenuLine, NextTrial, ScanEvidence, Worth};
use rayon::prelude::*;

use design::Design;
use prediction::{Outline, Predictor, TEMPLATE};
use score::{Belief, Predicted, Score};
use trial_simulation::without_scans;
use trials::trial::{Pass, RPM, Trial};

pub use hypothesis::{Hypothesis, live_hypotheses};
pub use next_row::{next_row, separating_row, testing_row};

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

/// The same trial as a test of its first effect, for which no rival is left.
fn as_test(mut trial: NextTrial) -> NextTrial {
    trial.separates.truncate(1);
    trial
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
    Ok(next_trial(evidence, &[with, without], round.spread)?.map(as_test))
}

/// The trial with the most information about the hypotheses of a diagnosis, where several are still in play.
///
/// # Errors
/// If the campaign cannot be simulated.
pub fn separating_trial(evidence: &ScanEvidence, diagnosis: &Diagnosis) -> Result<Option<NextTrial>, EvidenceError> {
    let Some((round, live)) = live_hypotheses(diagnosis) else { return Ok(None) };
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
    let designs = menu::menu(evidence.simulation.trials()[TEMPLATE].trial);
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
        self.design.worth(self.score.information)
    }

    fn line(&self) -> MenuLine {
        MenuLine { summary: self.design.what.clone(), worth: self.worth() }
    }

    /// Orders by information per minute, descending; ties keep the order of rating.
    fn better_first(&self, other: &Self) -> Ordering {
        other.worth().nats_per_minute.total_cmp(&self.worth().nats_per_minute)
    }
}

/// The trial with the most information per minute after the first one, whatever its result.
fn after(beliefs: &[Belief], all: &[Rated]) -> Option<MenuLine> {
    let first = &all[0];
    let beside = |next: &Rated| {
        let joint: Vec<Predicted> = first.predicted.iter().zip(&next.predicted).map(|(a, b)| a.and(b)).collect();
        let information = Score::new(beliefs, &joint).information - first.score.information;
        MenuLine { summary: next.design.what.clone(), worth: next.design.worth(information.max(0.0)) }
    };
    let lines: Vec<MenuLine> = all.par_iter().map(beside).collect();
    lines.into_iter().reduce(|a, b| if b.worth.nats_per_minute > a.worth.nats_per_minute { b } else { a })
}

/// The planned trials under new names, without scans.
fn plan(evidence: &ScanEvidence, design: &Design) -> Vec<Trial> {
    let trials = evidence.simulation.trials();
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
    let template = evidence.simulation.trials()[TEMPLATE].trial;
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
