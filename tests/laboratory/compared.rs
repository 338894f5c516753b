//! Comparison of an unfitted model: it finds the misfit of a wrong model, and none of the true one.

use std::path::{Path, PathBuf};

use effects::{CompiledModel, Library, Model};
use lab::{Evidence, RowEvidence, ScanEvidence};
use report::study::page;
use study::{Asked, Comparison, compare_rows, compare_scans};
use study::{Direction, Maps, StudyReport};
use trials::table::Table;
use trials::trial::{Campaign, Role};

fn bundled(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name)
}

fn compared(model: &Model) -> (Comparison, StudyReport) {
    let folder = bundled("campaigns/first-look");
    let campaign = Campaign::read(&folder).unwrap();
    let evidence = ScanEvidence::new(&campaign.trials, None).unwrap();
    let model = CompiledModel::new(model, Library::builtin(), evidence.rows()).unwrap();
    let lines = [Direction::Across(12e-3), Direction::Along(0.0)];
    compare_scans((&campaign, &evidence), &model, &Asked { folder: &folder, lines: &lines, seed: 1 }).unwrap()
}

#[test]
fn a_model_that_was_never_fitted_differs_and_is_said_where() {
    let model = Model::new(effects::Process::Grinding);
    let (comparison, report) = compared(&model);
    println!("{}", serde_json::to_string_pretty(&comparison).unwrap());
    assert!(!comparison.agrees && comparison.rms > 3.0 * comparison.noise_floor);
    assert_eq!(comparison.judged, "calibration");
    for (name, p) in comparison.failures.tests.iter().map(|test| (&test.name, test.p_value)) {
        assert!((0.0..=1.0).contains(&p), "{name}: {p}");
    }
    assert!(comparison.failures.tests.iter().filter(|test| test.rejects).count() >= 2);
    assert_eq!(comparison.scans.len(), 6);
    for scan in &comparison.scans {
        let [measured, sigma, simulated] = scan.volume_mm3.expect("a ground surface");
        assert!(measured > 10.0 * sigma && sigma > 0.0 && simulated > 0.0, "{scan:?}");
        assert_eq!(scan.sections.len(), 2);
        assert_eq!(scan.sections[0].place, "x = 12 mm");
    }
    assert!(comparison.failures.covariates.windows(2).all(|pair| pair[0].share >= pair[1].share));
    assert!(comparison.failures.covariates.iter().any(|covariate| covariate.name == "mean pressure"));
    assert!(comparison.failures.joint_share > 0.3, "{}", comparison.failures.joint_share);
    let names: Vec<&str> = report.waterfall.steps.iter().map(|step| step.name.as_str()).collect();
    assert_eq!(names, ["raw", "registered", "model", "noise floor"]);
    let rms: Vec<f64> = report.waterfall.steps.iter().filter_map(|step| step.calibration).collect();
    assert!(rms.len() == 4 && rms[..3].iter().all(|step| *step > 3.0 * rms[3]), "{rms:?}");
    assert!(report.waterfall.steps.iter().all(|step| step.volume_errors.iter().all(Option::is_some)));
    assert_eq!(report.compared.passes.iter().filter(|pass| pass.role == Role::Evaluation).count(), 2);
    assert!(report.compared.passes.iter().all(|pass| pass.alignment.is_some()));
    assert!(report.scans.iter().all(|scan| matches!(&scan.maps, Maps::Heights(maps) if maps.with_effect.is_none())));
    assert_eq!(report.sections.len(), 12);
    let html = page(&report);
    for words in ["differs", "Is anything missing?", "Residual against covariates", "plateau slope", "y = 0.0 mm"] {
        assert!(html.contains(words), "{words} is not on the page");
    }
}

#[test]
fn measured_volumes_and_sections_do_not_depend_on_the_model() {
    let compared = |rate: &str| {
        let text = format!("process = \"grinding\"\n[law.preston-threshold]\ngrind_rate = \"{rate}\"\n");
        let (comparison, report) = compared(&Model::parse("rate", &text, Library::builtin()).unwrap());
        let volumes = comparison.scans.iter().map(|scan| scan.volume_mm3.expect("a ground surface"));
        (volumes.collect::<Vec<[f64; 3]>>(), report.sections)
    };
    let [(low, weak), (high, strong)] = ["0.6 mm/(MPa s)", "1.3 mm/(MPa s)"].map(compared);
    for (weak, strong) in weak.iter().zip(&strong) {
        assert_eq!(format!("{:?}", weak.measured), format!("{:?}", strong.measured), "{}", weak.pass);
        assert_ne!(format!("{:?}", weak.base), format!("{:?}", strong.base), "{}", weak.pass);
    }
    for (low, high) in low.into_iter().zip(high) {
        let ([measured, sigma, simulated], [again, _, more]) = (low, high);
        println!("measured {measured:.2} and {again:.2} ± {sigma:.2} mm³, simulated {simulated:.2} and {more:.2} mm³");
        assert!((measured - again).abs() < 2.0 * sigma && more > 1.2 * simulated, "{low:?}, {high:?}");
    }
}

#[test]
fn rows_are_compared_without_maps() {
    let folder = bundled("tables/belt-sanding");
    let table = Table::read(&folder).unwrap();
    let evidence = RowEvidence::new(&table).unwrap();
    let model = evidence.scaled(Model::new(evidence.process()), Library::builtin()).unwrap();
    let model = CompiledModel::new(&model, Library::builtin(), evidence.rows()).unwrap();
    let (comparison, report) =
        compare_rows(&evidence, &model, &Asked { folder: &folder, lines: &[], seed: 1 }).unwrap();
    println!("{}", serde_json::to_string_pretty(&comparison).unwrap());
    assert!(!comparison.agrees, "a pressure exponent of 0.75 is hidden");
    assert!(["force", "pressure"].contains(&comparison.failures.covariates[0].name.as_str()), "they go together");
    assert!(comparison.failures.covariates[0].p_value_of_all <= 0.05);
    assert!(report.scans.is_empty() && page(&report).contains("Residual against covariates"));
}
