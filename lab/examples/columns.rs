//! Frequency with which a diagnosis names a column of a table, and with which it names a permutation of that column.
//!
//! `cargo run --release -p robofin-lab --example columns -- N FOLDER ...` declares each numeric column of each table as
//! a state in turn, including columns that the table does not declare, and prints the verdict. Then it permutes the
//! column N times, with seeds from 0, and counts how often a form of it is named.

use std::error::Error;
use std::path::Path;

use effects::{Dimension, Library, Model};
use lab::{Diagnosis, DiagnosisSummary, Evidence, RowEvidence, calibrate};
use random::Stream;
use trials::table::{Table, Usage};

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Diagnoses a table as the program does.
fn diagnosed(table: &Table) -> Outcome<DiagnosisSummary> {
    let evidence = RowEvidence::new(table)?;
    let library = evidence.library(Library::builtin())?;
    let model = evidence.scaled(Model::new(evidence.process()), &library)?;
    let fit = calibrate(&evidence, &model, &library)?.last().fit.clone();
    let diagnosis = Diagnosis::new(&evidence, (&model, fit), &library, (1, &|_, _, _| {}))?;
    Ok(DiagnosisSummary::new(&evidence, &diagnosis, &|_| String::new())?)
}

/// Returns the table with one more column declared as a state; `None` if a row has no number.
fn declared(table: &Table, covariate: usize) -> Option<Table> {
    let covariate = &table.covariates[covariate];
    let mut table = table.clone();
    for (row, value) in table.rows.iter_mut().zip(&covariate.values) {
        row.usage.push(Some(*value).filter(|value| value.is_finite())?);
    }
    let (key, name) = ("usage".to_owned(), covariate.name.clone());
    table.usage.push(Usage { key, name, dimension: Dimension::NONE, unit: "1".to_owned(), scale: (1.0, 0.0) });
    Some(table)
}

/// Returns the table with the values of a state permuted.
fn permuted(table: &Table, usage: usize, seed: u64) -> Table {
    let mut stream = Stream::of(seed, "permuted column");
    let mut table = table.clone();
    for at in (1..table.rows.len()).rev() {
        let other = stream.below(at + 1);
        let value = table.rows[at].usage[usage];
        table.rows[at].usage[usage] = table.rows[other].usage[usage];
        table.rows[other].usage[usage] = value;
    }
    table
}

/// Names of the column effects that a diagnosis names.
fn named(summary: &DiagnosisSummary) -> Vec<String> {
    let effects = summary.effects.iter().map(|effect| effect.name.clone());
    effects.filter(|name| name.contains("column-")).collect()
}

fn main() -> Outcome<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (count, folders) = words.split_first().ok_or("the number of permutations and folders are expected")?;
    let count: u64 = count.parse()?;
    for folder in folders {
        let table = Table::read(Path::new(folder))?;
        let own = (0..table.usage.len()).map(|usage| (table.clone(), usage));
        let others = (0..table.covariates.len()).filter_map(|k| Some((declared(&table, k)?, table.usage.len())));
        for (table, usage) in own.chain(others) {
            let summary = diagnosed(&table)?;
            println!("{}, column {}: {:?}. {}", table.name, table.usage[usage].name, summary.verdict, summary.sentence);
            let mut false_names = Vec::new();
            for seed in 0..count {
                false_names.extend(named(&diagnosed(&permuted(&table, usage, seed))?));
            }
            println!("   permuted: {} of {count} named {false_names:?}", false_names.len());
        }
    }
    Ok(())
}
