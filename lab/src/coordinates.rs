//! Coordinates of a fit: parameters scaled so that a step of about one is large.

use effects::{CompiledModel, ParameterSlot, Scale};

use crate::criteria::{BOUND_SHARE, LAW_RANGE_EXTENSION, RANGE_EXTENSION};

/// A parameter as a fit varies it: the logarithm of its value, or its value divided by the width of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Index among the model's parameters.
    pub index: usize,
    /// The parameter.
    pub slot: ParameterSlot,
}

/// Bound on which a value lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bound {
    /// The lower bound.
    Least,
    /// The upper bound.
    Greatest,
}

impl Coordinate {
    /// Coordinates of the free parameters of a model that `takes` accepts.
    pub fn of(model: &CompiledModel, takes: impl Fn(&ParameterSlot) -> bool) -> Vec<Self> {
        let slots = model.parameters().iter().cloned().enumerate();
        slots.filter(|(_, slot)| slot.free && takes(slot)).map(|(index, slot)| Self { index, slot }).collect()
    }

    /// Converts a value [SI] to the coordinate.
    pub fn from_value(&self, value: f64) -> f64 {
        match self.slot.scale {
            Scale::Log => value.ln(),
            Scale::Linear => value / self.width(),
        }
    }

    /// Converts the coordinate to a value [SI].
    pub fn value(&self, at: f64) -> f64 {
        match self.slot.scale {
            Scale::Log => at.exp(),
            Scale::Linear => at * self.width(),
        }
    }

    /// Lower and upper end of the library's range [coordinate].
    pub fn listed(&self) -> [f64; 2] {
        self.slot.range.map(|value| self.from_value(value))
    }

    /// Lower and upper bound of a fit [coordinate].
    pub fn bounds(&self) -> [f64; 2] {
        self.reach().map(|value| self.from_value(value))
    }

    /// Lower and upper bound of a fit [SI]. The library's range is plausible and not exhaustive: a fit may exceed it by
    /// a factor for ratios, and by a multiple of the distance from the null for sizes. A range that a model states is
    /// kept.
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

    /// End of the library's range that a coordinate exceeds, if any.
    pub fn beyond_listed(&self, at: f64) -> Option<f64> {
        let [least, greatest] = self.listed();
        let near = BOUND_SHARE * (greatest - least);
        if at < least - near { Some(least) } else { Some(greatest).filter(|end| at > end + near) }
    }

    /// The coordinate clamped to the bounds.
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

    /// Initial step of a finite difference.
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

/// Copies a model with coordinates set.
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
