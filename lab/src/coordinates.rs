//! The numbers that a fit varies: parameters on scales on which steps of about one are large.

use effects::{CompiledModel, ParameterSlot, Scale};

use crate::criteria::BOUND_SHARE;

/// A parameter as a fit varies it: the logarithm of its value, or its value over the width of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Place among the model's parameters.
    pub index: usize,
    /// The parameter.
    pub slot: ParameterSlot,
}

/// On which bound a value lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bound {
    /// The least value.
    Least,
    /// The greatest value.
    Greatest,
}

impl Coordinate {
    /// The free parameters of a model for which `takes` holds.
    pub fn of(model: &CompiledModel, takes: impl Fn(&ParameterSlot) -> bool) -> Vec<Self> {
        let slots = model.parameters().iter().cloned().enumerate();
        slots.filter(|(_, slot)| slot.free && takes(slot)).map(|(index, slot)| Self { index, slot }).collect()
    }

    /// From a value [SI] to the coordinate.
    pub fn from_value(&self, value: f64) -> f64 {
        match self.slot.scale {
            Scale::Log => value.ln(),
            Scale::Linear => value / self.width(),
        }
    }

    /// From the coordinate to a value [SI].
    pub fn value(&self, at: f64) -> f64 {
        match self.slot.scale {
            Scale::Log => at.exp(),
            Scale::Linear => at * self.width(),
        }
    }

    /// Least and greatest coordinate.
    pub fn bounds(&self) -> [f64; 2] {
        self.slot.range.map(|value| self.from_value(value))
    }

    /// The nearest coordinate within the bounds.
    pub fn clamped(&self, at: f64) -> f64 {
        let [least, greatest] = self.bounds();
        at.clamp(least, greatest)
    }

    /// The bound on which a coordinate lies.
    pub fn bound(&self, at: f64) -> Option<Bound> {
        let [least, greatest] = self.bounds();
        let near = BOUND_SHARE * (greatest - least);
        if at <= least + near {
            return Some(Bound::Least);
        }
        (at >= greatest - near).then_some(Bound::Greatest)
    }

    /// First step of a finite difference.
    pub fn step(&self) -> f64 {
        match self.slot.scale {
            Scale::Log => 0.05,
            Scale::Linear => 0.01,
        }
    }

    fn width(&self) -> f64 {
        self.slot.range[1] - self.slot.range[0]
    }
}

/// A copy of a model with coordinates set.
pub fn moved(model: &CompiledModel, coordinates: &[Coordinate], at: &[f64]) -> CompiledModel {
    let mut model = model.clone();
    for (coordinate, &at) in coordinates.iter().zip(at) {
        model.set(coordinate.index, coordinate.value(at));
    }
    model
}
