//! Two effects that are found only together, in synthetic data: each of a few effects shifts the data along its own
//! pattern.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};
use lab::{Agreement, Diagnosis, Evidence, EvidenceError, Fit, FitOptions, PassTrend, Split, Verdict};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const DATA: usize = 240;
const BLOCK: usize = 6;

/// Shift of the data [standard deviations] that a change of a parameter by `unit` causes.
struct Pattern {
    effect: &'static str,
    parameter: &'static str,
    unit: f64,
    shift: fn(f64, Split) -> f64,
}

fn wave(at: f64) -> f64 {
    (11.0 * at).sin()
}

fn ramp(at: f64) -> f64 {
    2.0 * at - 1.0
}

/// The third effect mimics parts of both others, and shifts the held-out data the opposite way.
const PATTERNS: [Pattern; 3] = [
    Pattern { effect: "cutting-direction", parameter: "asymmetry", unit: 0.1, shift: |at, _| wave(at) },
    Pattern { effect: "force-bias", parameter: "bias", unit: 2.0, shift: |at, _| ramp(at) },
    Pattern {
        effect: "speed-exponent",
        parameter: "exponent",
        unit: 0.5,
        shift: |at, split| {
            let way = if split == Split::Calibration { 1.0 } else { -1.0 };
            way * (wave(at) + ramp(at)) + 0.1 * (37.0 * at).cos()
        },
    },
];

/// Two effects shift the calibration data nearly alike, and one of them shifts the held-out data the opposite way.
const LOOK_ALIKES: [Pattern; 3] = [
    Pattern { effect: "cutting-direction", parameter: "asymmetry", unit: 0.1, shift: |at, _| wave(at) },
    Pattern { effect: "force-bias", parameter: "bias", unit: 2.0, shift: |_, _| 0.0 },
    Pattern {
        effect: "speed-exponent",
        parameter: "exponent",
        unit: 0.5,
        shift: |at, split| if split == Split::Calibration { wave(at) + 0.08 * (23.0 * at).cos() } else { -wave(at) },
    },
];

/// Synthetic measurements with given amounts of the effects, and noise of one standard deviation.
struct ByHand {
    patterns: &'static [Pattern; 3],
    truth: [f64; 3],
    /// Additional shift of the calibration data.
    besides: fn(f64) -> f64,
}

impl ByHand {
    fn shift(&self, amounts: [f64; 3], number: usize, split: Split) -> f64 {
        let at = number as f64 / DATA as f64;
        self.patterns.iter().zip(amounts).map(|(pattern, amount)| 10.0 * amount * (pattern.shift)(at, split)).sum()
    }

    fn beside(&self, number: usize, split: Split) -> f64 {
        if split == Split::Calibration { (self.besides)(number as f64 / DATA as f64) } else { 0.0 }
    }

    fn left(&self, model: &CompiledModel, split: Split) -> Vec<f64> {
        let value = |pattern: &Pattern| {
            let known = model.parameters().iter();
            let place =
                known.clone().position(|slot| slot.owner == pattern.effect && slot.parameter == pattern.parameter);
            place.map_or(0.0, |place| model.value(place) / pattern.unit)
        };
        let amounts = self.patterns.each_ref().map(value);
        let mut random = Pcg64Mcg::seed_from_u64(if split == Split::Calibration { 7 } else { 8 });
        // The sum of twelve uniform numbers is close to a normal distribution.
        let mut noise = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let left =
            |n| self.shift(self.truth, n, split) - self.shift(amounts, n, split) + self.beside(n, split) + noise();
        (0..DATA).map(left).collect()
    }
}

impl Evidence for ByHand {
    fn process(&self) -> Process {
        Process::Grinding
    }

    fn rows(&self) -> RowCounts {
        RowCounts::default()
    }

    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        Ok(self.left(model, split))
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        let rms = self.size(&self.left(model, split));
        Ok(vec![Agreement {
            about: "by hand".to_owned(),
            rms,
            floor: 1e-6,
            noise: 1e-6,
            scale: 100e-6,
            smooth_error: 0.1e-6,
        }])
    }

    fn size(&self, change: &[f64]) -> f64 {
        1e-6 * (change.iter().map(|x| x * x).sum::<f64>() / DATA as f64).sqrt()
    }

    fn trend(&self, _: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        Ok(None)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        let known = self.patterns.iter().any(|pattern| pattern.effect == effect.name);
        (!known).then(|| "made by hand without it".to_owned())
    }

    fn blocks(&self, _: Split) -> Vec<usize> {
        (0..DATA).map(|n| n / BLOCK).collect()
    }
}

