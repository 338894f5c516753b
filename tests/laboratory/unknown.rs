//! What the library lacks gets a form; what data cannot tell apart gets a trial that can.

use effects::{CompiledModel, Library, Model, Process, check_file};
use lab::{Evidence, Fit, FitOptions, ScanEvidence, Split, calibrate, calibrate_scans, next_trial, propose};
use trials::trial::{Campaign, Covariate, Trial, write_trial};
use virtual_lab::{Choice, Experiment, Hidden, Plan, Size};

/// An effect that no library holds: the rate rises along the path.
const ALONG: &str = "name = \"along\"\ntitle = \"Along\"\nsource = \"a test\"\nsignature = \"more along the way\"\nconfused_with = []\n\n\
    [parameters.amount]\nsymbol = \"a\"\nunit = \"1\"\nnull = 0.0\nrange = [-3.0, 3.0]\ndefault = 0.5\nabout = \"rise over 50 mm\"\n\n\
    [modify]\nrate = \"rate * (1 + amount * path_position / 0.05 m)\"\n";

fn small(library: &Library, plan: Plan, trials: usize, hidden: Vec<Hidden>) -> Vec<Trial> {
    let base = Experiment::new(Process::Grinding, library, 5).unwrap();
    let experiment = Experiment { plan, trials, size: Size::Small, choice: Choice::These(hidden), ..base };
    experiment.make().unwrap().trials
}

#[test]
fn what_the_library_lacks_gets_a_form() {
    let library = Library::builtin().with(&[("along.toml".to_owned(), ALONG.to_owned())]).unwrap();
    let trials = small(&library, Plan::Reversed, 2, vec![Hidden::effect("along").with("amount", "0.5")]);
    let known = Library::builtin();
    let mut evidence = ScanEvidence::new(&trials, None).unwrap();
    let model = Model::new(evidence.process());
    let fit = calibrate_scans(&mut evidence, &model, known).unwrap().last().fit.clone();
    let proposal = propose(&evidence, (&model, &fit), known, 1).unwrap().expect("a form better than chance");
    let form = &proposal.forms[0];
    for other in form.fitted.iter().take(5) {
        println!("{}: Δχ² {:.0}, predicts better by {:.1}", other.summary, other.delta_chi2, other.predicts_better_by);
    }
    println!(
        "{}: {}, Δχ² {:.0} of {:.0}, {:?}",
        form.name, form.summary, proposal.delta_chi2, fit.chi2, proposal.errors
    );
    // At one feed the way and the time in contact are one.
    let (mm_per_unit, alike) = match &form.variable {
        [_, unit] if unit == "mm" => (1.0, "-of-path-position"),
        _ => (1e3 * trials[0].passes[0].feed, "-of-contact-time"),
    };
    assert!(form.name.ends_with(alike), "{}", form.name);
    for (file, text) in &proposal.files {
        check_file(file, text).expect("a file that can be added");
    }
    let hidden = |at: f64| 1.0 + 0.5 * mm_per_unit * at / 50.0;
    let (first, last) = (form.curve[0], form.curve[form.curve.len() - 1]);
    let truth = hidden(last.at) / hidden(first.at);
    let [curve, found] =
        [(last.change, first.change), (last.form, first.form)].map(|(b, a)| (100.0 + b) / (100.0 + a) / truth);
    println!("rise over the hidden rise: curve {curve:.3}, form {found:.3}");
    assert!((found - 1.0).abs() < 0.03 && (curve - 1.0).abs() < 0.1, "{found} {curve}");
}

/// The rate follows a humidity that no library knows of, by the clock of each trial.
const DAMP: &str = "name = \"damp\"\ntitle = \"Damp\"\nsource = \"a test\"\nsignature = \"less when damp\"\nconfused_with = []\n\n\
    [parameters.amount]\nsymbol = \"a\"\nunit = \"1\"\nnull = 0.0\nrange = [-9.0, 9.0]\ndefault = 1.0\nabout = \"fall\"\n\n\
    [modify]\nrate = \"rate * (1 - amount * 0.15 * (sin(trial_time / 0.5 s) + sin(trial_time / 1.3 s)))\"\n";

/// The humidity [%] of which [`DAMP`] makes the rate fall by 1.5 % per 1 %.
fn humidity(time: f64) -> f64 {
    50.0 + 10.0 * ((time / 0.5).sin() + (time / 1.3).sin())
}

/// The trials with that humidity in their logs, written and read.
fn with_humidity(mut trials: Vec<Trial>) -> Vec<Trial> {
    let folder = tempfile::tempdir().unwrap();
    for trial in &mut trials {
        let start = trial.passes[0].log.rows[0].time;
        for pass in &mut trial.passes {
            let values = pass.log.rows.iter().map(|row| humidity(row.time - start)).collect();
            pass.log.covariates.push(Covariate { name: "humidity_pct".to_owned(), values, hole: None });
        }
        let place = folder.path().join(&trial.name);
        std::fs::create_dir(&place).unwrap();
        write_trial(trial, &place).unwrap();
    }
    Campaign::read(folder.path()).unwrap().trials
}

