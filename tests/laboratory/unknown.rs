//! What the library lacks gets a form; what data cannot tell apart gets a trial that can.

use effects::{CompiledModel, Library, Model, Process, check_file};
use lab::{Evidence, Fit, FitOptions, ScanEvidence, calibrate, calibrate_scans, next_trial, suggest};
use trials::trial::Trial;
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
    let form = suggest(&evidence, (&model, &fit), known, 1).unwrap().expect("a form better than chance");
    println!("{}: {}, gain {:.0} of {:.0}", form.name, form.summary, form.delta_chi2, fit.chi2);
    // At one feed the way and the time in contact are one.
    let forms = [("suggested-path-position", 0.5), ("suggested-contact-time", 1.0)];
    let (_, hidden) = forms.iter().find(|known| known.0 == form.name).expect("the way or the time");
    let file = check_file("suggested.toml", &form.text).expect("a file that can be added");
    let amount = file.parameters.iter().find(|parameter| parameter.name == "amount").unwrap();
    let amount = amount.default.of(evidence.process());
    assert!((amount / hidden - 1.0).abs() < 0.3, "{hidden} per reference is hidden, {amount} found");
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
