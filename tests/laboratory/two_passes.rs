//! Two equal passes: the second removes more, where the law predicts less, so no parameters can fit both.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

use effects::{Library, Model};
use experiments::next_row;
use lab::{Diagnosis, DiagnosisSummary, Evidence, RowEvidence, Verdict, calibrate};
use trials::table::Table;

fn table() -> Table {
    Table::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tables/two-passes")).unwrap()
}

#[test]
fn the_law_cannot_follow_and_a_memory_of_the_tool_is_suspected() {
    let table = table();
    let evidence = RowEvidence::new(&table).unwrap();
    let library = &evidence.library(Library::builtin()).unwrap();
    println!("{:?}", evidence.notes);
    let model = evidence.scaled(Model::new(evidence.process()), library).unwrap();
    let fit = calibrate(&evidence, &model, library).unwrap().last().fit.clone();
    let trend = evidence.trend(&fit.model).unwrap().expect("there are equal passes");
    println!("{}", trend.sentence());
    assert!(trend.out_of_reach && trend.pairs > 3, "{trend:?}");
    assert!((trend.measured - 0.12).abs() < 3.0 * trend.sigma, "{trend:?}");
    assert!((trend.reach[1] + 0.04).abs() < 1e-6, "with p_c = 0 the pressures' ratio is left: {trend:?}");
    let diagnosis = Diagnosis::new(&evidence, (&model, fit), library, (1, &|_, _, _| {})).unwrap();
    let summary = DiagnosisSummary::new(&evidence, &diagnosis, &|_| String::new()).unwrap();
    println!("{:?}: {}", diagnosis.verdict, summary.sentence);
    for finding in &diagnosis.rounds[0].findings {
        let (name, p) = (finding.suspect.name(), finding.probability);
        println!("{name}: p {p:.3}, gain {:.1}, chance {:.3}", finding.delta_chi2, finding.p_value);
    }
    assert_eq!(diagnosis.verdict, Verdict::Ambiguous, "as many parameters as conditions");
    let rivals = diagnosis.rivals().map(|rivals| rivals.map(|rival| rival.suspect.name()));
    for suspect in &summary.suspects {
        let is_in_play =
            suspect.name == summary.suspects[0].name || rivals.is_some_and(|r| r.contains(&&*suspect.name));
        println!("{}: {:?}", suspect.name, suspect.ruled_out);
        assert!(is_in_play || suspect.ruled_out.is_some(), "{} vanishes without a reason", suspect.name);
        assert!(suspect.ruled_out.as_ref().is_none_or(|reason| !reason.contains(" or ")), "one reason: {suspect:?}");
    }
    let screened: BTreeSet<&str> = diagnosis.rounds[0].screened.iter().map(|one| &*one.candidate.name).collect();
    let fitted = summary.suspects.iter().map(|one| &*one.name);
    let listed: BTreeSet<&str> = fitted
        .chain(summary.unfitted.iter().map(|one| &*one.name))
        .chain(summary.blind.keys().map(|name| &**name))
        .collect();
    assert!(listed.is_superset(&screened), "looked at and not listed: {:?}", screened.difference(&listed));
    assert!(!summary.unfitted.is_empty());
    for one in &summary.unfitted {
        println!("{}: {}", one.name, one.reason);
        assert!(one.reason.starts_with("no fall of χ²: ") || one.reason.starts_with("not fitted: "), "{one:?}");
        assert!(summary.suspects.iter().all(|suspect| suspect.name != one.name), "{} is listed twice", one.name);
    }
    assert!(summary.sentence.contains("no values of its parameters can follow"), "{}", summary.sentence);
    let [first, second, ..] = &diagnosis.rounds[0].findings[..] else { panic!("two rivals at least") };
    let rival = |k: usize| {
        let finding = &diagnosis.rounds[0].findings[k];
        (finding.suspect.name(), &finding.suspect.fit)
    };
    let next = next_row(&evidence, (rival(0), rival(1))).unwrap().expect("a third pass");
    println!("{next:?}");
    assert_eq!(next.separates, [first.suspect.name().to_owned(), second.suspect.name().to_owned()]);
    assert!(next.summary.contains("then") && next.spindle_rpm.len() == 3, "{next:?}");
}

#[test]
fn a_table_without_equal_passes_has_no_trend() {
    let mut table = table();
    table.rows.iter_mut().for_each(|row| row.fresh = true);
    let evidence = RowEvidence::new(&table).unwrap();
    let model = evidence.scaled(Model::new(evidence.process()), Library::builtin()).unwrap();
    let model = effects::CompiledModel::new(&model, Library::builtin(), evidence.rows()).unwrap();
    assert_eq!(evidence.trend(&model).unwrap(), None);
}

#[test]
fn the_verb_says_what_the_law_cannot_and_proposes_a_row() {
    let place = tempfile::tempdir().unwrap();
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tables/two-passes");
    let run = Command::new(env!("CARGO_BIN_EXE_robofin"))
        .args(["diagnose", table.to_str().unwrap(), "--out", "result", "--json"])
        .current_dir(place.path())
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let answer: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert!(answer["sentence"].as_str().unwrap().contains("no values of its parameters can follow"), "{answer}");
    // With two conditions and at least as many parameters, any named effect fits, and nothing tests it.
    assert_eq!(answer["verdict"], "ambiguous", "{answer}");
    let name = answer["effects"][0]["name"].as_str().unwrap();
    assert!(["break-in", "running-in"].contains(&name), "{name}");
    assert_eq!(answer["next_trial"]["separates"][0], name);
    assert!(answer["next_trial"]["force_n"].as_array().unwrap().len() > 2, "a row after the two: {answer}");
    assert!(answer["tests"].as_array().unwrap().iter().any(|test| test["rejects"] == true), "{answer}");
    assert!(!answer["covariates"].as_array().unwrap().is_empty());
}