#[test]
fn a_column_of_the_log_that_scales_the_rate_is_found_again() {
    let library = Library::builtin().with(&[("damp.toml".to_owned(), DAMP.to_owned())]).unwrap();
    let trials = with_humidity(small(&library, Plan::Reversed, 2, vec![Hidden::effect("damp")]));
    let known = Library::builtin();
    let mut evidence = ScanEvidence::new(&trials, None).unwrap();
    let model = Model::new(evidence.process());
    let fit = calibrate_scans(&mut evidence, &model, known).unwrap().last().fit.clone();
    let proposal = propose(&evidence, (&model, &fit), known, 1).unwrap().expect("a form better than chance");
    let form = &proposal.forms[0];
    for other in form.fitted.iter().take(5) {
        println!("{}: Δχ² {:.0}, predicts better by {:.1}", other.summary, other.delta_chi2, other.predicts_better_by);
    }
    println!("{}: {}, {:?}", form.name, form.summary, proposal.errors);
    assert!(form.name.ends_with("-of-column-humidity") && form.variable[1] == "%", "{}", form.name);
    let (first, last) = (form.curve[0], form.curve[form.curve.len() - 1]);
    let truth = (1.0 - 0.015 * (last.at - 50.0)) / (1.0 - 0.015 * (first.at - 50.0));
    let found = (100.0 + last.form) / (100.0 + first.form);
    println!("found {found:.3}, hidden {truth:.3} from {:.1} to {:.1} %", first.at, last.at);
    assert!((found / truth - 1.0).abs() < 0.1, "{found} {truth}");
    // The file reads the column by a state of its name, and the campaign gives it.
    let with = known.with(&proposal.files[..1]).unwrap();
    let model = CompiledModel::new(&Model::new(Process::Grinding).with(&form.name), &with, evidence.rows()).unwrap();
    assert!(evidence.residuals(&model, Split::Calibration).is_ok());
    // An effect of a column that no trial gives is not tried.
    let lost = proposal.files[0].1.replace("humidity", "dampness");
    let lost = Library::builtin().with(&[("lost.toml".to_owned(), lost)]).unwrap();
    let effect = lost.effects().iter().find(|effect| effect.name.contains("dampness")).unwrap();
    assert!(evidence.is_blind_to(effect).unwrap().contains("column dampness"));
}

#[test]
fn where_nothing_is_hidden_nothing_is_proposed() {
    let trials = small(Library::builtin(), Plan::Varied, 3, Vec::new());
    let mut evidence = ScanEvidence::new(&trials, None).unwrap();
    let model = Model::new(evidence.process());
    let fit = calibrate_scans(&mut evidence, &model, Library::builtin()).unwrap().last().fit.clone();
    let form = propose(&evidence, (&model, &fit), Library::builtin(), 1).unwrap();
    assert!(form.is_none(), "{form:?}");
}

#[test]
fn rivals_get_a_trial_that_tells_them_apart() {
    let trials = small(Library::builtin(), Plan::Paper, 1, vec![Hidden::effect("break-in")]);
    let evidence = ScanEvidence::new(&trials, None).unwrap();
    let base = Model::new(evidence.process());
    let fit = |effect: &str| -> Fit {
        let model = base.clone().with(effect);
        let compiled = CompiledModel::new(&model, Library::builtin(), evidence.rows()).unwrap();
        Fit::new(&evidence, &compiled, evidence.coordinates(&compiled), FitOptions { derivatives: 1, steps: 4 })
            .unwrap()
    };
    let (one, other) = (fit("break-in"), fit("thermal-softening"));
    let trial = next_trial(&evidence, (("break-in", &one), ("thermal-softening", &other))).unwrap().expect("a trial");
    println!("{trial:?}");
    assert_eq!(trial.separates, ["break-in", "thermal-softening"]);
    assert!(trial.expected_delta_chi2 > 0.0 && (0.5..=1.0).contains(&trial.probability_right));
    assert_eq!(trial.force_n.len(), trials[0].passes.len());
    let unchanged = calibrate(&evidence, &base, Library::builtin()).unwrap().last().fit.clone();
    let same = next_trial(&evidence, (("base", &unchanged), ("base", &unchanged))).unwrap().expect("a trial");
    assert!(
        same.expected_delta_chi2 < 1e-6 && trial.expected_delta_chi2 > 1.0,
        "a model is not told from itself: {same:?}"
    );
}
