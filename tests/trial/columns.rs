//! Additional columns of logs and values of trials, for formulas.

use std::path::Path;

use effects::{CompiledModel, Dimension, Library, Model, Process, RowCounts};
use trial_simulation::Simulation;
use trials::trial::{QuantitySource, Trial, TrialColumn, write_trial};

use crate::files::{edit, folder, noted, refused};

/// Adds a column to the log of the trial's pass.
fn with_column(folder: &Path, name: &str, value: impl Fn(usize) -> String) {
    edit(folder, "pass1_log.csv", |log| {
        let line = |(k, line): (usize, &str)| match k {
            0 => format!("{line},{name}\n"),
            _ => format!("{line},{}\n", value(k - 1)),
        };
        log.lines().enumerate().map(line).collect()
    });
}

/// Adds `[columns]` to the trial's file.
fn with_table(folder: &Path, table: &str) {
    edit(folder, "trial.toml", |text| format!("{text}\n[columns]\n{table}\n"));
}

fn read(folder: &Path) -> Trial {
    Trial::read(folder).expect("a trial")
}

#[test]
fn a_column_has_the_unit_of_its_name_or_of_the_table() {
    let place = folder();
    with_column(place.path(), "Humidity_pct", |k| format!("{}", 40 + k % 2));
    with_column(place.path(), "coolant flow", |_| "3".to_owned());
    let table = "\"coolant flow\" = \"mm^3/s\"\ndresser_hours = \"3.5 h\"\nroom = \"21 degC\"\nbatch = 7";
    with_table(place.path(), table);
    let trial = read(place.path());
    let column = |name: &str| trial.columns.iter().find(|column| column.name == name).expect("a column");
    let values = |name: &str| column(name).values(&trial.passes[0].log);
    let humidity = values("humidity").iter().map(|value| (value * 1e6).round()).collect::<Vec<_>>();
    assert_eq!(humidity[..3], [0.4e6, 0.41e6, 0.4e6]);
    assert_eq!((values("coolant_flow")[0] * 1e9).round(), 3.0);
    assert_eq!(column("coolant_flow").dimension, Dimension::whole([0, 3, -1, 0]));
    assert_eq!(values("dresser_hours"), [3.5 * 3600.0]);
    assert!((values("room")[0] - 294.15).abs() < 1e-9);
    assert_eq!(column("batch").given, QuantitySource::Trial(7.0));
    assert_eq!(values("current_a")[2], 1.0, "a name that ends with no unit is a plain number");
}

#[test]
fn what_is_written_has_its_columns_again() {
    let place = folder();
    with_column(place.path(), "humidity_pct", |_| "40".to_owned());
    with_column(place.path(), "mode_n", |_| "2".to_owned());
    with_table(place.path(), "mode_n = \"1\"\ndresser_hours = \"3.5 h\"\nroom = \"21 degC\"");
    let (trial, again) = (read(place.path()), tempfile::tempdir().unwrap());
    write_trial(&trial, again.path()).unwrap();
    let plain = |trial: &Trial| -> Vec<(String, String, Vec<f64>)> {
        let of = |column: &TrialColumn| (column.name.clone(), column.unit.clone(), column.values(&trial.passes[0].log));
        trial.columns.iter().filter(|column| column.name != "temperature").map(of).collect()
    };
    assert_eq!(plain(&trial), plain(&read(again.path())));
    assert!(trial.columns.iter().any(|column| column.name == "mode_n" && column.unit == "1"));
}

#[test]
fn entries_that_mean_nothing_are_refused_with_their_place() {
    let refused_with = |table: &str, words: &[&str]| {
        let place = folder();
        with_column(place.path(), "humidity", |_| "40".to_owned());
        with_table(place.path(), table);
        refused(place.path(), words);
    };
    refused_with("humidity = \"wet\"", &["trial.toml", "unit of a column", "such as"]);
    refused_with("humidity = \"45 %\"", &["trial.toml", "which is a column of the logs"]);
    refused_with("humidty = \"%\"", &["did you mean \"humidity\"", "no log has such a column"]);
    refused_with("batch = \"3 wet\"", &["the unit of a value"]);
    refused_with("batch = \"nan\"", &["not finite"]);
    refused_with("batch = \"wet\"", &["neither a value nor a unit"]);
    refused_with("batch = true", &["a unit, or a value with its unit"]);
}

#[test]
fn a_column_that_no_state_can_have_is_noted() {
    let place = folder();
    with_column(place.path(), "pressure", |_| "4".to_owned());
    noted(place.path(), &["pressure", "name of a variable"]);
}

/// Returns the message of simulating a trial with a model that reads `humidity` in percent.
fn simulated(folder: &Path) -> String {
    let text = "name = \"own\"\n[parameters.change]\nunit = \"1\"\nnull = 0.0\nrange = [-9.0, 9.0]\ndefault = 1.0\n\
        [state.humidity]\nper = \"tool\"\nunit = \"%\"\nrate = \"0\"\nreset = \"pass\"\n\
        [modify]\nrate = \"rate * (1 + change * humidity / 1 [%])\"\n";
    let library = Library::builtin().with(&[("own.toml".to_owned(), text.to_owned())]).expect("an effect");
    let model = Model::new(Process::Grinding).with("own");
    let model = CompiledModel::new(&model, &library, RowCounts::default()).expect("a model");
    let trial = read(folder);
    let simulation = Simulation::new(&trial, 0.5e-3, false).expect("a simulation");
    let error = simulation.run_models(&[model]).remove(0).stopped.expect("it is refused");
    error.to_string()
}

#[test]
fn what_a_model_reads_and_the_files_lack_is_named_with_its_place() {
    let says = |change: &dyn Fn(&Path), words: &[&str]| {
        let place = folder();
        change(place.path());
        let said = simulated(place.path());
        words.iter().for_each(|word| assert!(said.contains(word), "{word:?} is missing in: {said}"));
    };
    says(&|_| (), &["trial.toml", "no column humidity", "own.humidity", "current_a", "[columns]"]);
    let bad = |k: usize| if k == 5 { "nan".to_owned() } else { "40".to_owned() };
    let read = "a number in every row";
    says(&|place| with_column(place, "humidity_pct", bad), &["pass1_log.csv, line 7", "humidity", read]);
    let empty = |k: usize| if k == 0 { String::new() } else { "40".to_owned() };
    says(&|place| with_column(place, "humidity_pct", empty), &["pass1_log.csv, line 2"]);
    let newton = |place: &Path| with_column(place, "humidity_n", |_| "40".to_owned());
    says(&newton, &["pass1_log.csv", "is in N", "such as %"]);
    says(&|place| with_table(place, "humidity = \"4 K\""), &["trial.toml, line", "is in K", "such as %"]);
}
