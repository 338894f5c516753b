//! A model that was fitted: its numbers and pages, and where it is simulated also its fields.

use std::sync::{Arc, Mutex, PoisonError};

use lab::{CalibrationSummary, Coordinate, Fit};
use report::study::Sections;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::live::Live;

/// A model that was fitted.
pub(crate) struct Stage {
    /// What is kept of it.
    pub(crate) record: Record,
    /// Its pages.
    pub(crate) sections: Sections,
    live: Mutex<Option<Arc<Live>>>,
}

/// What is kept of a model.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Record {
    /// From 1.
    pub(crate) number: usize,
    /// What it adds to the one before, such as `+ grit-dulling`.
    pub(crate) label: String,
    /// The one before.
    pub(crate) before: Option<usize>,
    /// Command lines that make it from that one.
    pub(crate) commands: Vec<String>,
    /// Its errors.
    pub(crate) errors: Errors,
    /// Names of its effects.
    pub(crate) effects: Vec<String>,
    /// Its free parameters.
    pub(crate) sliders: Vec<Slider>,
}

/// How far a model is from the measurements.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Errors {
    /// For people.
    pub(crate) unit: String,
    /// Root mean square over the passes that were fitted.
    pub(crate) calibration: f64,
    /// Over the passes that were held out.
    pub(crate) held_out: Option<f64>,
    /// What noise alone leaves.
    pub(crate) floor: f64,
    /// Robust sum of squares.
    pub(crate) chi2: f64,
    /// Data less free parameters.
    pub(crate) degrees_of_freedom: usize,
}

/// A free parameter with the values that it may have, in the unit that is shown.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Slider {
    /// With its owner.
    pub(crate) name: String,
    /// For people.
    pub(crate) unit: String,
    /// As it was fitted.
    pub(crate) value: f64,
    /// Least and greatest.
    pub(crate) range: [f64; 2],
    /// Whether even ratios are even steps.
    pub(crate) is_log: bool,
}

impl Errors {
    /// The errors of a calibration's last model.
    pub(super) fn of(summary: &CalibrationSummary) -> Self {
        let last = summary.waterfall.last();
        Self {
            unit: summary.error_unit.symbol().to_owned(),
            calibration: last.map_or(f64::NAN, |step| step.calibration_rms_um),
            held_out: last.and_then(|step| step.evaluation_rms_um),
            floor: summary.noise_floor_um,
            chi2: summary.chi2,
            degrees_of_freedom: summary.degrees_of_freedom,
        }
    }
}

impl Slider {
    /// The free parameters of a fit.
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
    /// What the page shows of it in a list.
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
    /// A model with its pages.
    pub(super) fn new(record: Record, sections: Sections, live: Option<Arc<Live>>) -> Self {
        Self { record, sections, live: Mutex::new(live) }
    }

    /// Its fields and maps, where it was simulated in this run of the program.
    pub(crate) fn live(&self) -> Option<Arc<Live>> {
        self.live.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Keeps or forgets its fields and maps.
    pub(super) fn set_live(&self, live: Option<Arc<Live>>) {
        *self.live.lock().unwrap_or_else(PoisonError::into_inner) = live;
    }
}
