//! First look at every effect of the library: its response beside the base parameters.

use effects::Scale;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::coordinates::Coordinate;
use super::fit::Fit;
use super::probe::{Candidate, Probe, probe_change};
use super::response::{Baseline, Projector, Response};
use crate::criteria::{
    EXTRAPOLATION_MOST, LARGER_PROBE_DELTA_CHI2, LARGER_PROBE_RATIO, LARGER_PROBES, PROBE_LEAST_DISTANCE,
    PROBE_MISS_RATIO, SHAPE_GAIN_SHARE,
};

/// The first look at an effect.
#[derive(Clone)]
pub struct Screened {
    /// The effect.
    pub candidate: Candidate,
    /// All probes that could be simulated, group by group; further probes are added to a group without a suitable one.
    pub responses: Vec<Vec<Response>>,
    /// Expected fall of the sum of squares.
    pub delta_chi2: f64,
    /// Parameter values at which it is expected [SI].
    pub best: Vec<f64>,
    /// Expected shift of the base parameters [coordinates]; empty if they do not move.
    pub shift: Vec<f64>,
}

/// The probe of a group that needs the least extrapolation to its optimum.
fn aptest<'a>(group: &'a [Response], residuals: &DVector<f64>) -> Option<&'a Response> {
    let far = |response: &Response| response.extrapolation(residuals);
    group.iter().filter(|response| response.is_distinct()).min_by(|a, b| far(a).total_cmp(&far(b)))
}

impl Screened {
    /// Simulates a candidate's probes.
    pub fn new(baseline: &Baseline, candidate: Candidate) -> Self {
        let group = |probes: &Vec<Probe>| -> Vec<Response> {
            probes.par_iter().filter_map(|probe| baseline.at(&candidate, probe)).collect()
        };
        let responses: Vec<Vec<Response>> = candidate.probes.par_iter().map(group).collect();
        let nulls: Vec<f64> = candidate.coordinates.iter().map(|c| c.slot.null.unwrap_or(c.slot.default)).collect();
        let mut screened = Self { candidate, responses, delta_chi2: 0.0, best: nulls, shift: Vec::new() };
        let wanted = probe_change(baseline.projector.residuals.norm());
        let apt: Vec<Option<Response>> = screened
            .responses
            .par_iter()
            .map(|group| baseline.at(&screened.candidate, &screened.apter(group, wanted)?))
            .collect();
        screened.responses.iter_mut().zip(apt).for_each(|(group, response)| group.extend(response));
        let mut responses = std::mem::take(&mut screened.responses);
        responses.par_iter_mut().for_each(|group| screened.go_farther(baseline, group));
        screened.responses = responses;
        screened.choose(&baseline.projector.residuals);
        screened
    }

    /// Adds probes of larger size as long as the data favour a size beyond all of them.
    fn go_farther(&self, baseline: &Baseline, group: &mut Vec<Response>) {
        let residuals = &baseline.projector.residuals;
        for _ in 0..LARGER_PROBES {
            let Some(nearest) = aptest(group, residuals) else { return };
            let wanted = nearest.wanted(residuals);
            if wanted.abs() <= EXTRAPOLATION_MOST || nearest.optimum(residuals).1 < LARGER_PROBE_DELTA_CHI2 {
                return;
            }
            let values = self.along(nearest, wanted.clamp(-LARGER_PROBE_RATIO, LARGER_PROBE_RATIO));
            let probe = Probe { values, amplitude: nearest.probe.amplitude };
            if !self.is_apart(group, &probe) {
                return;
            }
            let Some(response) = baseline.at(&self.candidate, &probe) else { return };
            group.push(response);
        }
    }

    /// Returns true if a probe is distinct from all of a group.
    fn is_apart(&self, group: &[Response], probe: &Probe) -> bool {
        let k = probe.amplitude;
        let null = self.candidate.coordinates[k].slot.null.filter(|null| null.is_finite()).unwrap_or(0.0);
        let apart = |other: f64| (probe.values[k] - other).abs() > PROBE_LEAST_DISTANCE * (other - null).abs();
        group.iter().all(|response| apart(response.probe.values[k]))
    }

    /// A further probe, if no probe of a group causes a change of about the wanted size.
    fn apter(&self, group: &[Response], wanted: f64) -> Option<Probe> {
        let share = |response: &&Response| wanted / response.change.norm();
        let off = |response: &&Response| share(response).ln().abs();
        let distinct = group.iter().filter(|response| response.is_distinct());
        let nearest = distinct.min_by(|a, b| off(a).total_cmp(&off(b)))?;
        if off(&nearest) < PROBE_MISS_RATIO.ln() {
            return None;
        }
        let probe = Probe { values: self.along(nearest, share(&nearest)), amplitude: nearest.probe.amplitude };
        self.is_apart(group, &probe).then_some(probe)
    }

    /// Returns true if any probe could be simulated.
    pub fn is_simulated(&self) -> bool {
        self.responses.iter().any(|group| !group.is_empty())
    }

