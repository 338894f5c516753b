//! Effects hidden in a table are found, and none if nothing is hidden.

use effects::{CompiledModel, Library, Model, RowCounts};
use lab::{Estimate, Evidence, Fit, FitOptions, RowEvidence, Split, robust_sum};
use trials::table::Table;
use trials::trial::Role;

use crate::synthetic::{
    DULLING, Hidden, MANIFEST, NOISE, PRESSURE_EXPONENT, RATE, ROWS, SPEED_EXPONENT, USAGE, csv, folder, work,
};

/// Effects tried on every table.
const TRIED: [&str; 3] = ["grit-dulling", "pressure-exponent", "speed-exponent"];

pub(crate) fn table(manifest: &str, csv: &str) -> Table {
    Table::read(folder(manifest, csv).path()).unwrap()
}

/// Compiles the base law, and an effect, for a table.
pub(crate) fn model(evidence: &RowEvidence, effect: Option<&str>) -> CompiledModel {
    let base = Model::new(evidence.process());
    let model = effect.map_or(base.clone(), |effect| base.with(effect));
    let model = evidence.scaled(model, Library::builtin()).unwrap();
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap()
}

pub(crate) fn fit(evidence: &RowEvidence, effect: Option<&str>) -> Fit {
    let model = model(evidence, effect);
    let (coordinates, _) = evidence.coordinates(&model).unwrap();
    Fit::new(evidence, &model, coordinates, FitOptions { derivatives: 40, steps: 60 }).unwrap()
}

fn estimate(fit: &Fit, name: &str) -> Estimate {
    let estimates = fit.estimates((fit.chi2 / fit.residuals.len() as f64).sqrt().max(1.0));
    estimates.into_iter().find(|estimate| estimate.coordinate.slot.name() == name).unwrap()
}

/// Asserts that a parameter is found within its interval, which must be narrow.
fn recovers(fit: &Fit, name: &str, truth: f64, narrow: f64) {
    assert!(fit.converged, "{name}");
    let found = estimate(fit, name);
    let off = found.coordinate.from_value(found.value) - found.coordinate.from_value(truth);
    println!(
        "{name}: {:.6e} for {truth:.6e}, {:.2} standard deviations of {:.4}",
        found.value,
        off / found.sigma,
        found.sigma
    );
    assert!(found.sigma < narrow, "{name}: {}", found.sigma);
    assert!(off.abs() < 3.0 * found.sigma, "{name}: {} for {truth}, sigma {}", found.value, found.sigma);
}

/// Returns the mean square of the whitened residuals of held-out rows.
fn held_out(evidence: &RowEvidence, fit: &Fit) -> f64 {
    let residuals = evidence.residuals(&fit.model, Split::Evaluation).unwrap();
    robust_sum(&residuals) / residuals.len() as f64
}

fn manifest(hidden: Hidden) -> String {
    let usage = if hidden == Hidden::Usage { USAGE } else { "" };
    format!("{MANIFEST}{usage}")
}

/// Returns the Δχ² of each tried effect.
fn gains(evidence: &RowEvidence) -> [f64; 3] {
    let base = fit(evidence, None).chi2;
    TRIED.map(|effect| base - fit(evidence, Some(effect)).chi2)
}

#[test]
fn where_nothing_is_hidden_the_rate_constant_is_found_and_no_effect_helps() {
    let table = table(MANIFEST, &csv(&work(Hidden::Nothing, NOISE, 1)));
    let evidence = RowEvidence::new(&table).unwrap();
    println!("{:?}", evidence.notes);
    assert!((0.6..1.5).contains(&(evidence.noise / NOISE)), "{}", evidence.noise);
    let base = fit(&evidence, None);
    recovers(&base, "preston-threshold.grind_rate", RATE, 0.05);
    assert!((0.4..1.8).contains(&(base.chi2 / base.residuals.len() as f64)), "{}", base.chi2);
    assert!((0.3..2.0).contains(&held_out(&evidence, &base)));
    let gains = gains(&evidence);
    println!("{gains:?}");
    assert!(gains.iter().all(|gain| *gain < 12.0), "{gains:?}");
}

