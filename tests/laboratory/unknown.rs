//! An unlisted effect is described by a form; for indistinguishable effects a distinguishing trial is proposed.

use effects::{CompiledModel, Library, Model, Process, check_file};
use experiments::{Hypothesis, next_trial};
use lab::{Evidence, Fit, FitOptions, ScanEvidence, calibrate, calibrate_scans, propose};
use trials::trial::Trial;
use virtual_lab::{Choice, Experiment, Hidden, Plan, Size};

/// An unlisted effect: the rate rises along the path.
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
    // At one feed, position and contact time are proportional.
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
    let hypothesis = |name, fit| Hypothesis { name, probability: 0.4, fit };
    let rivals = [hypothesis("break-in", &one), hypothesis("thermal-softening", &other)];
    let trial = next_trial(&evidence, &rivals, 1.0).unwrap().expect("a trial");
    println!("{trial:?}");
    assert_eq!(trial.separates, ["break-in", "thermal-softening"]);
    assert!(trial.expected_delta_chi2 > 0.0 && (0.5..=1.0).contains(&trial.probability_right));
    let choice = trial.choice.as_ref().expect("a trial of a menu");
    let planned: usize = choice.plan.iter().map(|stage| stage.passes.len()).sum();
    assert_eq!(trial.force_n.len(), planned);
    assert!(choice.menu >= 40 && choice.runners_up.len() == 5, "{}", choice.menu);
    let best = choice.worth.nats_per_minute;
    assert!(choice.runners_up.iter().all(|runner| runner.worth.nats_per_minute <= best));
    assert!((choice.entropy_nats - 2f64.ln()).abs() < 1e-12 && choice.worth.expected_information_nats <= 2f64.ln());
    let unchanged = calibrate(&evidence, &base, Library::builtin()).unwrap().last().fit.clone();
    let same = [hypothesis("base", &unchanged), hypothesis("base", &unchanged)];
    let same = next_trial(&evidence, &same, 1.0).unwrap().expect("a trial");
    assert!(
        same.expected_delta_chi2 < 1e-6 && trial.expected_delta_chi2 > 1.0,
        "a model is not told from itself: {same:?}"
    );
}