fn diagnosed(truth: [f64; 3], searches: usize) -> Diagnosis {
    diagnosed_from(&ByHand { patterns: &PATTERNS, truth, besides: |_| 0.0 }, searches)
}

fn diagnosed_from(evidence: &ByHand, searches: usize) -> Diagnosis {
    let library = Library::builtin();
    let model = Model::new(Process::Grinding);
    let compiled = CompiledModel::new(&model, library, evidence.rows()).unwrap();
    let fit = Fit::new(evidence, &compiled, evidence.coordinates(&compiled), FitOptions::default()).unwrap();
    Diagnosis::within(evidence, (&model, fit), library, (1, &|_, _, _| {}), searches).unwrap()
}

fn names(diagnosis: &Diagnosis) -> Vec<&str> {
    diagnosis.found().iter().map(|found| found.suspect.name()).collect()
}

#[test]
fn two_effects_are_found_together_where_a_third_outdoes_each() {
    let diagnosis = diagnosed([1.0, 1.0, 0.0], 3);
    let greedy = &diagnosis.rounds[0].findings[1];
    println!("{:?} {:?}; alone {} gained most", diagnosis.verdict, names(&diagnosis), greedy.suspect.name());
    assert_eq!(diagnosis.verdict, Verdict::Identified);
    let mut found = names(&diagnosis);
    found.sort_unstable();
    assert_eq!(found, ["cutting-direction", "force-bias"]);
    let left = diagnosis.found()[1].evaluation[0].rms;
    assert!(left < 1.2e-6, "{left}");
    for pattern in &PATTERNS[..2] {
        let slots = diagnosis.fit.model.parameters();
        let at = slots.iter().position(|slot| slot.owner == pattern.effect && slot.parameter == pattern.parameter);
        let value = diagnosis.fit.model.value(at.expect("it is in the model")) / pattern.unit;
        assert!((value - 1.0).abs() < 0.05, "{}: {value}", pattern.effect);
    }
}

#[test]
fn one_search_gives_the_first_of_the_two() {
    let diagnosis = diagnosed([1.0, 1.0, 0.0], 1);
    assert_eq!(diagnosis.verdict, Verdict::Partly);
    assert_eq!(names(&diagnosis).len(), 1);
    assert_ne!(names(&diagnosis), ["speed-exponent"]);
}

#[test]
fn one_effect_is_not_made_into_two() {
    let diagnosis = diagnosed([0.0, 1.0, 0.0], 3);
    assert_eq!((diagnosis.verdict, names(&diagnosis)), (Verdict::Identified, vec!["force-bias"]));
}

/// Diagnoses data with an additional shift that only the indistinguishable effect explains; also returns the Δχ² by
/// which the calibration data prefer that effect.
fn of_look_alikes(besides: fn(f64) -> f64) -> (Diagnosis, f64) {
    let diagnosis = diagnosed_from(&ByHand { patterns: &LOOK_ALIKES, truth: [1.0, 0.0, 0.0], besides }, 3);
    let gain = |name: &str| {
        let finding = diagnosis.rounds[0].findings.iter().find(|finding| finding.suspect.name() == name);
        finding.expect("it was fitted").delta_chi2
    };
    let lead = gain("speed-exponent") - gain("cutting-direction");
    println!("{:?} {:?}; the calibration data prefer the other by {lead:.1}", diagnosis.verdict, names(&diagnosis));
    (diagnosis, lead)
}

#[test]
fn what_fits_as_well_and_degrades_what_is_held_out_is_not_named() {
    let (diagnosis, lead) = of_look_alikes(|at| 0.45 * (23.0 * at).cos());
    assert!(lead > 0.0 && lead < 7.85, "{lead}");
    assert_eq!((diagnosis.verdict, names(&diagnosis)), (Verdict::Unknown, Vec::new()));
}

#[test]
fn what_fits_better_and_degrades_what_is_held_out_leaves_it_unknown() {
    for besides in [|at: f64| 0.8 * (23.0 * at).cos(), |at: f64| 2.0 * (23.0 * at).cos()] {
        let (diagnosis, lead) = of_look_alikes(besides);
        assert!(lead > 30.0, "{lead}");
        assert_eq!((diagnosis.verdict, names(&diagnosis)), (Verdict::Unknown, Vec::new()));
    }
}

#[test]
fn held_out_data_take_no_part_in_the_choice() {
    let (chosen, _) = of_look_alikes(|at| 0.8 * (23.0 * at).cos());
    let best = &chosen.rounds[0].findings[0];
    assert_eq!(best.suspect.name(), "speed-exponent", "it predicts calibration data best");
    assert!(best.probability > 0.9, "{}", best.probability);
}
