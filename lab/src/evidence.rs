//! Interface of the data that a model is compared with: scans or rows.

use effects::{CompiledModel, Effect, Library, Model, Process, RowCounts, RunError};
use nalgebra::DMatrix;
use thiserror::Error;

use super::coordinates::Coordinate;
use super::fit::Fit;
use super::frame::FrameEstimate;
use super::pass_trend::PassTrend;
use super::summary::EffectSummary;
use super::totals::Totals;
use super::unlisted::Basis;
use trial_simulation::CampaignError;

/// Calibration or held-out data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Calibration data: fits use them.
    Calibration,
    /// Held-out data: no fit uses them, and effects found must hold on them.
    Evaluation,
}

/// Reason for which data cannot be compared with a model.
#[derive(Debug, Error)]
pub enum EvidenceError {
    /// The model cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] CampaignError),
    /// A formula of the scanner failed.
    #[error("a simulated scan: {0}")]
    Scan(#[from] RunError),
    /// There are no data to compare with.
    #[error("{0}")]
    NoData(String),
}

/// Unit of the errors of data. Every stored error is in it; texts and pages use its display unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum ErrorUnit {
    /// Metres, displayed in µm.
    #[default]
    #[serde(rename = "m")]
    Metre,
    /// Shares of the removal, displayed in percent.
    #[serde(rename = "1")]
    Share,
}

impl ErrorUnit {
    /// Number of display units in one unit (1e6 for metres).
    pub fn per_one(self) -> f64 {
        match self {
            Self::Metre => 1e6,
            Self::Share => 100.0,
        }
    }

    /// Symbol of the display unit.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Metre => "µm",
            Self::Share => "%",
        }
    }

    /// Formats an error in the display unit, to two decimals.
    pub fn shown(self, error: f64) -> String {
        format!("{:.2} {}", error * self.per_one(), self.symbol())
    }
}

/// Agreement of a model with one scan or one table.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Agreement {
    /// Display name of the data.
    pub about: String,
    /// Root mean square of measured minus simulated over the region that the tool may have touched: heights [m],
    /// distances of the exposed border [m], or logarithms of removal [1].
    pub rms: f64,
    /// Resolution of the instrument: its noise, or half a pixel for a mask, which only shows the side of a border on
    /// which each pixel lies.
    pub floor: f64,
    /// Residual of a perfect model from random errors alone.
    pub noise: f64,
    /// Mean removal, in the same unit: the reference for relative errors.
    pub scale: f64,
    /// Smooth error of the simulation itself, in the same unit.
    #[serde(default)]
    pub smooth_error: f64,
}

/// Data of a campaign that a model can predict repeatedly.
pub trait Evidence: Sync {
    /// The process: grinding or sanding.
    fn process(&self) -> Process;

    /// Number of rows for models with a parameter per pass or scan.
    fn rows(&self) -> RowCounts;

    /// Measured minus predicted, whitened: independent with variance one where the model is right.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError>;

    /// The same data with a faster, approximate prediction; `None` if there is none.
    fn quicker(&self) -> Option<Box<dyn Totals + '_>> {
        None
    }

    /// Agreement of a model with each scan of a split.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError>;

    /// Unit of the errors.
    fn unit(&self) -> ErrorUnit {
        ErrorUnit::Metre
    }

    /// Returns a model with the bounds and reference values that these data need for its effects.
    fn adapted(&self, model: Model, _library: &Library) -> Model {
        model
    }

    /// Coordinates of the parameters that a fit to these data varies.
    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        Coordinate::of(model, |_| true)
    }

    /// Root mean square change of the calibration data, in the unit of [`Agreement::rms`], that corresponds to a change
    /// of the whitened residuals; nuisance degrees of freedom absorb what they can.
    fn size(&self, change: &[f64]) -> f64;

    /// Measured change of the removal between equal successive passes, and the changes that a law can produce; `None`
    /// without equal passes.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError>;

    /// Reason for which an effect cannot show in these data, if any.
    fn is_blind_to(&self, effect: &Effect) -> Option<String>;

    /// Statement that the data do not depend on what a law depends on, so that no effect can be named from them; `None`
    /// if they do, or cannot tell.
    fn unrelated(&self) -> Option<String> {
        None
    }

    /// Number of conditions among the calibration data that a model distinguishes, less the nuisance degrees of
    /// freedom: a model with as many parameters fits any measurement.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn conditions(&self, _model: &CompiledModel) -> Result<usize, EvidenceError> {
        Ok(usize::MAX)
    }

    /// Name of the family of an effect. Forms of one dependence are a family, named after its first form. A model holds
    /// at most one form of a family.
    fn family(&self, effect: &str) -> String {
        effect.to_owned()
    }

    /// Sentence on an effect that was found, where its name does not describe it.
    fn words(&self, _effect: &EffectSummary) -> Option<String> {
        None
    }

    /// Block number of each residual; residuals of a block are neighbours that may be correlated.
    fn blocks(&self, split: Split) -> Vec<usize>;

    /// Fold number of each calibration residual; a model must predict each fold from the others.
    fn folds(&self) -> Vec<usize> {
        self.blocks(Split::Calibration)
    }

    /// As [`Self::folds`], with whole passes as folds where there are several.
    fn pass_folds(&self) -> Vec<usize> {
        self.folds()
    }

    /// Change of the calibration residuals per unit of each closure term, shape [data, columns]. A table has no
    /// closure: each of its columns has an effect.
    fn closure(&self) -> DMatrix<f64> {
        DMatrix::zeros(self.folds().len(), 0)
    }

    /// Change of the calibration residuals per standard deviation of each term of the simulation's smooth error, shape
    /// [data, terms]; no terms for a table, which is not simulated.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn smooth_errors(&self, _model: &CompiledModel) -> Result<DMatrix<f64>, EvidenceError> {
        Ok(DMatrix::zeros(self.folds().len(), 0))
    }

    /// Linear response of the calibration data to changes over each variable, at a fitted model; empty if the evidence
    /// has no such variables.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn bases(&self, _model: (&Model, &Fit), _library: &Library) -> Result<Vec<Basis>, EvidenceError> {
        Ok(Vec::new())
    }

    /// Frame offset of the logs beside a fitted model; `None` if the evidence has no logs, or none that were moved.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn frame(&self, _fit: &Fit) -> Result<Option<FrameEstimate>, EvidenceError> {
        Ok(None)
    }

    /// Contribution of the lattice error to the calibration residuals before it is absorbed as a degree of freedom;
    /// empty if it is unknown.
    fn lattice_field(&self) -> Vec<f64> {
        Vec::new()
    }
}
