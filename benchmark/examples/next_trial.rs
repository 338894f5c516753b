//! Whether proposed trials find an effect in fewer trials than a fixed plan does.
//!
//! A virtual laboratory hides an effect and makes one trial of two equal passes. Then it makes one trial after the other: those
//! that the diagnosis proposes, or the same one again and again. After each the table says what the diagnosis finds.
//! `cargo run --release -p robofin-benchmark --example next_trial -- [FIRST_SEED] [SEEDS] [EFFECT] [full]`

use effects::{Library, Model, Process};
use lab::{Diagnosis, Evidence, NextTrial, ScanEvidence, calibrate_scans, separating_trial};
use trials::trial::{Role, Trial};
use virtual_lab::{Choice, Experiment, Hidden, Plan, Size};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Trials that are added at most.
const ADDED: usize = 3;
/// Probability from which the question is settled, as a diagnosis has it.
const SETTLED: f64 = lab::criteria::NAMED_PROBABILITY;

/// What a diagnosis finds.
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
    let hidden = hidden.map_or("grit-dulling", String::as_str);
    println!("| seed | plan | trials | p({hidden}) | most probable | next | min |\n|---|---|---|---|---|---|---|");
    let mut needed = [Vec::new(), Vec::new()];
    for seed in first..first + seeds {
        for (proposed, needed) in [true, false].into_iter().zip(&mut needed) {
            needed.push(followed((hidden, size), seed, proposed)?);
        }
    }
    for (name, needed) in ["proposed", "fixed"].into_iter().zip(needed) {
        let shown: Vec<String> = needed
            .iter()
            .map(|needed| needed.map_or_else(|| format!("> {ADDED}"), |added| added.to_string()))
            .collect();
        println!("\n{name}: trials added until p({hidden}) is {SETTLED}: {}", shown.join(", "));
    }
    Ok(())
}

/// Trials that must be added until the hidden effect is found; `None` where more than [`ADDED`] are.
fn followed((hidden, size): (&str, Size), seed: u64, proposed: bool) -> Result<Option<usize>> {
    let new = Experiment::new(Process::Grinding, Library::builtin(), seed)?;
    let choice = Choice::These(vec![Hidden::effect(hidden)]);
    let mut experiment = Experiment { plan: Plan::Paper, trials: 1, size, choice, ..new };
    for added in 0..=ADDED {
        let found = found(experiment.make()?.trials, hidden, seed)?;
        let what = found.next.as_ref().map_or("none", |next| &next.summary);
        let choice = found.next.as_ref().and_then(|next| next.choice.as_ref());
        let minutes = choice.map_or(f64::NAN, |choice| choice.worth.minutes);
        let plan = if proposed { "proposed" } else { "fixed" };
        let (p, best) = (found.probability, found.best);
        println!("| {seed} | {plan} | {} | {p:.3} | {best} | {what} | {minutes:.1} |", 1 + added);
        if p >= SETTLED {
            return Ok(Some(added));
        }
        match choice.filter(|_| proposed) {
            Some(choice) => experiment.then.push(choice.plan.clone()),
            // Where nothing is proposed, the fixed plan goes on.
            None => experiment.trials += 1,
        }
    }
    Ok(None)
}

/// Diagnoses trials, all of whose passes may be fitted.
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
