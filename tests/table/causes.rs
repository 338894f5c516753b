//! Verdicts on tables: an influential column is named, noise is not, and nothing is named if nothing is hidden.

use effects::{Library, Model};
use lab::{Diagnosis, DiagnosisSummary, Evidence, RowEvidence, Verdict, calibrate};
use study::{Asked, compare_rows};
use trials::table::Table;

use crate::hidden::table;
use crate::synthetic::{Hidden, MANIFEST, NOISE, Work, csv, folder, work};

/// Runs a diagnosis as the program does.
pub(crate) fn diagnosed(table: &Table) -> DiagnosisSummary {
    let evidence = RowEvidence::new(table).unwrap();
    let library = evidence.library(Library::builtin()).unwrap();
    let model = evidence.scaled(Model::new(evidence.process()), &library).unwrap();
    let fit = calibrate(&evidence, &model, &library).unwrap().last().fit.clone();
    let diagnosis = Diagnosis::new(&evidence, (&model, fit), &library, (1, &|_, _, _| {})).unwrap();
    let summary = DiagnosisSummary::new(&evidence, &diagnosis, &|_| String::new()).unwrap();
    println!("{:?}: {}", summary.verdict, summary.sentence);
    println!("{:?}", evidence.notes);
    summary.suspects.iter().for_each(|suspect| println!("{}", suspect.shown()));
    summary
}

/// Makes rows whose rate falls by a share for each unit of wear [mm³].
fn falling(per_unit: f64, seed: u64) -> Vec<Work> {
    let mut rows = work(Hidden::Nothing, NOISE, seed);
    rows.iter_mut().for_each(|row| row.depth *= (-per_unit * row.wear * 1e9).exp());
    rows
}

fn declared(key: &str, unit: &str) -> String {
    format!("{MANIFEST}{key} = {{ column = \"wear\", unit = \"{unit}\" }}\n")
}

#[test]
fn a_declared_column_that_matters_is_named_with_its_size() {
    for (key, unit) in [("usage", "h"), ("usage", "min"), ("humidity", "%"), ("grit", "um")] {
        let summary = diagnosed(&table(&declared(key, unit), &csv(&falling(1e-3, 3))));
        let names: Vec<&str> = summary.suspects.iter().map(|suspect| suspect.name.as_str()).collect();
        assert!([Verdict::Identified, Verdict::Ambiguous].contains(&summary.verdict), "{key} in {unit}");
        let own = summary.suspects.iter().find(|suspect| suspect.name == "column-wear");
        let change = own.unwrap_or_else(|| panic!("{key} in {unit}: {names:?}")).parameters["change"].clone();
        let [low, high] = change.interval.expect("it is found");
        assert!(low < -1e-3 && -1e-3 < high && high < -5e-4, "{key} in {unit}: {change:?}");
        assert_eq!(summary.effects[0].name, "column-wear", "{key} in {unit}");
        let said = &summary.sentence;
        assert!(said.contains("\"wear\"") && said.contains(&format!(" % per {unit} of")), "{said}");
    }
}

#[test]
fn a_column_that_the_library_reads_has_no_effect_of_its_own() {
    for (key, unit, effect) in [("usage", "mm^3", "grit-dulling"), ("temperature", "degC", "thermal-softening")] {
        let summary = diagnosed(&table(&declared(key, unit), &csv(&falling(1e-3, 3))));
        assert_eq!(summary.effects[0].name, effect);
        assert!(summary.suspects.iter().all(|suspect| suspect.name != "column-wear"));
    }
}

#[test]
fn a_dependence_on_a_column_is_not_noise_and_a_comparison_names_it() {
    for (rows, agrees) in [(work(Hidden::Nothing, NOISE, 5), true), (falling(1e-3, 5), false)] {
        let folder = folder(&declared("usage", "h"), &csv(&rows));
        let table = Table::read(folder.path()).unwrap();
        let evidence = RowEvidence::new(&table).unwrap();
        println!("{:?}", evidence.notes);
        assert!((0.6..1.5).contains(&(evidence.noise / NOISE)), "{}", evidence.noise);
        let model = evidence.scaled(Model::new(evidence.process()), Library::builtin()).unwrap();
        let fit = calibrate(&evidence, &model, Library::builtin()).unwrap().last().fit.clone();
        let asked = Asked { folder: folder.path(), lines: &[], seed: 1 };
        let (comparison, _) = compare_rows(&evidence, &fit.model, &asked).unwrap();
        println!("{}", comparison.sentence);
        assert_eq!(comparison.agrees, agrees, "{}", comparison.sentence);
        let test = comparison.failures.tests.iter().find(|test| test.name.contains("declared column"));
        assert_eq!(test.expect("columns are tested").rejects, !agrees);
        if !agrees {
            assert!(comparison.sentence.contains("the wear"), "{}", comparison.sentence);
        }
    }
}

#[test]
fn outliers_in_six_of_a_hundred_rows_leave_the_noise_and_the_verdict() {
    for seed in 0..4 {
        let mut rows = work(Hidden::Nothing, NOISE, 50 + seed);
        rows.iter_mut().skip(seed as usize).step_by(17).for_each(|row| row.depth *= 8.0);
        let table = table(MANIFEST, &csv(&rows));
        let noise = RowEvidence::new(&table).unwrap().noise;
        assert!((0.6..1.5).contains(&(noise / NOISE)), "{noise}");
        let verdict = diagnosed(&table).verdict;
        assert!([Verdict::NothingMissing, Verdict::NotTestable].contains(&verdict), "{verdict:?}");
    }
}

#[test]
fn a_rate_without_durations_shows_a_measured_dulling() {
    let text = csv(&work(Hidden::Usage, NOISE, 9));
    let rate = |line: (usize, &str)| {
        let mut cells: Vec<String> = line.1.split(',').map(str::to_owned).collect();
        if line.0 > 0 {
            let (t, depth): (f64, f64) = (cells[2].parse().unwrap(), cells[4].parse().unwrap());
            cells[4] = format!("{}", depth / t);
        }
        cells.join(",") + "\n"
    };
    let text: String = text.lines().enumerate().map(rate).collect();
    let manifest = declared("usage", "mm^3")
        .replace("duration = { column = \"t\", unit = \"s\" }\n", "")
        .replace("unit = \"um\"", "unit = \"um/s\"");
    let table = table(&manifest, &text);
    let evidence = RowEvidence::new(&table).unwrap();
    assert_eq!(evidence.acts(Library::builtin().find("grit-dulling").unwrap()), Ok(()));
    assert!(diagnosed(&table).effects.iter().any(|effect| effect.name == "grit-dulling"));
}
