//! Data with another prediction, otherwise unchanged.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts};
use nalgebra::DMatrix;

use super::coordinates::Coordinate;
use super::evidence::{Agreement, ErrorUnit, Evidence, EvidenceError, Split};
use super::fit::Fit;
use super::frame::FrameEstimate;
use super::pass_trend::PassTrend;
use super::summary::EffectSummary;
use super::totals::{Total, Totals};
use super::unlisted::Basis;

/// Another way to predict data.
pub(super) trait Prediction: Sync {
    /// As [`Evidence::residuals`].
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError>;

    /// As [`Totals::totals`].
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError>;
}

/// Data with another prediction.
pub(super) struct Repredicted<'a, P> {
    /// The data with their own prediction.
    pub(super) data: &'a dyn Totals,
    /// The other prediction.
    pub(super) prediction: P,
}

impl<P: Prediction> Evidence for Repredicted<'_, P> {
    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        self.prediction.residuals(model, split)
    }

    fn process(&self) -> Process {
        self.data.process()
    }

    fn rows(&self) -> RowCounts {
        self.data.rows()
    }

    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError> {
        self.data.agreement(model, split)
    }

    fn unit(&self) -> ErrorUnit {
        self.data.unit()
    }

    fn adapted(&self, model: Model, library: &Library) -> Model {
        self.data.adapted(model, library)
    }

    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        self.data.coordinates(model)
    }

    fn size(&self, change: &[f64]) -> f64 {
        self.data.size(change)
    }

    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        self.data.trend(model)
    }

    fn is_blind_to(&self, effect: &Effect) -> Option<String> {
        self.data.is_blind_to(effect)
    }

    fn conditions(&self, model: &CompiledModel) -> Result<usize, EvidenceError> {
        self.data.conditions(model)
    }

    fn family(&self, effect: &str) -> String {
        self.data.family(effect)
    }

    fn words(&self, effect: &EffectSummary) -> Option<String> {
        self.data.words(effect)
    }

    fn blocks(&self, split: Split) -> Vec<usize> {
        self.data.blocks(split)
    }

    fn folds(&self) -> Vec<usize> {
        self.data.folds()
    }

    fn pass_folds(&self) -> Vec<usize> {
        self.data.pass_folds()
    }

    fn closure(&self) -> DMatrix<f64> {
        self.data.closure()
    }

    fn smooth_errors(&self, model: &CompiledModel) -> Result<DMatrix<f64>, EvidenceError> {
        self.data.smooth_errors(model)
    }

    fn bases(&self, model: (&Model, &Fit), library: &Library) -> Result<Vec<Basis>, EvidenceError> {
        self.data.bases(model, library)
    }

    fn frame(&self, fit: &Fit) -> Result<Option<FrameEstimate>, EvidenceError> {
        self.data.frame(fit)
    }

    fn lattice_field(&self) -> Vec<f64> {
        self.data.lattice_field()
    }
}

impl<P: Prediction> Totals for Repredicted<'_, P> {
    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError> {
        self.prediction.totals(model, split)
    }

    fn unregistered(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        self.data.unregistered(model, split)
    }
}
