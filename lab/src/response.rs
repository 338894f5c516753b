//! What an effect changes beside what the base parameters can change already.

use effects::CompiledModel;
use nalgebra::{DMatrix, DVector, QR};

use super::coordinates::Coordinate;
use super::evidence::{Evidence, Split};
use super::fit::{Fit, robust_sum, weights};
use super::probe::{Candidate, Probe};
use crate::criteria::{DISTINCT_CHANGE_SHARE, EXTRAPOLATION_MOST, FOLLOWED_SIGMAS, FOLLOWED_STEPS};

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
    /// The change with the base parameters where they follow the effect as far as they can: what they do to an effect of this
    /// size is not what they do to a small one.
    pub followed: Vec<f64>,
    /// How far they follow [coordinates]; empty where they stay.
    pub shift: Vec<f64>,
    /// The change with the base parameters as they were.
    pub raw: Vec<f64>,
    /// Shares of the way from null to probe to which the change may be extrapolated, least and greatest.
    pub reach: [f64; 2],
}

/// A base fit that effects are looked at beside.
#[derive(Clone, Copy)]
pub struct Look<'a> {
    /// The data.
    pub evidence: &'a dyn Evidence,
    /// The fit.
    pub base: &'a Fit,
    /// What the base parameters can explain.
    pub projector: &'a Projector,
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
    /// Whether anything is left of the change beside the base parameters' changes.
    pub fn is_distinct(&self) -> bool {
        let raw = self.raw.iter().map(|x| x * x).sum::<f64>().sqrt();
        self.change.norm() > DISTINCT_CHANGE_SHARE * raw && self.change.norm() > 0.0
    }

    /// Share of the way from null to probe at which the sum of squares were least if the effect went on as to the probe.
    pub(super) fn wanted(&self, residuals: &DVector<f64>) -> f64 {
        let square = self.change.norm_squared();
        if square == 0.0 { 0.0 } else { -self.change.dot(residuals) / square }
    }

    /// Share of the way from null to probe, within its reach, at which the sum of squares is least, and its fall.
    pub fn optimum(&self, residuals: &DVector<f64>) -> (f64, f64) {
        let share = self.wanted(residuals).clamp(self.reach[0], self.reach[1]);
        (share, -2.0 * share * self.change.dot(residuals) - share * share * self.change.norm_squared())
    }

    /// How far its optimum is from the probe, in ratios; infinite where that is the null.
    pub(super) fn extrapolation(&self, residuals: &DVector<f64>) -> f64 {
        if self.optimum(residuals).0 == 0.0 { f64::INFINITY } else { self.wanted(residuals).abs().ln().abs() }
    }
}

impl Look<'_> {
    /// What an effect changes at a probe, first beside the base parameters as they are, then where they follow it; `None` where
    /// it cannot be simulated.
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

/// A model with the parameters of a fit shifted from where the fit has them; the shift of those at the end may be left out.
pub(super) fn shifted(mut model: CompiledModel, fit: &Fit, shift: &[f64]) -> CompiledModel {
    let coordinates = Coordinate::of(&model, |_| true);
    for ((own, at), shift) in fit.coordinates.iter().zip(&fit.at).zip(shift) {
        if let Some(coordinate) = coordinates.iter().find(|coordinate| coordinate.slot.name() == own.slot.name()) {
            model.set(coordinate.index, coordinate.value(coordinate.clamped(at + shift)));
        }
    }
    model
}
