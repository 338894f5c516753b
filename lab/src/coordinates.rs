//! The numbers that a fit varies: parameters on scales on which steps of about one are large.

use effects::{CompiledModel, ParameterSlot, Scale};

use crate::criteria::{BOUND_SHARE, LAW_RANGE_EXTENSION, RANGE_EXTENSION};

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

    /// Least and greatest coordinate that the library lists.
    pub fn listed(&self) -> [f64; 2] {
        self.slot.range.map(|value| self.from_value(value))
    }

    /// Least and greatest coordinate that a fit may reach.
    pub fn bounds(&self) -> [f64; 2] {
        self.reach().map(|value| self.from_value(value))
    }

    /// Least and greatest value [SI] that a fit may reach. What the library lists is plausible, not all that there is: ratios
    /// may be a factor beyond it, sizes as many times as far from their null. A range that a model states holds.
    pub fn reach(&self) -> [f64; 2] {
        let ([least, greatest], slot) = (self.slot.range, &self.slot);
        let factor = if slot.is_law { LAW_RANGE_EXTENSION } else { RANGE_EXTENSION };
        match slot.scale {
            _ if slot.is_range_stated => slot.range,
            Scale::Log => [least / factor, greatest * factor],
            Scale::Linear => {
                let anchor = slot.null.unwrap_or(0.0);
                let is_inside = (least..=greatest).contains(&anchor);
                if is_inside { slot.range.map(|end| anchor + factor * (end - anchor)) } else { slot.range }
            }
        }
    }

    /// The end of what the library lists that a coordinate lies beyond.
    pub fn beyond_listed(&self, at: f64) -> Option<f64> {
        let [least, greatest] = self.listed();
        let near = BOUND_SHARE * (greatest - least);
        if at < least - near { Some(least) } else { Some(greatest).filter(|end| at > end + near) }
    }

    /// The nearest coordinate within the bounds.
    pub fn clamped(&self, at: f64) -> f64 {
        let [least, greatest] = self.bounds();
        at.clamp(least, greatest)
    }

    /// The bound on which a coordinate lies.
    pub fn bound(&self, at: f64) -> Option<Bound> {
        let ([least, greatest], [low, high]) = (self.bounds(), self.listed());
        let near = BOUND_SHARE * (high - low);
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

#[cfg(test)]
mod tests {
    use effects::{Library, Model, Process, RowCounts};

    use super::*;

    fn coordinate(name: &str) -> Coordinate {
        let model = Model::new(Process::Grinding).with("wheel-crown").with("grit-dulling");
        let compiled = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap();
        Coordinate::of(&compiled, |slot| slot.name() == name).remove(0)
    }

    #[test]
    fn ranges_of_the_library_are_soft() {
        for (name, factor) in
            [("winkler.stiffness", LAW_RANGE_EXTENSION), ("grit-dulling.dulling_volume", RANGE_EXTENSION)]
        {
            let coordinate = coordinate(name);
            let ([least, greatest], [low, high]) = (coordinate.slot.range, coordinate.reach());
            assert!((least / low / factor - 1.0).abs() < 1e-12 && (high / greatest / factor - 1.0).abs() < 1e-12);
            assert_eq!(coordinate.beyond_listed(coordinate.from_value(2.0 * greatest)), Some(coordinate.listed()[1]));
            assert_eq!(coordinate.beyond_listed(coordinate.from_value(0.5 * greatest)), None);
        }
    }

    #[test]
    fn a_size_may_be_three_times_as_far_from_its_null() {
        let crown = coordinate("wheel-crown.crown");
        let null = crown.slot.null.unwrap();
        let [least, greatest] = crown.reach();
        assert!((greatest - null - RANGE_EXTENSION * (crown.slot.range[1] - null)).abs() < 1e-9);
        assert!((least - null - RANGE_EXTENSION * (crown.slot.range[0] - null)).abs() < 1e-9);
        let stated = Coordinate { slot: ParameterSlot { is_range_stated: true, ..crown.slot.clone() }, ..crown };
        assert_eq!(stated.reach(), stated.slot.range, "a range that a model states holds");
    }
}
