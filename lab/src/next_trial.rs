//! A proposed trial or row of a table. The crate `experiments` chooses it.

use serde::Serialize;

use trials::trial::Trial;

/// A proposed trial.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NextTrial {
    /// Description of the trial.
    pub summary: String,
    /// Force of each pass [N].
    pub force_n: Vec<f64>,
    /// Feed of each pass [mm/s].
    pub feed_mm_s: Vec<f64>,
    /// Spindle speed of each pass [rpm].
    pub spindle_rpm: Vec<f64>,
    /// Hypotheses that it would distinguish, most probable first; or the one effect whose prediction it would test.
    pub separates: Vec<String>,
    /// Expected difference of χ² between the first two; for one effect, between the models with and without it.
    pub expected_delta_chi2: f64,
    /// Lower bound of the expected probability that the most probable hypothesis is right afterwards.
    pub probability_right: f64,
    /// Cost, expected information and alternatives from the menu; absent for tables.
    #[serde(flatten)]
    pub choice: Option<MenuChoice>,
}

/// A trial chosen from a menu.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MenuChoice {
    /// Cost and information of the trial.
    #[serde(flatten)]
    pub worth: Worth,
    /// Box and Hill's discrimination [nat].
    pub discrimination_nats: f64,
    /// Entropy of the present probabilities: the most information that any trial can give [nat].
    pub entropy_nats: f64,
    /// Number of trials on the menu that could be simulated.
    pub menu: usize,
    /// The next best trials of the menu.
    pub runners_up: Vec<MenuLine>,
    /// The trial that would follow it; absent where it is expected to settle the question.
    pub then: Option<MenuLine>,
    /// Number of scans of each surface that are averaged.
    pub scans_per_surface: usize,
    /// The trial without its scans; two trials if the tool is dressed in between.
    #[serde(skip)]
    pub plan: Vec<Trial>,
}

/// Cost and information of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Worth {
    /// Expected time [min].
    pub minutes: f64,
    /// Number of new workpieces.
    pub workpieces: usize,
    /// Lower bound of the expected fall of the entropy of the probabilities [nat].
    pub expected_information_nats: f64,
    /// The same per minute.
    pub nats_per_minute: f64,
}

/// One trial of the menu.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MenuLine {
    /// Difference from the trial that was made.
    pub summary: String,
    /// Cost and information.
    #[serde(flatten)]
    pub worth: Worth,
}
