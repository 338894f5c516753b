//! Response of the data to an effect, without the part that the base parameters can explain.

use effects::CompiledModel;
use nalgebra::{DMatrix, DVector, QR};

use super::coordinates::Coordinate;
use super::evidence::{Evidence, Split};
use super::fit::{Fit, robust_sum, weights};
use super::probe::{Candidate, Probe};
use crate::criteria::{DISTINCT_CHANGE_SHARE, EXTRAPOLATION_MOST, FOLLOWED_SIGMAS, FOLLOWED_STEPS};

/// Projection of data on the orthogonal complement of the base parameters' derivatives.
pub struct Projector {
    weights: DVector<f64>,
    base: Option<DMatrix<f64>>,
    /// Projected residuals of the base fit.
    pub residuals: DVector<f64>,
}

/// Response of the data to an effect at one probe.
#[derive(Clone, Debug)]
pub struct Response {
    /// The probe.
    pub probe: Probe,
    /// Projected change of the whitened residuals from null to probe.
    pub change: DVector<f64>,
    /// The change after the base parameters have followed the effect as far as they can; their response to an effect of
    /// this size may differ from that to a small one.
    pub followed: Vec<f64>,
    /// Shift of the base parameters that follow [coordinates]; empty if they do not move.
    pub shift: Vec<f64>,
    /// The change at unchanged base parameters.
    pub raw: Vec<f64>,
    /// Range of extrapolation of the change, as least and greatest multiple of the distance from null to probe.
    pub reach: [f64; 2],
}

/// A base fit beside which effects are looked at.
#[derive(Clone, Copy)]
pub struct Baseline<'a> {
    /// The data.
    pub evidence: &'a dyn Evidence,
    /// The fit.
    pub base: &'a Fit,
    /// Projection for its base parameters.
    pub projector: &'a Projector,
}

impl Projector {
    /// Builds the projection from a base fit with its derivatives.
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

    /// Weights data and projects them.
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

/// Range of multiples of the distance from null to probed value, within the parameter's range and near the probe.
fn reach(coordinate: &Coordinate, probed: f64) -> [f64; 2] {
    let [least, greatest] = coordinate.reach();
    let null = coordinate.slot.null.unwrap_or(0.0);
    if !(least..=greatest).contains(&null) {
        return [0.0, EXTRAPOLATION_MOST];
    }
    let mut ends =
        [least, greatest].map(|end| ((end - null) / (probed - null)).clamp(-EXTRAPOLATION_MOST, EXTRAPOLATION_MOST));
    ends.sort_by(f64::total_cmp);
    ends
}

impl Response {
    /// Returns true if the change is distinct from the changes by base parameters.
    pub fn is_distinct(&self) -> bool {
        let raw = self.raw.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.change.norm() > DISTINCT_CHANGE_SHARE * raw && self.change.norm() > 0.0
    }

    /// Multiple of the distance from null to probe at which χ² is least in a linear extrapolation.
    pub(super) fn wanted(&self, residuals: &DVector<f64>) -> f64 {
        let square = self.change.norm_squared();
        if square == 0.0 { 0.0 } else { -self.change.dot(residuals) / square }
    }

    /// The same within the reach, and the fall of χ² there.
    pub fn optimum(&self, residuals: &DVector<f64>) -> (f64, f64) {
        let share = self.wanted(residuals).clamp(self.reach[0], self.reach[1]);
        (share, -2.0 * share * self.change.dot(residuals) - share * share * self.change.norm_squared())
    }

    /// Ratio by which its optimum is off the probe; infinite if the optimum is at the null.
    pub(super) fn extrapolation(&self, residuals: &DVector<f64>) -> f64 {
        if self.optimum(residuals).0 == 0.0 { f64::INFINITY } else { self.wanted(residuals).abs().ln().abs() }
    }
}

impl Baseline<'_> {
    /// Simulates a probe with fixed base parameters, then with those that follow the effect; `None` if this fails.
    pub(super) fn at(&self, candidate: &Candidate, probe: &Probe) -> Option<Response> {
        let seen = |shift: &[f64]| {
            let model = shifted(candidate.at(&probe.values), self.base, shift);
            let residuals = self.evidence.residuals(&model, Split::Calibration).ok()?;
            Some(residuals.iter().zip(&self.base.residuals).map(|(b, a)| b - a).collect::<Vec<f64>>())
        };
        let raw = seen(&[])?;
        let (mut followed, mut shift) = (raw.clone(), Vec::new());
        for _ in 0..FOLLOWED_STEPS {
            let Some((step, taken_up)) = self.base.following(&followed) else { break };
            if taken_up < FOLLOWED_SIGMAS * FOLLOWED_SIGMAS {
                break;
            }
            let farther: Vec<f64> = step.iter().enumerate().map(|(k, s)| s + shift.get(k).unwrap_or(&0.0)).collect();
            let Some(there) = seen(&farther).filter(|there| robust_sum(there) < robust_sum(&followed)) else { break };
            (followed, shift) = (there, farther);
        }
        let reach = reach(&candidate.coordinates[probe.amplitude], probe.values[probe.amplitude]);
        let change = self.projector.project(&followed);
        Some(Response { probe: probe.clone(), change, followed, shift, raw, reach })
    }
}

/// Returns a model with the parameters of a fit shifted from their fitted values; trailing shifts may be omitted.
pub(super) fn shifted(mut model: CompiledModel, fit: &Fit, shift: &[f64]) -> CompiledModel {
    let coordinates = Coordinate::of(&model, |_| true);
    for ((own, at), shift) in fit.coordinates.iter().zip(&fit.at).zip(shift) {
        if let Some(coordinate) = coordinates.iter().find(|coordinate| coordinate.slot.name() == own.slot.name()) {
            model.set(coordinate.index, coordinate.value(coordinate.clamped(at + shift)));
        }
    }
    model
}
