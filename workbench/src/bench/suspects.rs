//! Effects scored by a search, from this page or from a study of the same measurements.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Scored effects, the most probable first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Suspects {
    /// Origin in a few words: a search or a study.
    pub(super) source: String,
    /// Conclusion of the search as a sentence.
    pub(super) sentence: String,
    /// Unit of the errors.
    pub(super) unit: String,
    /// Posterior probability that no effect of the library is the cause.
    pub(super) none: f64,
    /// One row for each effect.
    pub(super) rows: Vec<Row>,
    /// The trial that would decide, if one is proposed.
    #[serde(default)]
    plan: Option<Plan>,
}

/// A proposed trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Plan {
    /// Sentence that says what to do.
    summary: String,
    /// Address of its files; `None` if they are not below the served folder.
    #[serde(default)]
    address: Option<String>,
}

/// A scored effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    name: String,
    title: String,
    probability: f64,
    delta_chi2: f64,
    /// Root mean square error of the held-out passes without the effect and with it; in [`Suspects::unit`] once read.
    #[serde(default)]
    evaluation_rms_before: Option<f64>,
    #[serde(default)]
    evaluation_rms_after: Option<f64>,
    #[serde(default)]
    ruled_out: Option<String>,
    #[serde(default)]
    indistinguishable_from: Vec<String>,
}

/// The parts of a diagnosis that the page shows.
#[derive(Deserialize)]
struct Diagnosis {
    sentence: String,
    none_probability: f64,
    error_unit: lab::ErrorUnit,
    suspects: Vec<Row>,
    #[serde(default)]
    next_trial: Option<Plan>,
}

impl Suspects {
    /// Reads the suspects from a diagnosis written by `diagnose --json`; `None` if the value has another form.
    pub(super) fn of(source: String, diagnosis: &Value) -> Option<Self> {
        let Diagnosis { sentence, none_probability, error_unit, mut suspects, next_trial } =
            Diagnosis::deserialize(diagnosis).ok()?;
        suspects.sort_by(|a, b| b.probability.total_cmp(&a.probability).then(b.delta_chi2.total_cmp(&a.delta_chi2)));
        for row in &mut suspects {
            for error in [&mut row.evaluation_rms_before, &mut row.evaluation_rms_after].into_iter().flatten() {
                *error *= error_unit.per_one();
            }
        }
        let unit = error_unit.symbol().to_owned();
        Some(Self { source, sentence, unit, none: none_probability, rows: suspects, plan: next_trial })
    }

    /// Adds the address of the files of the proposed trial.
    pub(super) fn with_files(mut self, address: String) -> Self {
        self.plan.iter_mut().for_each(|plan| plan.address = Some(address.clone()));
        self
    }
}
