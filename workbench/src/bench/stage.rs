//! A fitted model: its numbers and report sections, and its fields if it was simulated in this run.

use std::sync::{Arc, Mutex, PoisonError};

use lab::{CalibrationSummary, Coordinate, Fit};
use report::study::Sections;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::live::Live;

/// A fitted model.
pub(crate) struct Stage {
    /// Saved numbers of the model.
    pub(crate) record: Record,
    /// Sections of its report.
    pub(crate) sections: Sections,
    live: Mutex<Option<Arc<Live>>>,
}

/// Saved numbers of a fitted model.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Number of the model, from 1.
    pub(crate) number: usize,
    /// Change from the previous model, such as `+ grit-dulling`.
    pub(crate) label: String,
    /// Number of the previous model.
    pub(crate) before: Option<usize>,
    /// Command lines that make it from the previous model.
    pub(crate) commands: Vec<String>,
    /// Errors of the model.
    pub(crate) errors: Errors,
    /// Names of the effects in the model.
    pub(crate) effects: Vec<String>,
    /// Free parameters of the model.
    pub(crate) sliders: Vec<Slider>,
}

/// Errors of a model against the measurements.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Errors {
    /// Unit symbol of the errors.
    pub(crate) unit: String,
    /// Root mean square error over the calibration passes.
    pub(crate) calibration: f64,
    /// Root mean square error over the held-out passes.
    pub(crate) held_out: Option<f64>,
    /// Noise floor.
    pub(crate) floor: f64,
    /// Robust sum of squared residuals.
    pub(crate) chi2: f64,
    /// Number of data minus number of free parameters.
    pub(crate) degrees_of_freedom: usize,
}

/// A free parameter with its range, in the displayed unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Slider {
    /// Name with its owner.
    pub(crate) name: String,
    /// Unit symbol.
    pub(crate) unit: String,
    /// Fitted value.
    pub(crate) value: f64,
    /// Lower and upper bound.
    pub(crate) range: [f64; 2],
    /// True if the slider's scale is logarithmic.
    pub(crate) is_log: bool,
}

impl Errors {
    /// Takes the errors of a calibration's last model.
    pub(super) fn of(summary: &CalibrationSummary) -> Self {
        let (last, unit) = (summary.waterfall.last(), summary.error_unit);
        let shown = |error: f64| error * unit.per_one();
        Self {
            unit: unit.symbol().to_owned(),
            calibration: last.map_or(f64::NAN, |step| shown(step.calibration_rms)),
            held_out: last.and_then(|step| step.evaluation_rms).map(shown),
            floor: shown(summary.noise_floor),
            chi2: summary.chi2,
            degrees_of_freedom: summary.degrees_of_freedom,
        }
    }
}

impl Slider {
    /// Lists the free parameters of a fit.
    pub(super) fn all(fit: &Fit) -> Vec<Self> {
        let slider = |(coordinate, at): (&Coordinate, &f64)| {
            let shown = |value: f64| coordinate.slot.unit.from_si(value);
            Self {
                name: coordinate.slot.name(),
                unit: study::with_raised_powers(&coordinate.slot.unit_text),
                value: shown(coordinate.value(*at)),
                range: coordinate.reach().map(shown),
                is_log: coordinate.slot.scale == effects::Scale::Log,
            }
        };
        fit.coordinates.iter().zip(&fit.at).map(slider).collect()
    }
}

impl Record {
    /// Returns the entry of the page's list of models.
    pub(super) fn to_json(&self) -> Value {
        json!({
            "number": self.number,
            "label": self.label,
            "before": self.before,
            "commands": self.commands,
            "errors": self.errors,
            "effects": self.effects,
        })
    }
}

impl Stage {
    /// Makes a stage of a fitted model.
    pub(super) fn new(record: Record, sections: Sections, live: Option<Arc<Live>>) -> Self {
        Self { record, sections, live: Mutex::new(live) }
    }

    /// Returns the fields and maps; `None` if the model was not simulated in this run.
    pub(crate) fn live(&self) -> Option<Arc<Live>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Stores or drops the fields and maps.
    pub(super) fn set_live(&self, live: Option<Arc<Live>>) {
        *self.live.lock().unwrap_or_else(PoisonError::into_inner) = live;
    }
}
