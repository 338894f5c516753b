//! Probes: values of an effect's parameters for the first look.

use effects::{CompiledModel, Effect, Library, Model, ModelError, ParameterSlot, Rows, Scale};

use super::coordinates::Coordinate;
use super::evidence::Evidence;
use crate::criteria::{
    PROBE_CHANGE_SHARE, PROBE_CHANGE_SIGMAS, PROBE_NARROW_HIGH, PROBE_NARROW_LOW, PROBE_SHAPE_HIGH, PROBE_SHAPE_LOW,
    PROBE_TYPICAL_SHARE, PROBE_WIDE_HIGH, PROBE_WIDE_LOW, PROBE_WIDE_MIDDLE, PROBE_WIDE_RATIO,
};

/// An effect added to a model, with the values to probe.
#[derive(Clone)]
pub struct Candidate {
    /// Name of the effect.
    pub name: String,
    /// Name of its family: the first of the forms of one dependence.
    pub family: String,
    /// The model with the effect, all amplitudes at their null.
    pub model: CompiledModel,
    /// The effect's free parameters.
    pub coordinates: Vec<Coordinate>,
    /// Values [SI] of all these parameters, in groups: the probes of a group differ in amplitude only.
    pub probes: Vec<Vec<Probe>>,
}

/// Parameter values at which an effect is tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// One value [SI] for each of the effect's free parameters.
    pub values: Vec<f64>,
    /// Index of the parameter that is off its null.
    pub amplitude: usize,
}

/// Change of the whitened data [σ] that a probe should make beside a misfit [σ].
pub(super) fn probe_change(misfit: f64) -> f64 {
    PROBE_CHANGE_SIGMAS.max(PROBE_CHANGE_SHARE * misfit)
}

impl Candidate {
    /// Adds an effect to a model.
    ///
    /// # Errors
    /// If the model cannot be compiled with it.
    pub fn new(evidence: &dyn Evidence, model: &Model, effect: &Effect, library: &Library) -> Result<Self, ModelError> {
        let mut with = model.clone().with(&effect.name);
        if let Some(free) = &mut with.free {
            let own = effect.parameters.iter().filter(|parameter| parameter.free.of(model.process));
            free.extend(own.map(|parameter| format!("{}.{}", effect.name, parameter.name)));
        }
        let mut model = CompiledModel::new(&evidence.adapted(with, library), library, evidence.rows())?;
        let mut coordinates = evidence.coordinates(&model);
        coordinates.retain(|coordinate| coordinate.slot.owner == effect.name);
        let amplitudes: Vec<usize> = (0..coordinates.len()).filter(|&k| coordinates[k].slot.null.is_some()).collect();
        for own in Coordinate::of(&model, |slot| slot.owner == effect.name) {
            model.set(own.index, own.slot.null.unwrap_or(own.slot.default));
        }
        let rest: Vec<f64> = coordinates.iter().map(|c| c.slot.null.unwrap_or(c.slot.default)).collect();
        let shapes = shapes(&coordinates, &rest);
        let group = |(shape, &amplitude): (&Vec<f64>, &usize)| -> Vec<Probe> {
            let probe = |value: f64| {
                let mut values = shape.clone();
                values[amplitude] = value;
                Probe { values, amplitude }
            };
            tried(&coordinates[amplitude].slot).into_iter().map(probe).collect()
        };
        let pairs = shapes.iter().flat_map(|shape| amplitudes.iter().map(move |amplitude| (shape, amplitude)));
        let probes = pairs.map(group).collect();
        Ok(Self { name: effect.name.clone(), family: evidence.family(&effect.name), model, coordinates, probes })
    }

    /// Returns false for an effect with a value for each pass: it describes the data and explains nothing.
    pub(super) fn explains(&self) -> bool {
        self.coordinates.iter().all(|coordinate| coordinate.slot.per != Rows::Pass)
    }

    /// For each amplitude the middle probe, with the typical shape of the library.
    pub(super) fn typical(&self) -> impl Iterator<Item = &Probe> {
        let amplitudes = self.coordinates.iter().filter(|coordinate| coordinate.slot.null.is_some()).count();
        self.of_each_shape().take(amplitudes)
    }

    /// The middle probe of each group: every amplitude, with the typical shape of the library and with each other one.
    pub(super) fn of_each_shape(&self) -> impl Iterator<Item = &Probe> {
        self.probes.iter().filter_map(|group| group.get(group.len() / 2))
    }

    /// The model with the effect at these values [SI].
    pub fn at(&self, values: &[f64]) -> CompiledModel {
        let mut model = self.model.clone();
        for (coordinate, &value) in self.coordinates.iter().zip(values) {
            model.set(coordinate.index, value);
        }
        model
    }
}

/// Amplitudes to try [SI], on one side of the null: small effects of opposite sign differ only in sign.
fn tried(slot: &ParameterSlot) -> Vec<f64> {
    let [least, greatest] = slot.range;
    if slot.scale == Scale::Log {
        let is_wide = greatest > PROBE_WIDE_RATIO * least;
        let spread: &[f64] = match is_wide {
            true => &[PROBE_WIDE_LOW, PROBE_WIDE_MIDDLE, PROBE_WIDE_HIGH],
            false => &[PROBE_NARROW_LOW, PROBE_NARROW_HIGH],
        };
        return spread.iter().map(|share| least * (greatest / least).powf(*share)).collect();
    }
    let null = slot.null.unwrap_or(0.0);
    let typical = if slot.default == null { null + PROBE_TYPICAL_SHARE * (greatest - least) } else { slot.default };
    vec![if typical > greatest { 2.0 * null - typical } else { typical }]
}

/// Sets of all parameters' values, in which one shape parameter in turn is off its typical value.
fn shapes(coordinates: &[Coordinate], typical: &[f64]) -> Vec<Vec<f64>> {
    let mut all = vec![typical.to_vec()];
    for (k, coordinate) in coordinates.iter().enumerate().filter(|(_, c)| c.slot.null.is_none()) {
        let [least, greatest] = coordinate.listed();
        for share in [PROBE_SHAPE_LOW, PROBE_SHAPE_HIGH] {
            let mut values = typical.to_vec();
            values[k] = coordinate.value(least + share * (greatest - least));
            all.push(values);
        }
    }
    all
}
