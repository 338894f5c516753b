//! What a model is held against, whatever the data are.

use sim::effect::{CompiledModel, Process, RowCounts, RunError};
use thiserror::Error;

use crate::campaign_twin::CampaignError;

/// Which data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Split {
    /// Data that fits may see.
    Calibration,
    /// Data kept apart: no fit and no choice sees them.
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

    /// For each residual the number of its block: neighbours that may still depend on each other.
    fn blocks(&self, split: Split) -> Vec<usize>;
}