#[test]
fn a_hidden_effect_is_found_with_its_parameter_and_no_other_explains_it() {
    for (hidden, effect, parameter, truth, narrow) in [
        (Hidden::Dulling, "grit-dulling", "dulling_volume", DULLING, 0.1),
        (Hidden::Pressure, "pressure-exponent", "exponent", PRESSURE_EXPONENT, 0.02),
        (Hidden::Speed, "speed-exponent", "exponent", SPEED_EXPONENT, 0.02),
        (Hidden::Usage, "grit-dulling", "dulling_volume", DULLING, 0.1),
    ] {
        let table = table(&manifest(hidden), &csv(&work(hidden, NOISE, 7)));
        let evidence = RowEvidence::new(&table).unwrap();
        let gains = gains(&evidence);
        let with = fit(&evidence, Some(effect));
        println!("{hidden:?}: noise {:.4}, gains {gains:?}, chi2 {:.1}", evidence.noise, with.chi2);
        assert!((0.6..1.5).contains(&(evidence.noise / NOISE)), "{hidden:?}: {}", evidence.noise);
        recovers(&with, &format!("{effect}.{parameter}"), truth, narrow);
        for (name, gain) in TRIED.iter().zip(gains) {
            let own = gains[TRIED.iter().position(|tried| *tried == effect).unwrap()];
            if *name == effect {
                assert!(gain > 100.0, "{hidden:?}: {name} {gain}");
            } else {
                assert!(gain < 0.3 * own, "{hidden:?}: {name} gains {gain} of {own}");
            }
        }
        assert!((0.3..2.0).contains(&held_out(&evidence, &with)), "{hidden:?}: {}", held_out(&evidence, &with));
        assert!(held_out(&evidence, &fit(&evidence, None)) > 2.0 * held_out(&evidence, &with), "{hidden:?}");
    }
}

#[test]
fn a_measured_state_is_read_from_its_column() {
    let rows = work(Hidden::Usage, NOISE, 3);
    let measured = table(&manifest(Hidden::Usage), &csv(&rows));
    let evidence = RowEvidence::new(&measured).unwrap();
    assert!(
        evidence.notes.iter().any(|note| note.contains("grit-dulling.ground_volume is read from column \"wear\"")),
        "{:?}",
        evidence.notes
    );
    let integrated = table(MANIFEST, &csv(&rows));
    let other = RowEvidence::new(&integrated).unwrap();
    let (with, without) = (fit(&evidence, Some("grit-dulling")), fit(&other, Some("grit-dulling")));
    println!("chi2 {:.1} with the column, {:.1} without", with.chi2, without.chi2);
    assert!(with.chi2 < 1.8 * with.residuals.len() as f64);
}

#[test]
fn predictions_are_those_of_the_closed_form() {
    let rows = work(Hidden::Dulling, 0.0, 5);
    let table = table(MANIFEST, &csv(&rows));
    let evidence = RowEvidence::new(&table).unwrap();
    let mut model = model(&evidence, Some("grit-dulling"));
    model.set(model.index("preston-threshold.grind_rate").unwrap(), RATE);
    model.set(model.index("grit-dulling.dulling_volume").unwrap(), DULLING);
    let predicted = evidence.predicted(&model).unwrap();
    assert_eq!(predicted.len(), ROWS);
    let off = predicted.iter().zip(&rows).map(|(rate, row)| (rate * row.duration / row.depth - 1.0).abs());
    let worst = off.fold(0.0, f64::max);
    println!("largest relative error {worst:.2e}");
    assert!(worst < 2e-4, "{worst}");
}

#[test]
fn a_fresh_tool_and_another_tool_begin_again() {
    let mut rows = work(Hidden::Dulling, 0.0, 9);
    let half = ROWS / 2;
    let again = work(Hidden::Dulling, 0.0, 9);
    rows[half..].copy_from_slice(&again[..ROWS - half]);
    let plain = csv(&rows);
    let lines: Vec<&str> = plain.lines().collect();
    let added = |header: &str, value: &dyn Fn(usize) -> &'static str| -> String {
        let row = |(k, line): (usize, &&str)| {
            if k == 0 { format!("{line},{header}\n") } else { format!("{line},{}\n", value(k - 1)) }
        };
        lines.iter().enumerate().map(row).collect()
    };
    for (key, text) in [
        ("fresh", added("mark", &|row| if row == half { "yes" } else { "no" })),
        ("tool", added("mark", &|row| if row < half { "belt 1" } else { "belt 2" })),
    ] {
        let table = table(&format!("{MANIFEST}{key} = {{ column = \"mark\" }}\n"), &text);
        let evidence = RowEvidence::new(&table).unwrap();
        let mut model = model(&evidence, Some("grit-dulling"));
        model.set(model.index("preston-threshold.grind_rate").unwrap(), RATE);
        model.set(model.index("grit-dulling.dulling_volume").unwrap(), DULLING);
        let predicted = evidence.predicted(&model).unwrap();
        let worst = predicted.iter().zip(&rows).map(|(rate, row)| (rate * row.duration / row.depth - 1.0).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 2e-4, "{key}: {worst}");
    }
}

