//! Number of trials until an effect is found: proposed trials compared with a fixed plan.
//!
//! A virtual laboratory hides an effect and makes one trial of two equal passes. Then it adds one trial after the
//! other: those that the diagnosis proposes, or repetitions of the first one. The table lists the result of the
//! diagnosis after each trial.
//!
//! `cargo run --release -p robofin-benchmark --example next_trial -- [FIRST_SEED] [SEEDS] [EFFECT:parameter=value]
//! [full]`

use effects::{Library, Model, Process};
use experiments::separating_trial;
use lab::{Diagnosis, Evidence, NextTrial, ScanEvidence, calibrate_scans};
use trials::trial::{Role, Trial};
use virtual_lab::{Choice, Experiment, Hidden, Plan, Size};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Default hidden effect: as in campaign open-b, whose bead is four times as long.
const HIDDEN: &str = "grit-dulling:dulling_volume=350 mm^3";
/// Most trials that are added.
const ADDED: usize = 3;
/// Probability from which the question is settled, as in a diagnosis.
const SETTLED: f64 = lab::criteria::NAMED_PROBABILITY;

/// Result of a diagnosis.
#[derive(Clone)]
struct Found {
    /// Probability of the hidden effect.
    probability: f64,
    /// The most probable effect with its probability.
    best: String,
    next: Option<NextTrial>,
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let numbers: Vec<u64> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let (first, seeds) = (numbers.first().copied().unwrap_or(1), numbers.get(1).copied().unwrap_or(3));
    let size = if words.iter().any(|word| word == "full") { Size::Full } else { Size::Small };
    let hidden = words.iter().find(|word| word.parse::<u64>().is_err() && *word != "full");
    let hidden = Hidden::parse(hidden.map_or(HIDDEN, String::as_str))?;
    println!(
        "| seed | plan | trials | p({}) | most probable | next | min |\n|---|---|---|---|---|---|---|",
        hidden.name
    );
    let mut needed = [Vec::new(), Vec::new()];
    for seed in first..first + seeds {
        let experiment = experiment((&hidden, size), seed)?;
        let begun = found(experiment.make()?.trials, &hidden.name, seed)?;
        for (proposed, needed) in [true, false].into_iter().zip(&mut needed) {
            needed.push(followed(experiment.clone(), (&hidden.name, begun.clone()), proposed)?);
        }
    }
    for (name, needed) in ["proposed", "fixed"].into_iter().zip(needed) {
        let shown: Vec<String> = needed
            .iter()
            .map(|needed| needed.map_or_else(|| format!("> {ADDED}"), |added| added.to_string()))
            .collect();
        println!("\n{name}: trials added until p({}) is {SETTLED}: {}", hidden.name, shown.join(", "));
    }
    Ok(())
}

/// One trial of two equal passes with a hidden effect.
fn experiment((hidden, size): (&Hidden, Size), seed: u64) -> Result<Experiment> {
    let new = Experiment::new(Process::Grinding, Library::builtin(), seed)?;
    let choice = Choice::These(vec![hidden.clone()]);
    Ok(Experiment { plan: Plan::Paper, trials: 1, size, choice, ..new })
}

/// Number of trials that must be added until the hidden effect is found; `None` if it exceeds [`ADDED`].
fn followed(mut experiment: Experiment, (hidden, begun): (&str, Found), proposed: bool) -> Result<Option<usize>> {
    let (seed, mut now, mut added) = (experiment.seed, begun, 0);
    loop {
        let what = now.next.as_ref().map_or("none", |next| &next.summary);
        let choice = now.next.as_ref().and_then(|next| next.choice.as_ref());
        let minutes = choice.map_or(f64::NAN, |choice| choice.worth.minutes);
        let plan = if proposed { "proposed" } else { "fixed" };
        println!("| {seed} | {plan} | {} | {:.3} | {} | {what} | {minutes:.1} |", 1 + added, now.probability, now.best);
        if now.probability >= SETTLED || added == ADDED {
            return Ok((now.probability >= SETTLED).then_some(added));
        }
        match choice.filter(|_| proposed) {
            Some(choice) => experiment.then.push(choice.plan.clone()),
            // If nothing is proposed, the fixed plan continues.
            None => experiment.trials += 1,
        }
        added += 1;
        now = found(experiment.make()?.trials, hidden, seed)?;
    }
}

/// Diagnoses trials with all passes as calibration data.
fn found(mut trials: Vec<Trial>, hidden: &str, seed: u64) -> Result<Found> {
    let passes = trials.iter_mut().flat_map(|trial| &mut trial.passes);
    passes.for_each(|pass| pass.role = Role::Calibration);
    let library = Library::builtin();
    let mut evidence = ScanEvidence::new(&trials, None)?;
    let model = Model::new(evidence.process());
    let calibration = calibrate_scans(&mut evidence, &model, library)?;
    let fit = calibration.last().fit.clone();
    let diagnosis = Diagnosis::within(&evidence, (&calibration.model, fit), library, (seed, &|_, _, _| {}), 1)?;
    let findings = &diagnosis.rounds[0].findings;
    let own = findings.iter().find(|finding| finding.suspect.name() == hidden);
    let best =
        findings.first().map_or(String::new(), |best| format!("{} {:.3}", best.suspect.name(), best.probability));
    let best = format!("{:?}, {best}, none {:.3}", diagnosis.verdict, diagnosis.rounds[0].none);
    let next = separating_trial(&evidence, &diagnosis)?;
    Ok(Found { probability: own.map_or(0.0, |own| own.probability), best, next })
}
