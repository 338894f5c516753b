//! A first look at every effect of the library: what it would change, beside what the base parameters can change
//! already.

use nalgebra::{DMatrix, DVector, QR};
use rayon::prelude::*;
use sim::effect::Scale;

use super::coordinates::Coordinate;
use super::evidence::{Evidence, Split};
use super::fit::{Fit, weights};
use super::probe::{Candidate, Probe};

/// Longest extrapolation of a secant beyond the probe that it was taken at.
const FARTHEST: f64 = 1.5;
/// Share of a change that must be left beside the base parameters' changes: less is rounding.
const LEAST_LEFT: f64 = 1e-3;

/// Takes out of data what the base parameters can explain.
pub struct Projector {
    weights: DVector<f64>,
    base: Option<DMatrix<f64>>,
    /// The base fit's residuals without what the base parameters can explain.
    pub residuals: DVector<f64>,
}

/// What an effect changes at one probe.
#[derive(Clone, Debug)]
pub struct Response {
    /// Where.
    pub probe: Probe,
    /// Change of the whitened residuals from null to probe, without what the base parameters can do.
    pub change: DVector<f64>,
    /// The whole change.
    pub raw: Vec<f64>,
    /// Shares of the way from null to probe to which the change may be extrapolated, least and greatest.
    pub reach: [f64; 2],
}

/// The first look at an effect.
#[derive(Clone)]
pub struct Screened {
    /// The effect.
    pub candidate: Candidate,
    /// All probes that could be simulated, group by group.
    pub responses: Vec<Vec<Response>>,
    /// Expected fall of the sum of squares.
    pub gain: f64,
    /// The values at which it is expected [SI].
    pub best: Vec<f64>,
}

impl Projector {
    /// From a base fit with its derivatives.
    pub fn new(base: &Fit) -> Self {
        let weights = weights(&base.residuals);
        let mut jacobian = base.jacobian.clone();
        jacobian.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weights));
        let held = base.held_back();
        let moves = |&k: &usize| jacobian.column(k).norm() > 0.0 && !held[k];
        let kept: Vec<usize> = (0..jacobian.ncols()).filter(moves).collect();
        let base_space = (!kept.is_empty()).then(|| QR::new(jacobian.select_columns(&kept)).q());
        let mut projector = Self { weights, base: base_space, residuals: DVector::zeros(0) };
        projector.residuals = projector.project(&base.residuals);
        projector
    }

    /// Weighted data without what the base parameters can explain.
    pub fn project(&self, data: &[f64]) -> DVector<f64> {
        self.strip(DVector::from_column_slice(data).component_mul(&self.weights))
    }

    /// As [`Projector::project`], for data that are weighted already.
    pub fn strip(&self, mut left: DVector<f64>) -> DVector<f64> {
        if let Some(base) = &self.base {
            left -= base * base.tr_mul(&left);
        }
        left
    }
}

/// Shares of the way from a null to a probed value that stay within a parameter's range and near the probe.
fn reach(coordinate: &Coordinate, probed: f64) -> [f64; 2] {
    let [least, greatest] = coordinate.slot.range;
    let null = coordinate.slot.null.unwrap_or(0.0);
    if !(least..=greatest).contains(&null) {
        return [0.0, FARTHEST];
    }
    let mut ends = [least, greatest].map(|end| ((end - null) / (probed - null)).clamp(-FARTHEST, FARTHEST));
    ends.sort_by(f64::total_cmp);
    ends
}

impl Response {
    /// Whether anything is left of the change beside the base parameters' changes.
    pub fn is_distinct(&self) -> bool {
        let raw = self.raw.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.change.norm() > LEAST_LEFT * raw && self.change.norm() > 0.0
    }

    /// Share of the way from null to probe at which the sum of squares is least, and its fall.
    pub fn optimum(&self, residuals: &DVector<f64>) -> (f64, f64) {
        let square = self.change.norm_squared();
        if square == 0.0 {
            return (0.0, 0.0);
        }
        let share = (-self.change.dot(residuals) / square).clamp(self.reach[0], self.reach[1]);
        (share, -2.0 * share * self.change.dot(residuals) - share * share * square)
    }
}

impl Screened {
    /// Simulates a candidate's probes around a base fit.
    pub fn new(evidence: &dyn Evidence, base: &Fit, projector: &Projector, candidate: Candidate) -> Self {
        let respond = |probe: &Probe| {
            let residuals = evidence.residuals(&candidate.at(&probe.values), Split::Calibration).ok()?;
            let raw: Vec<f64> = residuals.iter().zip(&base.residuals).map(|(b, a)| b - a).collect();
            let reach = reach(&candidate.coordinates[probe.amplitude], probe.values[probe.amplitude]);
            Some(Response { probe: probe.clone(), change: projector.project(&raw), raw, reach })
        };
        let group = |probes: &Vec<Probe>| -> Vec<Response> { probes.par_iter().filter_map(respond).collect() };
        let responses: Vec<Vec<Response>> = candidate.probes.par_iter().map(group).collect();
        let nulls: Vec<f64> = candidate.coordinates.iter().map(|c| c.slot.null.unwrap_or(c.slot.default)).collect();
        let mut screened = Self { candidate, responses, gain: 0.0, best: nulls };
        screened.choose(&projector.residuals);
        screened
    }

