//! What a model is held against, whatever the data are.

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

/// Which data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Data that fits may see.
    Calibration,
    /// Data kept apart: no fit sees them, and what a fit found must hold on them.
    Evaluation,
}

/// Why data cannot be compared with a model.
#[derive(Debug, Error)]
pub enum EvidenceError {
    /// The model cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] CampaignError),
    /// A formula of the scanner.
    #[error("a simulated scan: {0}")]
    Scan(#[from] RunError),
    /// There is nothing to compare with.
    #[error("{0}")]
    NoData(String),
}

/// In what the errors of data are told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum ErrorUnit {
    /// Micrometres.
    #[default]
    #[serde(rename = "um")]
    Micrometre,
    /// Hundredths of what was removed.
    #[serde(rename = "percent")]
    Percent,
}

impl ErrorUnit {
    /// Its size in the data's own unit, turned upside down.
    pub fn per_one(self) -> f64 {
        match self {
            Self::Micrometre => 1e6,
            Self::Percent => 100.0,
        }
    }

    /// For people.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Micrometre => "µm",
            Self::Percent => "%",
        }
    }
}

/// How well a model describes one scan, or one table.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Agreement {
    /// Which data, for people.
    pub about: String,
    /// Root mean square of measured minus simulated over what the tool may have touched: heights [m], distances of the
    /// border of what is exposed [m], or logarithms of removal [1].
    pub rms: f64,
    /// What the instrument tells apart: its noise, or half a pixel where it shows no more than which side of a border each is on.
    pub floor: f64,
    /// What random errors alone leave of a perfect model.
    pub noise: f64,
    /// Mean of what was removed, in the same unit; what small errors are small against.
    pub scale: f64,
    /// Smooth error that the simulation itself may have, in the same unit.
    #[serde(default)]
    pub smooth_error: f64,
}

/// Data of a campaign, which can be predicted with a model again and again.
pub trait Evidence: Sync {
    /// What the tool does.
    fn process(&self) -> Process;

    /// Rows that a model needs which has a parameter for each pass or scan.
    fn rows(&self) -> RowCounts;

    /// Measured minus predicted, whitened: independent with variance one where the model is right.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError>;

    /// The same data, predicted quicker and nearly as well; `None` where there is no quicker way.
    fn quicker(&self) -> Option<Box<dyn Totals + '_>> {
        None
    }

    /// How well a model describes each scan of a split.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    fn agreement(&self, model: &CompiledModel, split: Split) -> Result<Vec<Agreement>, EvidenceError>;

    /// In what errors are told.
    fn unit(&self) -> ErrorUnit {
        ErrorUnit::Micrometre
    }

    /// A model with the bounds and reference values that these data need for its effects.
    fn adapted(&self, model: Model, _library: &Library) -> Model {
        model
    }

    /// The parameters of a model that a fit to these data varies.
    fn coordinates(&self, model: &CompiledModel) -> Vec<Coordinate> {
        Coordinate::of(model, |_| true)
    }

    /// Root mean square of the change of the calibration data, in the unit of [`Agreement::rms`], behind a change of the whitened
    /// residuals; measurement degrees of freedom take up what they can.
    fn size(&self, change: &[f64]) -> f64;

    /// How the removal changes from a pass to an equal one after it, and what a law can make of that; `None` where there
    /// are no equal passes.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    fn trend(&self, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError>;

    /// Why an effect cannot show in these data, if so.
    fn is_blind_to(&self, effect: &Effect) -> Option<String>;

    /// Conditions among the calibration data that a model tells apart, less what measurement leaves free: a model with as
    /// many parameters fits whatever was measured.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    fn conditions(&self, _model: &CompiledModel) -> Result<usize, EvidenceError> {
        Ok(usize::MAX)
    }

    /// Name of the family of an effect: forms of one dependence have one, by the name of its first form. Only one form of a
    /// family is part of a model.
    fn family(&self, effect: &str) -> String {
        effect.to_owned()
    }

    /// What an effect that was found says of these data, where its name does not; one sentence.
    fn words(&self, _effect: &EffectSummary) -> Option<String> {
        None
    }

    /// For each residual the number of its block: neighbours that may still depend on each other.
    fn blocks(&self, split: Split) -> Vec<usize>;

    /// For each residual of the calibration data the number of its fold: what a model must predict from all the others.
    fn folds(&self) -> Vec<usize> {
        self.blocks(Split::Calibration)
    }

    /// As [`Self::folds`], each fold a whole pass where there are several.
    fn pass_folds(&self) -> Vec<usize> {
        self.folds()
    }

    /// Change of the calibration residuals per unit of each term of the closure, shape [data, columns]. A table has no
    /// closure: each of its columns has an effect.
    fn closure(&self) -> DMatrix<f64> {
        DMatrix::zeros(self.folds().len(), 0)
    }

    /// Change of the calibration residuals by each term of the smooth error that the simulation of a model itself may have, by
    /// one standard deviation, shape [data, terms]. A table is not simulated.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    fn smooth_errors(&self, _model: &CompiledModel) -> Result<DMatrix<f64>, EvidenceError> {
        Ok(DMatrix::zeros(self.folds().len(), 0))
    }

    /// Linear response of the calibration data to changes over each variable, at a fitted model; none where the evidence has no
    /// such variables.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    fn bases(&self, _model: (&Model, &Fit), _library: &Library) -> Result<Vec<Basis>, EvidenceError> {
        Ok(Vec::new())
    }

    /// Where the logs lie in the frame of the scans beside a fitted model; `None` where the evidence has no logs, or none that
    /// were moved.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    fn frame(&self, _fit: &Fit) -> Result<Option<FrameEstimate>, EvidenceError> {
        Ok(None)
    }

    /// What the error of the simulation's lattice adds to the residuals of the calibration data before it is taken out of
    /// them as a degree of freedom; nothing where it is not known.
    fn lattice_field(&self) -> Vec<f64> {
        Vec::new()
    }
}
