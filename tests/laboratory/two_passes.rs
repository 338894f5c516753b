//! Two equal passes of which the second removes more, where the law says less: no parameters can follow.

use std::path::Path;

use robofin::laboratory::{Diagnosis, DiagnosisSummary, Evidence, RowEvidence, Verdict, calibrate, next_row};
use robofin::table::Table;
use sim::effect::{Library, Model};

fn table() -> Table {
    Table::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tables/two-passes")).unwrap()
}

#[test]
fn the_law_cannot_follow_and_a_memory_of_the_tool_is_suspected() {
    let (table, library) = (table(), Library::builtin());
    let evidence = RowEvidence::new(&table).unwrap();
    println!("{:?}", evidence.notes);
    let model = evidence.scaled(Model::new(evidence.process()), library).unwrap();
    let fit = calibrate(&evidence, &model, library).unwrap();
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
        println!("{name}: p {p:.3}, gain {:.1}, chance {:.3}", finding.gain, finding.chance);
    }
    assert_ne!(diagnosis.verdict, Verdict::NothingMissing);
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
    let model = sim::effect::CompiledModel::new(&model, Library::builtin(), evidence.rows()).unwrap();
    assert_eq!(evidence.trend(&model).unwrap(), None);
}
