//! Quantities measured along a pass, for formulas. A state of the tool with the same name and no dynamics of its own
//! follows them; so does the logged temperature.

use effects::{CompiledModel, Dimension, States, StepValues, Variable};

/// Name of the quantity that [`Variable::TemperatureLogged`] reads.
const TEMPERATURE: &str = "temperature";

/// A measured quantity along a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Its name in formulas.
    pub name: String,
    /// Its unit.
    pub dimension: Dimension,
    /// Times since the pass began [s], increasing.
    pub times: Vec<f64>,
    /// Its value at each [SI].
    pub values: Vec<f64>,
}

impl Measured {
    /// Its value at a time [s], linear between the values and constant beyond the ends; NaN without values.
    pub fn at(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|at| *at <= time);
        let value = |at: usize| self.values.get(at).copied();
        match (after.checked_sub(1).and_then(value), value(after)) {
            (Some(low), Some(high)) => {
                let [begin, end] = [self.times[after - 1], self.times[after]];
                low + (high - low) * (time - begin) / (end - begin)
            }
            (low, high) => low.or(high).unwrap_or(f64::NAN),
        }
    }

    /// True if its value is constant.
    pub fn is_constant(&self) -> bool {
        self.values.windows(2).all(|pair| pair[0] == pair[1])
    }
}

/// The measured quantities that a model reads.
#[derive(Clone, Debug, Default)]
pub(crate) struct Readings<'a> {
    /// States by their index among those of the tool.
    states: Vec<(usize, &'a Measured)>,
    temperature: Option<&'a Measured>,
}

impl<'a> Readings<'a> {
    pub(crate) fn new(model: &CompiledModel, measured: &'a [Measured]) -> Self {
        let state = |(place, (_, state)): (usize, (&effects::Effect, &effects::State))| {
            let is_own = |own: &&Measured| own.name == state.name && own.dimension == state.unit.dimension;
            Some((place, measured.iter().find(is_own).filter(|_| state.is_held())?))
        };
        let temperature = measured.iter().find(|own| own.name == TEMPERATURE).filter(|_| reads_temperature(model));
        Self { states: model.tool_states().enumerate().filter_map(state).collect(), temperature }
    }

    /// Sets states of the tool to the measured values at a time since the pass began [s].
    pub(crate) fn set_states(&self, model: &CompiledModel, time: f64, states: &mut States) {
        for (place, measured) in &self.states {
            states.measure(model, *place, measured.at(time));
        }
    }

    /// Sets the step's other variables to the measured values at a time since the pass began [s].
    pub(crate) fn set_step(&self, time: f64, step: &mut StepValues) {
        if let Some(temperature) = self.temperature {
            step.set(Variable::TemperatureLogged, temperature.at(time));
        }
    }

    /// The first quantity that changes during the pass.
    pub(crate) fn changing(&self) -> Option<&'a Measured> {
        let states = self.states.iter().map(|(_, measured)| *measured);
        states.chain(self.temperature).find(|measured| !measured.is_constant())
    }
}

fn reads_temperature(model: &CompiledModel) -> bool {
    let mut formulas = model.effects().flat_map(|effect| effect.formulas());
    let name = Variable::TemperatureLogged.name();
    formulas.any(|formula| formula.tree.names().iter().any(|(own, _)| *own == name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantity_is_straight_between_its_values_and_held_at_the_ends() {
        let of = |times: &[f64], values: &[f64]| Measured {
            name: "humidity".to_owned(),
            dimension: Dimension::NONE,
            times: times.to_vec(),
            values: values.to_vec(),
        };
        let measured = of(&[0.0, 1.0, 3.0], &[2.0, 4.0, 0.0]);
        for (time, value) in [(-1.0, 2.0), (0.0, 2.0), (0.5, 3.0), (1.0, 4.0), (2.0, 2.0), (3.0, 0.0), (9.0, 0.0)] {
            assert_eq!(measured.at(time), value, "{time}");
        }
        assert!(!measured.is_constant() && of(&[0.0], &[7.0]).is_constant());
        assert_eq!(of(&[0.0], &[7.0]).at(5.0), 7.0);
        assert!(of(&[], &[]).at(0.0).is_nan());
    }
}