    /// Finds the expected best values: of the best single amplitude, or of all amplitudes of one shape together.
    fn choose(&mut self, residuals: &DVector<f64>) {
        for response in self.responses.iter().filter_map(|group| aptest(group, residuals)) {
            let (share, delta_chi2) = response.optimum(residuals);
            if delta_chi2 > self.delta_chi2 {
                self.delta_chi2 = delta_chi2;
                self.best = self.along(response, share);
                self.shift = response.shift.iter().map(|shift| share * shift).collect();
            }
        }
        if let Some((values, shift, delta_chi2)) =
            self.together(residuals).filter(|(_, _, delta_chi2)| *delta_chi2 > self.delta_chi2)
        {
            (self.best, self.shift, self.delta_chi2) = (values, shift, delta_chi2);
        }
    }

    /// The same expectations, seen from another fit of the same model.
    pub(super) fn seen_from(self, fit: &Fit, place: &Fit) -> Self {
        let apart = place.at.iter().zip(&fit.at).map(|(place, from)| place - from);
        let shift = apart.enumerate().map(|(k, apart)| apart + self.shift.get(k).unwrap_or(&0.0)).collect();
        Self { delta_chi2: (self.delta_chi2 + fit.chi2 - place.chi2).max(0.0), shift, ..self }
    }

    /// The same responses projected for another fit.
    pub(super) fn beside(mut self, projector: &Projector) -> Self {
        for response in self.responses.iter_mut().flatten() {
            response.change = projector.project(&response.followed);
        }
        (self.delta_chi2, self.shift) = (0.0, Vec::new());
        self.choose(&projector.residuals);
        self
    }

    /// Starting values of fits: the best values, then those of each other shape of nearly the same expected Δχ², in
    /// descending order.
    pub(super) fn starts(&self, residuals: &DVector<f64>) -> Vec<Self> {
        let single = self.responses.iter().filter_map(|group| {
            let response = aptest(group, residuals)?;
            let (share, delta_chi2) = response.optimum(residuals);
            Some((delta_chi2, self.clone().moved_to(response, share)))
        });
        let shapes = |k: &usize| self.candidate.coordinates[*k].slot.null.is_none();
        let differs = |start: &Self| (0..self.best.len()).filter(shapes).any(|k| start.best[k] != self.best[k]);
        let mut starts: Vec<(f64, Self)> = single
            .filter(|(delta_chi2, start)| *delta_chi2 > SHAPE_GAIN_SHARE * self.delta_chi2 && differs(start))
            .collect();
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        std::iter::once(self.clone()).chain(starts.into_iter().map(|(_, start)| start)).collect()
    }

    /// The same with the values at a multiple of the distance from null to a probe as its best.
    pub(super) fn moved_to(self, response: &Response, share: f64) -> Self {
        let shift = response.shift.iter().map(|shift| share * shift).collect();
        Self { best: self.along(response, share), shift, ..self }
    }

    /// Values at a multiple of the distance from null to a probe. A ratio with an infinite null goes by its reciprocal.
    fn along(&self, response: &Response, share: f64) -> Vec<f64> {
        let mut values = response.probe.values.clone();
        let k = response.probe.amplitude;
        let coordinate = &self.candidate.coordinates[k];
        let null = coordinate.slot.null.unwrap_or(0.0);
        let value = if null.is_infinite() { values[k] / share.max(1e-3) } else { null + share * (values[k] - null) };
        values[k] = coordinate.value(coordinate.clamped(coordinate.from_value(value)));
        values
    }

    /// Derivative of the whitened residuals along the effect's coordinate `k` at the best values, from the nearest
    /// probe of that amplitude; `None` for a shape parameter.
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

    /// The probes of the typical shape, a group for each amplitude.
    pub(super) fn typical(&self) -> impl Iterator<Item = &[Response]> {
        let is_typical = |probes: &[Probe]| {
            let first = &self.candidate.probes[0][0].values;
            let shape = |k: &usize| self.candidate.coordinates[*k].slot.null.is_none();
            (0..first.len()).filter(shape).all(|k| probes[0].values[k] == first[k])
        };
        let groups = self.responses.iter().zip(&self.candidate.probes);
        groups.filter(move |(_, probes)| is_typical(probes)).map(|(group, _)| &group[..])
    }

    /// All amplitudes of the typical shape together, by least squares over the most suitable probe of each.
    fn together(&self, residuals: &DVector<f64>) -> Option<(Vec<f64>, Vec<f64>, f64)> {
        let columns: Vec<&Response> = self.typical().filter_map(|group| aptest(group, residuals)).collect();
        if columns.len() < 2 {
            return None;
        }
        let matrix = DMatrix::from_columns(&columns.iter().map(|response| response.change.clone()).collect::<Vec<_>>());
        let shares = matrix.clone().svd(true, true).solve(&(-residuals), 1e-6).ok()?;
        let left = residuals + &matrix * &shares;
        let mut values = columns[0].probe.values.clone();
        let mut shift = vec![0.0; columns.iter().map(|response| response.shift.len()).max()?];
        for (response, share) in columns.iter().zip(shares.iter()) {
            let k = response.probe.amplitude;
            values[k] = self.along(response, *share)[k];
            shift.iter_mut().zip(&response.shift).for_each(|(sum, shift)| *sum += share * shift);
        }
        Some((values, shift, residuals.norm_squared() - left.norm_squared()))
    }
}
