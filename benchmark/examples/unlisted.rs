//! Proposals for unlisted effects on fresh virtual experiments: the effects outside the library, effects of the library
//! that are removed from it, and campaigns with nothing hidden.
//!
//! `cargo run --release -p robofin-benchmark --example unlisted -- [FIRST_SEED] [small|full] [WORD ...]`
//!
//! With words, only cases whose name contains one of them.

use std::time::Instant;

use effects::{Library, Model, Process};
use lab::{ErrorUnit, Evidence, Proposal, ScanEvidence, Split, calibrate_scans, propose};
use virtual_lab::{Choice, Experiment, Hidden, Made, Plan, Size};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Hidden effect, process, and variables that would be a right answer; no variables if nothing is hidden.
const CASES: &[(&str, Process, &[&str])] = &[
    ("", Process::Grinding, &[]),
    ("", Process::Sanding, &[]),
    ("axis-wander", Process::Grinding, &["path-position", "path-remaining", "contact-time", "place-along-x"]),
    ("grit-loss", Process::Grinding, &["worked-volume", "sliding-distance"]),
    ("grit-loss", Process::Sanding, &["worked-volume", "sliding-distance"]),
    ("lateral-wander", Process::Sanding, &["path-position", "path-remaining", "contact-time", "place-along-x"]),
    ("paint-run", Process::Sanding, &["place-along-y"]),
    ("plate-warping", Process::Grinding, &["place-along-x"]),
    ("spatter-patch", Process::Grinding, &["place-along-x", "place-along-y"]),
    ("spatter-patch", Process::Sanding, &["place-along-x", "place-along-y"]),
    ("stick-slip", Process::Grinding, &["path-position", "path-remaining"]),
    ("stick-slip", Process::Sanding, &["path-position", "path-remaining"]),
    ("thermal-stiffness", Process::Grinding, &["warmth", "slow-warmth", "contact-time", "path-position"]),
    ("grit-dulling", Process::Grinding, &["worked-volume", "sliding-distance"]),
    ("pad-loading", Process::Sanding, &["worked-volume", "sliding-distance"]),
    ("break-in", Process::Grinding, &["sliding-distance", "worked-volume"]),
    ("surface-layer", Process::Grinding, &["removed-depth"]),
    ("pressure-exponent", Process::Grinding, &["pressure"]),
    ("speed-exponent", Process::Grinding, &["slip-speed", "sliding-speed"]),
    ("edge-pressure", Process::Sanding, &["edge-distance"]),
    ("thermal-softening", Process::Grinding, &["warmth", "slow-warmth", "contact-time"]),
    ("coating-thickness", Process::Sanding, &["place-along-x", "place-along-y"]),
    ("material-grindability", Process::Grinding, &["weld-metal"]),
    ("force-drift", Process::Grinding, &["path-position", "contact-time", "trial-time", "path-remaining"]),
    ("cutting-direction", Process::Grinding, &["feed-direction"]),
];

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let first: u64 = words.first().and_then(|word| word.parse().ok()).unwrap_or(1);
    let size = if words.iter().any(|word| word == "full") { Size::Full } else { Size::Small };
    let wanted: Vec<&String> = words
        .iter()
        .filter(|word| word.parse::<u64>().is_err() && !["small", "full"].contains(&word.as_str()))
        .collect();
    println!("| hidden | held out before | after | floor | variable | proposed | s |\n|---|---|---|---|---|---|---|");
    let (mut right, mut closed, mut all) = (0, 0, 0);
    for (number, &(hidden, process, variables)) in CASES.iter().enumerate() {
        if !wanted.is_empty() && !wanted.iter().any(|word| hidden.contains(word.as_str())) {
            continue;
        }
        let made = match made((hidden, process), first + number as u64, size) {
            Ok(made) => made,
            Err(why) => {
                println!("| {hidden} ({}) | not made: {why} | | | | | |", process.name());
                continue;
            }
        };
        let started = Instant::now();
        let (proposal, before, floor) = proposed(&made, hidden)?;
        let after = proposal.as_ref().and_then(|proposal| proposal.errors.last()?.evaluation_rms).unwrap_or(before);
        let name = proposal.as_ref().map_or("none", |proposal| &proposal.forms[0].name);
        let is_right = variables.iter().any(|variable| name.ends_with(&format!("-of-{variable}")));
        if !hidden.is_empty() {
            all += 1;
            right += usize::from(is_right);
            closed += usize::from(after <= 1.5 * floor);
        }
        let [before, after, floor] = [before, after, floor].map(|error| ErrorUnit::Metre.shown(error));
        println!(
            "| {hidden} ({}) | {before} | {after} | {floor} | {} | {name}: {} | {:.0} |",
            process.name(),
            judgement(hidden, is_right),
            summary(proposal.as_ref()),
            started.elapsed().as_secs_f64()
        );
    }
    println!("\n{all} effects hidden: the variable right in {right}, at most 1.5 floors left in {closed}");
    Ok(())
}

/// Judgement of the first form's variable, in a word.
fn judgement(hidden: &str, is_right: bool) -> &'static str {
    match (hidden, is_right) {
        ("", _) => "-",
        (_, true) => "right",
        (_, false) => "wrong",
    }
}

/// All forms of a proposal in words.
fn summary(proposal: Option<&Proposal>) -> String {
    let forms = proposal.iter().flat_map(|proposal| &proposal.forms);
    forms.map(|form| form.summary.as_str()).collect::<Vec<_>>().join("; and ")
}

fn made((hidden, process): (&str, Process), seed: u64, size: Size) -> Result<Made> {
    let hidden = if hidden.is_empty() { Vec::new() } else { vec![Hidden::effect(hidden)] };
    let plan = Plan::Varied;
    let new = Experiment::new(process, Library::builtin(), seed)?;
    Ok(Experiment { plan, trials: plan.usual_trials(), size, choice: Choice::These(hidden), ..new }.make()?)
}

/// The proposal, and the held-out error of the base law with its noise floor [m].
fn proposed(made: &Made, hidden: &str) -> Result<(Option<Proposal>, f64, f64)> {
    let library = Library::builtin().without(&[hidden]);
    let mut evidence = ScanEvidence::new(&made.trials, None)?;
    let model = Model::new(evidence.process());
    let calibration = calibrate_scans(&mut evidence, &model, &library)?;
    let fit = &calibration.last().fit;
    let held_out = evidence.agreement(&fit.model, Split::Evaluation)?;
    let mean = |of: &dyn Fn(&lab::Agreement) -> f64| {
        (held_out.iter().map(|a| of(a).powi(2)).sum::<f64>() / held_out.len().max(1) as f64).sqrt()
    };
    let (before, floor) = (mean(&|a| a.rms), mean(&|a| a.floor));
    let proposal = propose(&evidence, (&calibration.model, fit), &library, made.answer.seed)?;
    Ok((proposal, before, floor))
}
