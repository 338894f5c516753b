//! Detectable size and expected Δχ² of an effect after the base parameters are refitted: in a campaign of the virtual
//! laboratory, and in synthetic data whose depths are a removal rate times a break-in.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};
use lab::{
    Agreement, Baseline, Candidate, Evidence, EvidenceError, Fit, FitOptions, PassTrend, Projector, ScanEvidence,
    Screened, Sides, Split, calibrate_scans, detectable, with_values,
};
use virtual_lab::{Choice, Experiment, Hidden, Instrument, Plan, Robot, Size};

const DATA: usize = 200;
/// Depth without break-in [standard deviations].
const DEPTH: f64 = 60.0;
/// Sliding distance over all data [m].
const SLID: f64 = 50.0;
pub(super) const BREAK_IN: &str = "break-in";
const DISTANCE: f64 = 200.0;

/// Noise-free depths of a break-in with this excess.
pub(super) struct Depths {
    excess: f64,
}

fn depth(rate: f64, excess: f64, distance: f64, number: usize) -> f64 {
    let slid = SLID * number as f64 / DATA as f64;
    DEPTH * rate * (1.0 + excess * (-slid / distance).exp())
}

impl Depths {
    pub(super) fn left(&self, model: &CompiledModel) -> Vec<f64> {
        let value = |name: &str| model.index(name).map(|at| model.value(at));
        let rate = value("preston-threshold.grind_rate").unwrap() / library_rate();
        let [excess, distance] = [value("break-in.excess"), value("break-in.distance")];
        let of = |n| depth(rate, excess.unwrap_or(0.0), distance.unwrap_or(DISTANCE), n);
        (0..DATA).map(|n| depth(1.0, self.excess, DISTANCE, n) - of(n)).collect()
    }
}

fn library_rate() -> f64 {
    let model = CompiledModel::new(&Model::new(Process::Grinding), Library::builtin(), RowCounts::default()).unwrap();
    model.value(model.index("preston-threshold.grind_rate").unwrap())
}

impl Evidence for Depths {
    fn process(&self) -> Process {
        Process::Grinding
    }

    fn rows(&self) -> RowCounts {
        RowCounts::default()
    }

    fn residuals(&self, model: &CompiledModel, _: Split) -> Result<Vec<f64>, EvidenceError> {
        Ok(self.left(model))
    }

    fn agreement(&self, model: &CompiledModel, _: Split) -> Result<Vec<Agreement>, EvidenceError> {
        let rms = self.size(&self.left(model));
        Ok(vec![Agreement {
            about: "by hand".to_owned(),
            rms,
            floor: 1e-6,
            noise: 1e-6,
            scale: DEPTH * 1e-6,
            smooth_error: 1e-3 * DEPTH * 1e-6,
        }])
    }

    fn size(&self, change: &[f64]) -> f64 {
        1e-6 * (change.iter().map(|x| x * x).sum::<f64>() / DATA as f64).sqrt()
    }

    fn trend(&self, _: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        Ok(None)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        (effect.name != BREAK_IN).then(|| "made by hand without it".to_owned())
    }

    fn blocks(&self, _: Split) -> Vec<usize> {
        (0..DATA).collect()
    }
}

/// Fits the base law to depths with a break-in.
pub(super) fn base(excess: f64) -> (Depths, Fit) {
    let (evidence, model) = (Depths { excess }, Model::new(Process::Grinding));
    let compiled = CompiledModel::new(&model, Library::builtin(), evidence.rows()).unwrap();
    let fit = Fit::new(&evidence, &compiled, evidence.coordinates(&compiled), FitOptions::default()).unwrap();
    (evidence, fit)
}

/// Screens an effect beside the base law.
fn screened(evidence: &dyn Evidence, fit: &Fit, effect: &str) -> Screened {
    let effect = Library::builtin().find(effect).unwrap();
    let model = with_values(&Model::new(Process::Grinding), fit);
    let candidate = Candidate::new(evidence, &model, effect, Library::builtin()).unwrap();
    Screened::new(&Baseline { evidence, base: fit, projector: &Projector::new(fit) }, candidate)
}

#[test]
fn a_base_law_fitted_to_a_detectable_size_leaves_what_is_seen() {
    let (evidence, fit) = base(0.0);
    let first = screened(&evidence, &fit, BREAK_IN);
    let baseline = Baseline { evidence: &evidence, base: &fit, projector: &Projector::new(&fit) };
    let sizes = detectable(&baseline, &first, (1.0, 0.0));
    let size = sizes.iter().find(|row| row.parameter == "excess").expect("it has an amplitude");
    assert_eq!((size.sides, size.testable), (Sides::All, true));
    for excess in [1.0, -1.0].map(|side| side * size.size.unwrap()) {
        let left = base(excess).1.chi2.sqrt();
        println!("{excess:+.4}: {left:.2} standard deviations are left");
        assert!((3.6..5.2).contains(&left), "{excess}: {left}");
    }
}

/// Returns the Δχ² that the best probe of an effect predicts from the Jacobian of the base law alone.
fn promised_by_slopes(first: &Screened, fit: &Fit) -> f64 {
    let projector = Projector::new(fit);
    let promised = first.responses.iter().flatten().map(|response| {
        let change = projector.project(&response.raw);
        change.dot(&projector.residuals).powi(2) / change.norm_squared()
    });
    promised.fold(0.0, f64::max)
}

#[test]
fn a_break_in_that_the_removal_rate_followed_promises_more_than_its_rival() {
    let library = Library::builtin();
    let hidden = Hidden::effect(BREAK_IN).with("excess", "0.087").with("distance", "120 m");
    let new = Experiment::new(Process::Grinding, library, 5).unwrap();
    let (choice, plan) = (Choice::These(vec![hidden]), Plan::Steps);
    let clean = Experiment { instrument: Instrument::clean(), robot: Robot::clean(), ..new };
    let made = Experiment { plan, trials: plan.usual_trials(), size: Size::Small, choice, ..clean }.make().unwrap();
    let mut evidence = ScanEvidence::new(&made.trials, None).unwrap();
    let fit = calibrate_scans(&mut evidence, &Model::new(Process::Grinding), library).unwrap();
    let fit = fit.last().fit.clone();
    let [truth, rival] = [BREAK_IN, "grit-dulling"].map(|effect| screened(&evidence, &fit, effect));
    let by_slopes = promised_by_slopes(&truth, &fit);
    println!("break-in {:.1}, by slopes {by_slopes:.1}; grit-dulling {:.1}", truth.delta_chi2, rival.delta_chi2);
    assert!(truth.delta_chi2 > rival.delta_chi2 && rival.delta_chi2 > 100.0);
    assert!(by_slopes <= truth.delta_chi2, "to follow the base parameters promises no less: {by_slopes}");
}
