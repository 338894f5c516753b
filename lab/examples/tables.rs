//! Diagnoses tables, and counts how often an effect is named where none is hidden.
//!
//! `cargo run --release -p robofin-lab --example tables -- [--null N] FOLDER ...` prints the verdict of each table.
//! With `--null N` it also makes N null tables of each, in which the base law is true: the fitted prediction plus
//! residuals of the table, permuted in one half of the draws and drawn with replacement in the other. It counts the
//! verdicts.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use effects::{Library, Model};
use lab::{Diagnosis, DiagnosisSummary, Evidence, Fit, RowEvidence, Split, Verdict, calibrate};
use random::Stream;
use trials::table::Table;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Diagnoses a table as the program does.
fn diagnosed(table: &Table) -> Outcome<(DiagnosisSummary, Vec<String>)> {
    let evidence = RowEvidence::new(table)?;
    let library = evidence.library(Library::builtin())?;
    let model = evidence.scaled(Model::new(evidence.process()), &library)?;
    let fit = calibrate(&evidence, &model, &library)?.last().fit.clone();
    let diagnosis = Diagnosis::new(&evidence, (&model, fit), &library, (1, &|_, _, _| {}))?;
    let summary = DiagnosisSummary::new(&evidence, &diagnosis, &|_| String::new())?;
    Ok((summary, evidence.notes))
}

/// Fits the base law to a table. Returns the prediction and the log residual of each row, less its group's mean.
fn base(table: &Table) -> Outcome<(Vec<f64>, Vec<f64>)> {
    let evidence = RowEvidence::new(table)?;
    let model = evidence.scaled(Model::new(evidence.process()), Library::builtin())?;
    let fit: Fit = calibrate(&evidence, &model, Library::builtin())?.last().fit.clone();
    let predicted = evidence.predicted(&fit.model)?;
    let left = |at: usize| table.rows[at].removal_rate.map_or(f64::NAN, |rate| (rate / predicted[at]).ln());
    let mut left: Vec<f64> = (0..table.rows.len()).map(left).collect();
    let mut gains = vec![0.0; table.groups.len()];
    for (group, gain) in gains.iter_mut().enumerate() {
        let own: Vec<f64> = (0..left.len()).filter(|&at| table.rows[at].group == group).map(|at| left[at]).collect();
        let own: Vec<f64> = own.into_iter().filter(|left| left.is_finite()).collect();
        *gain = own.iter().sum::<f64>() / own.len().max(1) as f64;
    }
    left.iter_mut().zip(&table.rows).for_each(|(left, row)| *left -= gains[row.group]);
    let predicted = predicted.iter().zip(&table.rows).map(|(rate, row)| rate * gains[row.group].exp()).collect();
    Ok((predicted, left))
}

/// Returns the table with removals drawn under the base law.
fn null(table: &Table, (predicted, left): &(Vec<f64>, Vec<f64>), draw: usize) -> Table {
    let mut stream = Stream::of(draw as u64, "null table");
    let known: Vec<usize> = (0..left.len()).filter(|&at| left[at].is_finite()).collect();
    let mut from = known.clone();
    if draw.is_multiple_of(2) {
        (1..from.len()).rev().for_each(|k| from.swap(k, stream.below(k + 1)));
    } else {
        from.iter_mut().for_each(|at| *at = known[stream.below(known.len())]);
    }
    let mut table = table.clone();
    for (&at, &from) in known.iter().zip(&from) {
        table.rows[at].removal_rate = Some(predicted[at] * left[from].exp());
    }
    table
}

fn describe(table: &Table, summary: &DiagnosisSummary, notes: &[String]) {
    println!("== {}: {:?}. {}", table.name, summary.verdict, summary.sentence);
    let unit = summary.error_unit;
    table.notes.iter().chain(notes).for_each(|note| println!("   note: {note}"));
    println!(
        "   base {}, final {}, floor {}",
        unit.shown(summary.base_rms),
        unit.shown(summary.final_rms),
        unit.shown(summary.noise_floor)
    );
    for step in &summary.waterfall {
        println!("   {}", step.shown(unit));
    }
    for suspect in &summary.suspects {
        println!("   {}: {}", suspect.search, suspect.shown());
        suspect.parameters.values().for_each(|parameter| println!("        {}", parameter.shown()));
        suspect.ruled_out.iter().for_each(|reason| println!("        out: {reason}"));
    }
    summary.unfitted.iter().for_each(|one| println!("   unfitted {}: {}", one.name, one.reason));
}

fn main() -> Outcome<()> {
    let mut folders: Vec<String> = std::env::args().skip(1).collect();
    let mut draws = 0;
    if let Some(at) = folders.iter().position(|word| word == "--null") {
        draws = folders.get(at + 1).ok_or("--null: a number is expected")?.parse()?;
        folders.drain(at..at + 2);
    }
    for folder in &folders {
        let table = Table::read(Path::new(folder))?;
        let (summary, notes) = diagnosed(&table)?;
        describe(&table, &summary, &notes);
        let law = base(&table)?;
        let mut verdicts: BTreeMap<String, usize> = BTreeMap::new();
        for draw in 0..draws {
            let (summary, _) = diagnosed(&null(&table, &law, draw))?;
            let names: Vec<&str> = summary.effects.iter().map(|effect| effect.name.as_str()).collect();
            *verdicts.entry(format!("{:?} {}", summary.verdict, names.join(" + "))).or_default() += 1;
            let is_named = !names.is_empty() && summary.verdict != Verdict::NothingMissing;
            if is_named || summary.verdict == Verdict::Unknown || std::env::var("ALL").is_ok() {
                let first = summary.suspects.first().map_or(String::new(), |suspect| suspect.shown());
                let base = summary.waterfall[0].shown(summary.error_unit);
                let floor = summary.error_unit.shown(summary.noise_floor);
                println!("   draw {draw}: {:?}, {base}, floor {floor}; {first}", summary.verdict);
            }
        }
        verdicts.iter().for_each(|(verdict, count)| println!("   null: {verdict}: {count} of {draws}"));
        let evaluates = RowEvidence::new(&table)?.of(Split::Evaluation).len();
        println!("   {evaluates} rows evaluate");
    }
    Ok(())
}