#[test]
fn groups_have_gains_of_their_own() {
    let mut rows = work(Hidden::Pressure, NOISE, 11);
    rows.iter_mut().enumerate().filter(|(k, _)| k % 4 == 0).for_each(|(_, row)| row.depth *= 1.7);
    let text = csv(&rows);
    let recipe = |(k, line): (usize, &str)| match k {
        0 => format!("{line},recipe\n"),
        _ => format!("{line},{}\n", if (k - 1) % 4 == 0 { "coarse" } else { "fine" }),
    };
    let text: String = text.lines().enumerate().map(recipe).collect();
    let table = table(&format!("{MANIFEST}group = {{ column = \"recipe\" }}\n"), &text);
    assert_eq!(table.groups, ["coarse", "fine"]);
    let evidence = RowEvidence::new(&table).unwrap();
    let with = fit(&evidence, Some("pressure-exponent"));
    recovers(&with, "pressure-exponent.exponent", PRESSURE_EXPONENT, 0.02);
    assert!(with.chi2 < 1.8 * with.residuals.len() as f64, "{}", with.chi2);
    assert!(held_out(&evidence, &with) < 2.0, "{}", held_out(&evidence, &with));
    assert!(fit(&evidence, None).chi2 > with.chi2 + 100.0);
}

#[test]
fn gross_outliers_are_named_and_do_not_lead_the_fit() {
    let mut rows = work(Hidden::Pressure, NOISE, 13);
    let plain = table(MANIFEST, &csv(&rows));
    let calibrates: Vec<usize> = (0..ROWS).filter(|&at| plain.rows[at].role == Role::Calibration).collect();
    let wrong = [calibrates[6], calibrates[26]];
    rows[wrong[0]].depth *= 3.0;
    rows[wrong[1]].depth *= 0.2;
    let table = table(MANIFEST, &csv(&rows));
    let evidence = RowEvidence::new(&table).unwrap();
    let with = fit(&evidence, Some("pressure-exponent"));
    recovers(&with, "pressure-exponent.exponent", PRESSURE_EXPONENT, 0.05);
    let lines: Vec<u64> = evidence.outliers(&with.residuals, Split::Calibration).iter().map(|row| row.line).collect();
    assert_eq!(lines, wrong.map(|at| at as u64 + 2));
}

#[test]
fn the_table_of_the_project_tells_its_exponent_and_its_wrong_row() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("data/tables/belt-sanding");
    let table = Table::read(&folder).unwrap();
    let evidence = RowEvidence::new(&table).unwrap();
    println!("{:#?}\n{:#?}", table.notes, evidence.notes);
    let with = fit(&evidence, Some("pressure-exponent"));
    recovers(&with, "pressure-exponent.exponent", 0.75, 0.05);
    let wrong = [Split::Calibration, Split::Evaluation].map(|split| {
        let residuals = evidence.residuals(&with.model, split).unwrap();
        evidence.outliers(&residuals, split).iter().map(|row| row.line).collect::<Vec<u64>>()
    });
    assert_eq!(wrong.concat(), [42]);
    assert!(fit(&evidence, None).chi2 > with.chi2 + 30.0);
}

#[test]
fn intervals_hold_the_truth_as_often_as_they_say() {
    const SEEDS: u64 = 24;
    let (mut inside, mut false_gains, mut noise) = (0, 0, Vec::new());
    for seed in 100..100 + SEEDS {
        let hidden = table(MANIFEST, &csv(&work(Hidden::Pressure, NOISE, seed)));
        let evidence = RowEvidence::new(&hidden).unwrap();
        let found = estimate(&fit(&evidence, Some("pressure-exponent")), "pressure-exponent.exponent");
        let off = found.coordinate.from_value(found.value) - found.coordinate.from_value(PRESSURE_EXPONENT);
        inside += usize::from(off.abs() < 2.0 * found.sigma);
        noise.push(evidence.noise / NOISE);
        let nothing = table(MANIFEST, &csv(&work(Hidden::Nothing, NOISE, seed)));
        let evidence = RowEvidence::new(&nothing).unwrap();
        let gain = fit(&evidence, None).chi2 - fit(&evidence, Some("speed-exponent")).chi2;
        false_gains += usize::from(gain > 6.63);
    }
    noise.sort_by(f64::total_cmp);
    let (least, most) = (noise[0], noise[noise.len() - 1]);
    println!("{inside} of {SEEDS} inside, {false_gains} false gains, noise {least:.2} to {most:.2} of the true one");
    assert!(inside >= 20, "{inside}");
    assert!(false_gains <= 3, "{false_gains}");
    assert!(least > 0.6 && most < 1.5, "{least} {most}");
}
