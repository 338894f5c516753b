//! Coverage of the 95 % intervals of the base parameters, and whiteness of the residuals of calibrated models, on fresh
//! virtual experiments with nothing hidden.
//!
//! `cargo run --release -p robofin-benchmark --example coverage -- COUNT [FIRST_SEED] [small|full] [clean|hard] [grinding|sanding]`

use std::collections::BTreeMap;

use effects::{Library, Model, Process};
use lab::{Estimate, Evidence, ResidualGrid, ScanEvidence, Split, calibrate_scans, structure_tests};
use virtual_lab::{Choice, Experiment, Instrument, Made, Plan, Robot, Size};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Half width of a 95 % interval of a normal law [standard deviations].
const SIGMAS: f64 = 1.96;

/// Counts over all campaigns.
#[derive(Default)]
struct Counts {
    /// Intervals that contain the true value, and all, by parameter.
    held: BTreeMap<String, (usize, usize)>,
    /// Campaigns in which no test rejects after calibration, and all.
    white: (usize, usize),
}

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: u64| words.get(at).map_or(Ok(default), |word| word.parse());
    let (count, first) = (number(0, 10)?, number(1, 1)?);
    let size = if words.iter().any(|word| word == "full") { Size::Full } else { Size::Small };
    let hard = words.iter().any(|word| word == "hard");
    let process = if words.iter().any(|word| word == "sanding") { Process::Sanding } else { Process::Grinding };
    let mut counts = Counts::default();
    println!(
        "| seed | plan | χ²/ν | tests that reject | parameters: truth, value, 95 % interval |\n|---|---|---|---|---|"
    );
    for seed in first..first + count {
        let plan = [Plan::Varied, Plan::Steps, Plan::Reversed, Plan::Paper][(seed % 4) as usize];
        match made((seed, plan, size), (process, hard)) {
            Ok(made) => one(&made, plan, &mut counts)?,
            Err(why) => println!("| {seed} | {plan:?} | not made: {why} | | |"),
        }
    }
    println!();
    for (name, (held, all)) in &counts.held {
        println!("{name}: {held} of {all} intervals hold the truth ({:.0} %)", 100.0 * *held as f64 / *all as f64);
    }
    println!("{} of {} calibrated models leave what no test rejects", counts.white.0, counts.white.1);
    Ok(())
}

fn made((seed, plan, size): (u64, Plan, Size), (process, hard): (Process, bool)) -> Result<Made> {
    let (instrument, robot) =
        if hard { (Instrument::hard(), Robot::hard()) } else { (Instrument::clean(), Robot::clean()) };
    let new = Experiment::new(process, Library::builtin(), seed)?;
    let choice = Choice::These(Vec::new());
    Ok(Experiment { plan, trials: plan.usual_trials(), size, choice, instrument, robot, ..new }.make()?)
}

/// Calibrates one campaign and prints its row.
fn one(made: &Made, plan: Plan, counts: &mut Counts) -> Result<()> {
    let mut evidence = ScanEvidence::new(&made.trials, None)?;
    let model = Model::new(evidence.process());
    let calibration = calibrate_scans(&mut evidence, &model, Library::builtin())?;
    let fit = &calibration.last().fit;
    let views: Vec<_> = evidence.of(Split::Calibration).collect();
    let grids: Vec<ResidualGrid> = (evidence.ranges(Split::Calibration).into_iter().zip(&views))
        .map(|(range, view)| {
            let tiles = view.data.tiles();
            let residuals = fit.residuals[range].to_vec();
            ResidualGrid { nx: tiles.grid.shape().0, cells: tiles.cells.clone(), residuals }
        })
        .collect();
    let repeats = evidence.repeats(Split::Calibration);
    let tests = structure_tests(&grids, &repeats, fit.at.len(), &[], made.answer.seed);
    let rejects: Vec<&str> = tests.iter().filter(|test| test.rejects).map(|test| test.name.as_str()).collect();
    counts.white.0 += usize::from(rejects.is_empty());
    counts.white.1 += 1;
    let estimates = calibration.last().estimates();
    let shown: Vec<String> = estimates.iter().filter_map(|estimate| held(estimate, made, counts)).collect();
    let ratio = fit.chi2 / (fit.residuals.len() - fit.at.len()) as f64;
    println!("| {} | {plan:?} | {ratio:.2} | {} | {} |", made.answer.seed, rejects.join(", "), shown.join("; "));
    Ok(())
}

/// Checks and counts whether an interval contains the true value; returns a description.
fn held(estimate: &Estimate, made: &Made, counts: &mut Counts) -> Option<String> {
    let (coordinate, slot) = (&estimate.coordinate, &estimate.coordinate.slot);
    let truth: f64 = made.answer.base.get(&slot.name())?.values.first()?.parse().ok()?;
    let at = coordinate.from_value(estimate.value);
    let [low, high] = [-SIGMAS, SIGMAS].map(|sigmas| slot.unit.from_si(coordinate.value(at + sigmas * estimate.sigma)));
    let is_held = (low..=high).contains(&truth);
    let count = counts.held.entry(slot.name()).or_default();
    *count = (count.0 + usize::from(is_held), count.1 + 1);
    let (value, mark) = (slot.unit.from_si(estimate.value), if is_held { "" } else { " **missed**" });
    Some(format!("{} {truth:.4}, {value:.4} [{low:.4}, {high:.4}]{mark}", slot.parameter))
}
