//! Fits of a law of which the data determine one combination well and the others poorly: rate and threshold at nearly
//! equal pressures.

use effects::{Effect, Library, Model, Process, RowCounts};

use super::*;
use crate::evidence::Agreement;
use crate::pass_trend::PassTrend;
use crate::space_mapping::Surrogate;
use crate::totals::{Total, Totals};

/// Standard deviation of a depth [mm]; each place is ground for a second.
const NOISE: f64 = 0.01;

/// Depths [mm] under pressures around 0.6 MPa, with numerical noise as in simulations.
struct Valley {
    depths: Vec<f64>,
    unevenness: f64,
    /// Factor on the predicted depths.
    gain: f64,
}

impl Valley {
    /// True rate [mm/(MPa s)], threshold [MPa] and stiffness [MPa/mm].
    const TRUTH: [f64; 3] = [1.5, 0.2, 30.0];

    fn new(unevenness: f64) -> Self {
        let mut valley = Self { depths: Vec::new(), unevenness: 0.0, gain: 1.0 };
        valley.depths = valley.predicted(&model(Self::TRUTH));
        Self { unevenness, ..valley }
    }

    fn predicted(&self, model: &CompiledModel) -> Vec<f64> {
        let [rate, threshold, stiffness] = values(model);
        let at = |i: usize| {
            let pressure = 0.6 + 0.1 * (i as f64 / 400.0 - 0.5) + 0.02 * (stiffness / 30.0).ln() * (i % 7) as f64;
            let ripple = self.unevenness * (1e3 * (rate + threshold * 7.0) + i as f64 * i as f64).sin();
            self.gain * rate * (pressure - threshold).max(0.0) + ripple * NOISE
        };
        (0..400).map(at).collect()
    }
}

fn model([rate, threshold, stiffness]: [f64; 3]) -> CompiledModel {
    let model = Model::new(Process::Grinding);
    let mut compiled = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).unwrap();
    for coordinate in Coordinate::of(&compiled.clone(), |_| true) {
        let slot = &coordinate.slot;
        let value = match slot.parameter.as_str() {
            "grind_rate" => rate,
            "threshold_pressure" => threshold,
            _ => stiffness,
        };
        compiled.set(coordinate.index, slot.unit.to_si(value));
    }
    compiled
}

fn values(model: &CompiledModel) -> [f64; 3] {
    let coordinates = Coordinate::of(model, |_| true);
    ["grind_rate", "threshold_pressure", "stiffness"].map(|name| {
        let own = coordinates.iter().find(|coordinate| coordinate.slot.parameter == name).unwrap();
        own.slot.unit.from_si(model.value(own.index))
    })
}

impl Evidence for Valley {
    fn process(&self) -> Process {
        Process::Grinding
    }

    fn rows(&self) -> RowCounts {
        RowCounts::default()
    }

    fn residuals(&self, model: &CompiledModel, _: Split) -> Result<Vec<f64>, EvidenceError> {
        let predicted = self.predicted(model);
        // Deterministic noise of variance one.
        let noise = |i: usize| 2.0_f64.sqrt() * (2.4 * (i * i % 397) as f64).sin();
        Ok((0..400).map(|i| noise(i) + (self.depths[i] - predicted[i]) / NOISE).collect())
    }

    fn agreement(&self, _: &CompiledModel, _: Split) -> Result<Vec<Agreement>, EvidenceError> {
        Ok(Vec::new())
    }

    fn size(&self, change: &[f64]) -> f64 {
        change.iter().map(|c| c * c).sum::<f64>().sqrt()
    }

    fn trend(&self, _: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
        Ok(None)
    }

    fn is_blind_to(&self, _: &Effect) -> Option<String> {
        None
    }

    fn blocks(&self, _: Split) -> Vec<usize> {
        (0..400).map(|i| i / 16).collect()
    }
}

/// Distances of a fit from the true values [standard deviations], and the number of simulations.
fn ways(unevenness: f64, from: [f64; 3]) -> (Vec<f64>, usize) {
    let valley = Valley::new(unevenness);
    let start = model(from);
    let fit = Fit::new(&valley, &start, valley.coordinates(&start), FitOptions::default()).unwrap();
    let truth = Fit::new(&valley, &model(Valley::TRUTH), valley.coordinates(&start), FitOptions::default()).unwrap();
    assert!(fit.converged, "χ² {} after {} simulations", fit.chi2, fit.runs);
    let way =
        |estimate: &Estimate, truth: &f64| (estimate.coordinate.from_value(estimate.value) - truth) / estimate.sigma;
    let ways = fit.estimates(1.0).iter().zip(&truth.at).map(|(estimate, truth)| way(estimate, truth)).collect();
    (ways, fit.runs)
}

#[test]
fn a_fit_comes_to_the_end_of_a_valley_that_bends() {
    for unevenness in [0.0, 0.1] {
        for from in [[0.7, 0.0, 5.0], [3.0, 0.4, 100.0], [0.9, 0.02, 30.0]] {
            let (ways, runs) = ways(unevenness, from);
            assert!(ways.iter().all(|way| way.abs() < 0.5), "from {from:?}: {ways:?} σ off after {runs} simulations");
        }
    }
}

impl Totals for Valley {
    fn totals(&self, _: &CompiledModel, _: Split) -> Result<Vec<Total>, EvidenceError> {
        Ok(Vec::new())
    }

    fn unregistered(&self, _: &CompiledModel, _: Split) -> Result<Vec<f64>, EvidenceError> {
        Ok(Vec::new())
    }
}

#[test]
fn a_surrogate_follows_the_usual_lattice_although_its_own_is_uneven() {
    let usual = Valley::new(0.0);
    let uneven = Valley { unevenness: 0.5, gain: 1.5, ..Valley::new(0.0) };
    let start = model([1.0, 0.2, 30.0]);
    let mut fit = Fit::unfitted(&usual, &start, usual.coordinates(&start)).unwrap();
    fit.differentiate(&usual, &[0, 1, 2]);
    let constant = Surrogate::at(&uneven, &fit).unwrap();
    let linear = Surrogate::around(&usual, &uneven, &fit).unwrap();
    let here = fit.here();
    let is_near = |place: &Place| (30.0..50.0).contains(&place.distance(&here));
    let places: Vec<Place> = fit.pairs_around(&usual, 40.0).into_iter().flatten().filter(is_near).collect();
    assert!(places.len() >= 4, "{} places in the linear range", places.len());
    for place in places {
        let error = |surrogate: &Surrogate| fit.place(surrogate, place.at.clone()).unwrap().distance(&place);
        let (constant, linear) = (error(&constant), error(&linear));
        assert!(linear < 0.6 * constant, "{linear} σ off, {constant} σ without the slope, at {:?}", place.at);
    }
}

#[test]
fn a_fit_has_another_minimum_only_if_it_lies_away_from_that_near_its_start() {
    let valley = Valley::new(0.0);
    let start = model([1.4, 0.2, 30.0]);
    let near = Fit::new(&valley, &start, valley.coordinates(&start), FitOptions::default()).unwrap();
    assert!(near.other_minimum(&valley).is_none());
    // As if a restart had ended at a far stiffer contact.
    let stiff = Fit::unfitted(&valley, &model([1.5, 0.2, 1300.0]), valley.coordinates(&start)).unwrap();
    let other = Fit { begun: near.begun.clone(), ..stiff }.other_minimum(&valley).expect("that near the start");
    let apart = other.here().distance(&near.here());
    assert!(apart < 5.0 && !other.is_poor(), "{apart} σ apart, χ² {}", other.chi2);
}
