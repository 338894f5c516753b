//! A parameter fixed by its slider, in a model's text and on the page.

use std::time::Instant;

use effects::{CompiledModel, Model};
use lab::{Fit, LabError, Result};

use super::engine::Engine;
use super::shared::FixedParameter;

/// A free parameter and the value at which it is fixed.
pub(super) struct SliderSetting {
    /// Index among the fitted coordinates.
    pub(super) place: usize,
    /// Value [SI].
    pub(super) value: f64,
    name: String,
}

impl SliderSetting {
    /// Finds a free parameter by name and converts its value from the displayed unit; clamps it to its range.
    ///
    /// # Errors
    /// If the model has no such free parameter, or the value is not a finite number.
    pub(super) fn new(fit: &Fit, name: &str, value: f64) -> Result<Self> {
        let place = fit.coordinates.iter().position(|coordinate| coordinate.slot.name() == name);
        let known = || fit.coordinates.iter().map(|c| c.slot.name()).collect::<Vec<_>>().join(", ");
        let Some(place) = place.filter(|_| value.is_finite()) else {
            return Err(LabError::Refused(format!(
                "{name} = {value}: a number for one of these is accepted: {}",
                known()
            )));
        };
        let coordinate = &fit.coordinates[place];
        let [least, greatest] = coordinate.reach();
        let value = coordinate.slot.unit.to_si(value).clamp(least, greatest);
        Ok(Self { place, value, name: name.to_owned() })
    }

    /// Returns the model with the parameter fixed at this value.
    pub(super) fn in_model(&self, model: &Model, fit: &Fit) -> Model {
        let own = &fit.coordinates[self.place].slot;
        let is_own = |k: &usize| {
            let slot = &fit.model.parameters()[*k];
            (&slot.owner, &slot.parameter) == (&own.owner, &own.parameter)
        };
        let rows = (0..fit.model.parameters().len()).filter(is_own);
        let values: Vec<f64> = rows
            .map(|k| if k == fit.coordinates[self.place].index { self.value } else { fit.model.value(k) })
            .collect();
        let mut held = model.clone();
        held.set(&own.owner, &own.parameter, &values);
        let path = |c: &lab::Coordinate| format!("{}.{}", c.slot.owner, c.slot.parameter);
        let mut free: Vec<String> =
            fit.coordinates.iter().map(path).filter(|p| *p != path(&fit.coordinates[self.place])).collect();
        free.dedup();
        held.free = Some(free);
        held
    }

    /// Returns the value in the displayed unit.
    pub(super) fn shown(&self, fit: &Fit) -> f64 {
        fit.coordinates[self.place].slot.unit.from_si(self.value)
    }

    /// Collects the response of the other parameters for the page.
    pub(super) fn held(&self, engine: &Engine, (fit, rms): (&Fit, Option<f64>), since: Instant) -> FixedParameter {
        let value = |model: &CompiledModel, c: &lab::Coordinate| {
            let number = c.slot.unit.from_si(model.value(c.index));
            format!("{} {}", four_digits(number), study::with_raised_powers(&c.slot.unit_text)).trim_end().to_owned()
        };
        let others = fit.coordinates.iter().map(|c| (c.slot.name(), value(&fit.model, c))).collect();
        FixedParameter {
            parameter: self.name.clone(),
            value: self.shown(engine.fit()),
            chi2: [fit.chi2, engine.fit().chi2],
            others,
            rms,
            seconds: since.elapsed().as_secs_f64(),
        }
    }
}

/// Formats a number with four significant digits.
pub(super) fn four_digits(number: f64) -> String {
    if number == 0.0 || !number.is_finite() {
        return number.to_string();
    }
    let power = number.abs().log10().floor() as i32;
    if (-4..6).contains(&power) { format!("{number:.*}", (3 - power).max(0) as usize) } else { format!("{number:.3e}") }
}

#[cfg(test)]
mod tests {
    use super::four_digits;

    #[test]
    fn four_digits_are_shown_of_large_and_small_numbers() {
        let shown = [350.04, 0.012344, -1.0, 1.23456e9, 0.0].map(four_digits);
        assert_eq!(shown, ["350.0", "0.01234", "-1.000", "1.235e9", "0"]);
    }
}