    /// Whether any probe could be simulated.
    pub fn is_simulated(&self) -> bool {
        self.responses.iter().any(|group| !group.is_empty())
    }

    /// Finds the expected best values: the best single probe, or all amplitudes of one shape together.
    fn choose(&mut self, residuals: &DVector<f64>) {
        for response in self.responses.iter().flatten().filter(|response| response.is_distinct()) {
            let (share, gain) = response.optimum(residuals);
            if gain > self.gain {
                self.gain = gain;
                self.best = self.along(response, share);
            }
        }
        if let Some((values, gain)) = self.together(residuals).filter(|(_, gain)| *gain > self.gain) {
            (self.best, self.gain) = (values, gain);
        }
    }

    /// The same changes seen beside another fit.
    pub(super) fn beside(mut self, projector: &Projector) -> Self {
        for response in self.responses.iter_mut().flatten() {
            response.change = projector.project(&response.raw);
        }
        self.gain = 0.0;
        self.choose(&projector.residuals);
        self
    }

    /// With the values at a share of the way from null to a probe as its best.
    pub(super) fn moved_to(self, response: &Response, share: f64) -> Self {
        Self { best: self.along(response, share), ..self }
    }

    /// Values at a share of the way from null to a probe. An amplitude in ratios with an infinite null is a rate turned
    /// upside down: its reciprocal goes the way.
    fn along(&self, response: &Response, share: f64) -> Vec<f64> {
        let mut values = response.probe.values.clone();
        let k = response.probe.amplitude;
        let coordinate = &self.candidate.coordinates[k];
        let null = coordinate.slot.null.unwrap_or(0.0);
        let value = if null.is_infinite() { values[k] / share.max(1e-3) } else { null + share * (values[k] - null) };
        values[k] = coordinate.value(coordinate.clamped(coordinate.from_value(value)));
        values
    }

    /// Derivative of the whitened residuals along the effect's coordinate `k` at the best values, from the nearest probe of
    /// that amplitude; `None` for a parameter of shape.
    pub fn slope(&self, k: usize) -> Option<DVector<f64>> {
        let distance = |response: &&Response| -> f64 {
            let coordinates = self.candidate.coordinates.iter().zip(response.probe.values.iter().zip(&self.best));
            let apart = |coordinate: &Coordinate, a: f64, b: f64| {
                let [a, b] = [a, b].map(|value| coordinate.clamped(coordinate.from_value(value)));
                (a - b).abs()
            };
            coordinates.map(|(coordinate, (a, b))| apart(coordinate, *a, *b)).sum()
        };
        let along = self.responses.iter().flatten().filter(|response| response.probe.amplitude == k);
        let nearest = along.min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
        let (probed, best, slot) = (nearest.probe.values[k], self.best[k], &self.candidate.coordinates[k].slot);
        let null = slot.null.unwrap_or(0.0);
        let per_coordinate = match slot.scale {
            Scale::Log if null.is_infinite() => -probed / best,
            Scale::Log => best / (probed - null),
            Scale::Linear => (slot.range[1] - slot.range[0]) / (probed - null),
        };
        Some(DVector::from_column_slice(&nearest.raw) * per_coordinate)
    }

    /// All amplitudes of the typical shape at once, by least squares over the better probe of each.
    fn together(&self, residuals: &DVector<f64>) -> Option<(Vec<f64>, f64)> {
        let typical = self.responses.iter().zip(&self.candidate.probes).filter(|(_, probes)| {
            let first = &self.candidate.probes[0][0].values;
            let shape = |k: &usize| self.candidate.coordinates[*k].slot.null.is_none();
            (0..first.len()).filter(shape).all(|k| probes[0].values[k] == first[k])
        });
        let better = |group: &Vec<Response>| {
            let gain = |response: &&Response| response.optimum(residuals).1;
            group.iter().filter(|response| response.is_distinct()).max_by(|a, b| gain(a).total_cmp(&gain(b))).cloned()
        };
        let columns: Vec<Response> = typical.filter_map(|(group, _)| better(group)).collect();
        if columns.len() < 2 {
            return None;
        }
        let matrix = DMatrix::from_columns(&columns.iter().map(|response| response.change.clone()).collect::<Vec<_>>());
        let shares = matrix.clone().svd(true, true).solve(&(-residuals), 1e-6).ok()?;
        let left = residuals + &matrix * &shares;
        let mut values = columns[0].probe.values.clone();
        for (response, share) in columns.iter().zip(shares.iter()) {
            let k = response.probe.amplitude;
            values[k] = self.along(response, *share)[k];
        }
        Some((values, residuals.norm_squared() - left.norm_squared()))
    }
}
