//! Sizes of hidden effects: a fixed ladder of physical sizes, independent of the detectable size.

use effects::{Effect, Library, Parameter, Process, Rows};
use serde::{Deserialize, Serialize};

use virtual_lab::{Hidden, Size, visible_value};

/// Rungs of single effects relative to the visible size, in the order in which successive rounds through the library
/// use them.
pub const RUNGS: [f64; 4] = [1.0, 0.5, 2.0, 0.25];
/// Rungs of the effects whose detectable size is measured.
pub const POWER_RUNGS: [f64; 6] = [1.0, 0.5, 0.25, 2.0, 0.125, 0.75];

/// A parameter's value at a rung.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rung {
    /// The parameter.
    pub parameter: String,
    /// Its value in `unit`.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// Values at a multiple of the visible size of an effect: for each parameter with a null, the distance from the null is
/// multiplied by the factor, or the value is divided by it if the null is infinite, and clamped to the range.
pub fn rung(effect: &Effect, (process, size): (Process, Size), factor: f64) -> Vec<Rung> {
    let own = effect.parameters.iter().filter(|parameter| parameter.per == Rows::Model);
    let value = |parameter: &Parameter| {
        let (null, visible) = (parameter.null?, visible_value(&effect.name, parameter, process, size));
        let [low, high] = parameter.range.of(process);
        let wanted = if null.is_infinite() { visible / factor } else { null + factor * (visible - null) };
        (visible != null).then(|| wanted.clamp(low.min(visible), high.max(visible)))
    };
    let rung = |parameter: &Parameter| {
        let shown = format!("{:.3e}", parameter.unit.from_si(value(parameter)?));
        let value = shown.parse().unwrap_or_default();
        Some(Rung { parameter: parameter.name.clone(), value, unit: parameter.unit_text.clone() })
    };
    own.filter_map(rung).collect()
}

/// An effect to hide at a rung; at the first rung it has the laboratory's default size.
pub(super) fn hidden(name: &str, at: (Process, Size), factor: f64, library: &Library) -> Hidden {
    let Some(effect) = library.find(name).filter(|_| factor != 1.0) else { return Hidden::effect(name) };
    let with = |hidden: Hidden, rung: &Rung| {
        let unit = if rung.unit == "1" { "" } else { &rung.unit };
        hidden.with(&rung.parameter, format!("{} {unit}", rung.value).trim())
    };
    rung(effect, at, factor).iter().fold(Hidden::effect(name), with)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(name: &str, factor: f64) -> Vec<f64> {
        let effect = Library::builtin().find(name).expect("an effect of the library");
        rung(effect, (Process::Grinding, Size::Small), factor).iter().map(|rung| rung.value).collect()
    }

    #[test]
    fn a_rung_is_a_multiple_of_the_visible_departure_from_the_null() {
        assert_eq!(values("tool-tilt", 0.5), [6.0], "12 mrad are visible");
        assert_eq!(values("tool-tilt", 2.0), [24.0]);
        assert_eq!(values("pressure-exponent", 0.5), [0.8], "halfway from 1 to 0.6");
        assert_eq!(values("grit-dulling", 0.5), [200.0], "the null of 100 mm³ is infinity");
        assert_eq!(values("material-grindability", 2.0), [0.4]);
    }

    #[test]
    fn every_effect_has_a_size_that_grows_from_rung_to_rung() {
        let library = Library::builtin();
        for effect in library.effects().iter().filter(|effect| effect.acts_in(effects::Process::Grinding)) {
            let rows = |factor: f64| rung(effect, (Process::Grinding, Size::Small), factor);
            let is_per_pass = effect.parameters.iter().any(|parameter| parameter.per != Rows::Model);
            assert!(is_per_pass || !rows(1.0).is_empty(), "{}", effect.name);
            let grows = rows(0.25).iter().zip(rows(1.0)).all(|(small, large)| small.value != large.value);
            assert!(grows, "{}: {:?} and {:?}", effect.name, rows(0.25), rows(1.0));
        }
    }
}
