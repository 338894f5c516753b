//! A base law whose χ² has two minima, in synthetic data: the one near the library's values is not the deeper one.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};
use lab::{Agreement, Evidence, EvidenceError, Fit, FitOptions, PassTrend, Split, Total, Totals, calibrate};

const DATA: usize = 100;
/// Logarithm of the removal rate at the deeper minimum, relative to the library's.
const DEEPER: f64 = -0.6;
/// Height of the ridge between the minima, and residual at the nearer one [standard deviations].
const RIDGE: f64 = 150.0;
const LEFT: f64 = 8.0;

struct TwoValleys {
    library_rate: f64,
}

fn rate(model: &CompiledModel) -> f64 {
    model.value(model.index("preston-threshold.grind_rate").expect("the law has a rate"))
}

impl Evidence for TwoValleys {
    fn process(&self) -> Process {
        Process::Grinding
    }

    fn rows(&self) -> RowCounts {
        RowCounts::default()
    }

    fn residuals(&self, model: &CompiledModel, _: Split) -> Result<Vec<f64>, EvidenceError> {
        let at = (rate(model) / self.library_rate).ln();
        let [ridge, left] = [RIDGE * at * (at - DEEPER), LEFT * (1.0 - at / DEEPER)];
        Ok((0..DATA).map(|n| if n % 2 == 0 { ridge } else { left }).collect())
    }

    fn agreement(&self, _: &CompiledModel, _: Split) -> Result<Vec<Agreement>, EvidenceError> {
        Ok(Vec::new())
    }

    fn size(&self, _: &[f64]) -> f64 {
        0.0
    }

    fn trend(&self, _: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        Ok(None)
    }

    fn is_blind_to(&self, _: &Effect) -> Option<String> {
        None
    }

    fn blocks(&self, _: Split) -> Vec<usize> {
        (0..DATA).collect()
    }
}

impl Totals for TwoValleys {
    /// Returns a total that carries no information.
    fn totals(&self, _: &CompiledModel, _: Split) -> Result<Vec<Total>, EvidenceError> {
        Ok(vec![Total { about: String::new(), measured: 1.0, predicted: 1.0, sigma: 1.0 }])
    }

    fn unregistered(&self, _: &CompiledModel, _: Split) -> Result<Vec<f64>, EvidenceError> {
        Ok(Vec::new())
    }
}

#[test]
fn a_fit_that_ends_in_the_nearer_valley_is_begun_again_beside_it() {
    let (library, model) = (Library::builtin(), Model::new(Process::Grinding));
    let compiled = CompiledModel::new(&model, library, RowCounts::default()).unwrap();
    let evidence = TwoValleys { library_rate: rate(&compiled) };
    let once = Fit::new(&evidence, &compiled, evidence.coordinates(&compiled), FitOptions::default()).unwrap();
    let again = calibrate(&evidence, &model, library).unwrap().last().fit.clone();
    let at = |fit: &Fit| (rate(&fit.model) / evidence.library_rate).ln();
    println!("once {:.3} with {:.1} left, again {:.3} with {:.1}", at(&once), once.chi2, at(&again), again.chi2);
    assert!(at(&once).abs() < 0.1, "one fit alone must end in the nearer valley for this test to say anything");
    assert!((at(&again) - DEEPER).abs() < 0.01 && again.chi2 < 1.0);
}
