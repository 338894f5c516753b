//! An effect that fits the calibration data, and predicts the held-out data worse than the model without it.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};
use lab::{Agreement, Diagnosis, Evidence, EvidenceError, Fit, PassTrend, Split, Verdict};

use super::look::{BREAK_IN, Depths, base};

/// Depths with a break-in that the held-out ones repeat, or that they do not show at all.
struct Divided {
    depths: Depths,
    /// The base law's own fit, with which the held-out depths agree; `None` where they have the break-in.
    held_out: Option<CompiledModel>,
}

impl Evidence for Divided {
    fn process(&self) -> Process {
        self.depths.process()
    }

    fn rows(&self) -> RowCounts {
        self.depths.rows()
    }

    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let left = self.depths.left(model);
        Ok(match self.held_out.as_ref().filter(|_| split == Split::Evaluation) {
            Some(truth) => left.iter().zip(self.depths.left(truth)).map(|(left, own)| left - own).collect(),
            None => left,
        })
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        let rms = self.size(&self.residuals(model, split)?);
        let one = self.depths.agreement(model, split)?.remove(0);
        Ok(vec![Agreement { rms, ..one }])
    }

    fn size(&self, change: &[f64]) -> f64 {
        self.depths.size(change)
    }

    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        self.depths.trend(model)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        self.depths.is_blind_to(effect)
    }

    fn blocks(&self, split: Split) -> Vec<usize> {
        self.depths.blocks(split)
    }
}

/// Diagnoses depths with a break-in; `repeats` is true where the held-out ones have it too.
fn diagnosed(repeats: bool) -> Diagnosis {
    let (depths, fit): (Depths, Fit) = base(0.5);
    let held_out = (!repeats).then(|| fit.model.clone());
    let evidence = Divided { depths, held_out };
    let model = Model::new(Process::Grinding);
    Diagnosis::new(&evidence, (&model, fit), Library::builtin(), (1, &|_, _, _| {})).unwrap()
}

#[test]
fn an_effect_that_held_out_data_repeat_is_named() {
    let diagnosis = diagnosed(true);
    assert!(matches!(diagnosis.verdict, Verdict::Identified | Verdict::Ambiguous), "{:?}", diagnosis.verdict);
    assert_eq!(diagnosis.found()[0].suspect.name(), BREAK_IN);
}

#[test]
fn an_effect_that_held_out_data_contradict_is_taken_back_and_the_reason_stated() {
    let diagnosis = diagnosed(false);
    assert_eq!(diagnosis.verdict, Verdict::Unknown);
    assert!(diagnosis.found().is_empty() && diagnosis.model.effects.is_empty());
    let round = &diagnosis.rounds[0];
    let first = &round.findings[0];
    assert_eq!(first.suspect.name(), BREAK_IN, "it stays in the table of suspects");
    let reason = round.ruled_out(first, lab::ErrorUnit::Metre).unwrap();
    assert!(reason.contains("raises the error of the held-out passes"), "{reason}");
}
