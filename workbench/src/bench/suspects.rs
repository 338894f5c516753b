//! Effects that a search has scored, from this page or from a study of the same measurements.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Suspects, the likeliest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Suspects {
    /// Where they come from, in a few words.
    pub(super) source: String,
    /// What the search says in a sentence.
    pub(super) sentence: String,
    /// Unit of the errors.
    pub(super) unit: String,
    /// Probability that none of the library is the cause.
    pub(super) none: f64,
    /// One line each.
    pub(super) rows: Vec<Row>,
}

/// An effect that was scored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    name: String,
    title: String,
    probability: f64,
    delta_chi2: f64,
    /// Error of held-out passes without and with it.
    #[serde(default)]
    evaluation_rms_um_before: Option<f64>,
    #[serde(default)]
    evaluation_rms_um_after: Option<f64>,
    #[serde(default)]
    ruled_out: Option<String>,
    #[serde(default)]
    indistinguishable_from: Vec<String>,
}

/// What of a diagnosis is needed.
#[derive(Deserialize)]
struct Diagnosis {
    sentence: String,
    none_probability: f64,
    error_unit: lab::ErrorUnit,
    suspects: Vec<Row>,
}

impl Suspects {
    /// The suspects of a diagnosis as `diagnose --json` writes it; `None` of another value.
    pub(super) fn of(source: String, diagnosis: &Value) -> Option<Self> {
        let Diagnosis { sentence, none_probability, error_unit, mut suspects } =
            Diagnosis::deserialize(diagnosis).ok()?;
        suspects.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(b.delta_chi2.total_cmp(&a.delta_chi2)));
        let unit = error_unit.symbol().to_owned();
        Some(Self { source, sentence, unit, none: none_probability, rows: suspects })
    }
}
