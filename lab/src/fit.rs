//! Levenberg-Marquardt fit of a model to data, within bounds. Nuisance degrees of freedom are part of the whitening, so
//! every fit is joint.

mod steps;

use effects::CompiledModel;
use nalgebra::{Cholesky, DMatrix, DVector};

use super::coordinates::{Bound, Coordinate, moved};
use super::evidence::{Evidence, EvidenceError, Split};
use super::uncertainty::ErrorTerms;
use crate::criteria::{FIT_DERIVATIVES, FIT_STEPS, HUBER_CONSTANT, RESTART_CHI2_PER_DATUM, RESTART_DISTANCE};

/// Damping: initial value, and factors after good and bad steps.
const DAMPING: (f64, f64, f64) = (1e-3, 0.2, 8.0);
/// Longest step [coordinates].
const LONGEST_MOVE: f64 = 1.5;

/// Cost limits of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitOptions {
    /// Most recomputations of the derivatives; between them, steps update the derivatives (Broyden 1965).
    pub derivatives: usize,
    /// Most steps.
    pub steps: usize,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { derivatives: FIT_DERIVATIVES, steps: FIT_STEPS }
    }
}

/// A fitted model.
#[derive(Clone)]
pub struct Fit {
    /// The model at the best values.
    pub model: CompiledModel,
    /// Coordinates of the varied parameters.
    pub coordinates: Vec<Coordinate>,
    /// Best values [coordinates].
    pub at: Vec<f64>,
    /// Whitened residuals at the best values.
    pub residuals: Vec<f64>,
    /// Derivatives of the whitened residuals, shape [data, coordinates].
    pub jacobian: DMatrix<f64>,
    /// Robust sum of squares.
    pub chi2: f64,
    /// True if the last step predicted no further fall.
    pub converged: bool,
    /// Number of simulations of the data.
    pub runs: usize,
    /// Starting values [coordinates].
    pub(super) begun: Vec<f64>,
    /// Contributions to the parameters' covariance beside the curvature of χ²; `None` before the first step.
    pub(super) error_terms: Option<ErrorTerms>,
}

/// A simulated point in coordinate space.
pub(super) struct Place {
    /// Coordinates.
    pub(super) at: Vec<f64>,
    /// Whitened residuals at the coordinates.
    pub(super) residuals: Vec<f64>,
    /// Robust sum of squares.
    pub(super) chi2: f64,
}

impl Place {
    /// Norm of the difference of the whitened data from those at another place [σ].
    pub(super) fn distance(&self, other: &Self) -> f64 {
        self.residuals.iter().zip(&other.residuals).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }
}

/// Estimate of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    /// The parameter.
    pub coordinate: Coordinate,
    /// Best value [SI].
    pub value: f64,
    /// Standard deviation [coordinates]; infinite if the data do not determine it.
    pub sigma: f64,
    /// The bound on which it lies.
    pub bound: Option<Bound>,
}

/// Sum of squares in which outliers count linearly (Huber 1964).
pub fn robust_sum(residuals: &[f64]) -> f64 {
    let rho =
        |r: &f64| if r.abs() <= HUBER_CONSTANT { r * r } else { HUBER_CONSTANT * (2.0 * r.abs() - HUBER_CONSTANT) };
    residuals.iter().map(rho).sum()
}

/// Weights of iteratively reweighted least squares for the robust sum.
pub(super) fn weights(residuals: &[f64]) -> DVector<f64> {
    DVector::from_iterator(residuals.len(), residuals.iter().map(|r| (HUBER_CONSTANT / r.abs()).min(1.0).sqrt()))
}

impl Fit {
    /// Fits the calibration data, starting from the model's values.
    ///
    /// # Errors
    /// If the model cannot be simulated at its starting values.
    pub fn new(
        evidence: &dyn Evidence,
        model: &CompiledModel,
        coordinates: Vec<Coordinate>,
        options: FitOptions,
    ) -> Result<Self, EvidenceError> {
        Ok(Self::unfitted(evidence, model, coordinates)?.refined(evidence, options))
    }

    /// The model without any step; derivatives are not yet computed.
    ///
    /// # Errors
    /// If it cannot be simulated.
    pub fn unfitted(
        evidence: &dyn Evidence,
        model: &CompiledModel,
        coordinates: Vec<Coordinate>,
    ) -> Result<Self, EvidenceError> {
        let at: Vec<f64> = coordinates.iter().map(|c| c.clamped(c.from_value(model.value(c.index)))).collect();
        let model = moved(model, &coordinates, &at);
        let residuals = evidence.residuals(&model, Split::Calibration)?;
        let chi2 = robust_sum(&residuals);
        let jacobian = DMatrix::zeros(residuals.len(), coordinates.len());
        let begun = at.clone();
        Ok(Self {
            model,
            coordinates,
            at,
            residuals,
            jacobian,
            chi2,
            converged: false,
            runs: 1,
            begun,
            error_terms: None,
        })
    }

    /// Continues the fit on the present data, and determines the covariance contributions of [`ErrorTerms`].
    pub(super) fn finished(self, evidence: &dyn Evidence, options: FitOptions) -> Self {
        let fit = Self { converged: false, ..self }.stepped(evidence, options);
        // A fitted model can be simulated.
        let smooth = evidence.smooth_errors(&fit.model).unwrap_or_else(|_| DMatrix::zeros(fit.residuals.len(), 0));
        let errors = (&evidence.lattice_field()[..], &smooth);
        let error_terms = ErrorTerms::of(&fit, &evidence.blocks(Split::Calibration), errors);
        Self { error_terms: Some(error_terms), ..fit }
    }

    /// Evaluates the same values on data that have changed slightly and may differ in number; derivatives are
    /// recomputed along the parameters.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn reevaluated(self, evidence: &dyn Evidence) -> Result<Self, EvidenceError> {
        let mut fit = self.evaluated_on(evidence)?;
        (fit.jacobian, fit.converged) = (DMatrix::zeros(fit.residuals.len(), fit.at.len()), false);
        fit.differentiate(evidence, &(0..fit.at.len()).collect::<Vec<_>>());
        Ok(fit)
    }

    /// The same values with other residuals.
    pub(super) fn with_residuals(self, residuals: Vec<f64>) -> Self {
        Self { chi2: robust_sum(&residuals), residuals, ..self }
    }

    /// True if χ² is so large that there may be several local minima.
    pub(super) fn is_poor(&self) -> bool {
        self.chi2_per_datum() > RESTART_CHI2_PER_DATUM
    }

    /// Robust sum of squares per datum.
    pub(super) fn chi2_per_datum(&self) -> f64 {
        self.chi2 / self.residuals.len() as f64
    }

    /// The same fit restarted at another place [coordinates].
    ///
    /// # Errors
    /// If the model cannot be simulated there.
    pub(super) fn begun_at(
        &self,
        evidence: &dyn Evidence,
        place: &[f64],
        options: FitOptions,
    ) -> Result<Self, EvidenceError> {
        let model = moved(&self.model, &self.coordinates, place);
        Self::new(evidence, &model, self.coordinates.clone(), options)
    }

    /// This fit's values, with the coordinates of the smaller model at that model's starting values.
    pub(super) fn with_beginning_of(&self, base: &Self) -> Vec<f64> {
        let begun = |(coordinate, at): (&Coordinate, &f64)| {
            let name = coordinate.slot.name();
            let place = base.coordinates.iter().position(|own| own.slot.name() == name);
            place.map_or(*at, |place| base.begun[place])
        };
        self.coordinates.iter().zip(&self.at).map(begun).collect()
    }

    /// Places on both sides along the direction that the data determine least.
    pub(super) fn both_sides(&self) -> Vec<Vec<f64>> {
        let informed: Vec<usize> = (0..self.at.len()).filter(|&k| self.jacobian.column(k).norm() > 0.0).collect();
        if informed.is_empty() {
            return Vec::new();
        }
        let jacobian = self.jacobian.select_columns(&informed);
        let directions = jacobian.tr_mul(&jacobian).symmetric_eigen();
        let way = directions.eigenvectors.column(directions.eigenvalues.imin());
        let beside = |side: f64| {
            let mut at = self.at.clone();
            for (&k, way) in informed.iter().zip(way.iter().map(|share| side * RESTART_DISTANCE * share / way.amax())) {
                at[k] = self.coordinates[k].clamped(at[k] + way);
            }
            at
        };
        [-1.0, 1.0].map(beside).into_iter().filter(|at| *at != self.at).collect()
    }

    /// Derivatives along a coordinate, if this fit has it.
    pub fn column(&self, coordinate: &Coordinate) -> Option<DVector<f64>> {
        let place = self.coordinates.iter().position(|own| own.slot.name() == coordinate.slot.name())?;
        Some(self.jacobian.column(place).into_owned())
    }

    /// As [`Fit::place`], counting the simulation.
    fn tried(&mut self, evidence: &dyn Evidence, at: Vec<f64>) -> Option<Place> {
        self.runs += 1;
        self.place(evidence, at)
    }

    /// Simulates another place; `None` if the model cannot be simulated there.
    pub(super) fn place(&self, evidence: &dyn Evidence, at: Vec<f64>) -> Option<Place> {
        let residuals = evidence.residuals(&moved(&self.model, &self.coordinates, &at), Split::Calibration).ok()?;
        Some(Place { chi2: robust_sum(&residuals), at, residuals })
    }

    /// The present place of the fit.
    pub(super) fn here(&self) -> Place {
        Place { at: self.at.clone(), residuals: self.residuals.clone(), chi2: self.chi2 }
    }

    /// Moves to a place and keeps the derivatives.
    pub(super) fn go_to(&mut self, place: Place) {
        self.model = moved(&self.model, &self.coordinates, &place.at);
        (self.at, self.residuals, self.chi2) = (place.at, place.residuals, place.chi2);
    }

    /// Shift of the coordinates that best compensates a change of the residuals, and the fall of the change's sum of
    /// squares.
    pub(super) fn following(&self, change: &[f64]) -> Option<(Vec<f64>, f64)> {
        let (at, taken_up) = self.step(change, DAMPING.0)?;
        Some((at.iter().zip(&self.at).map(|(b, a)| b - a).collect(), taken_up))
    }

    /// End of a damped step against residuals, within the bounds, and the predicted fall of their sum of squares.
    fn step(&self, residuals: &[f64], damping: f64) -> Option<(Vec<f64>, f64)> {
        let weights = weights(&self.residuals);
        let mut jacobian = self.jacobian.clone();
        jacobian.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weights));
        let residuals = DVector::from_column_slice(residuals).component_mul(&weights);
        let mut held = vec![false; self.at.len()];
        loop {
            let free: Vec<usize> =
                (0..self.at.len()).filter(|&k| !held[k] && jacobian.column(k).norm() > 0.0).collect();
            if free.is_empty() {
                return None;
            }
            let active = jacobian.select_columns(&free);
            let mut normal = active.tr_mul(&active);
            (0..free.len()).for_each(|k| normal[(k, k)] *= 1.0 + damping);
            let way = Cholesky::new(normal)?.solve(&active.tr_mul(&residuals));
            let shorten = (LONGEST_MOVE / way.amax()).min(1.0);
            let mut at = self.at.clone();
            let mut outward = None;
            for (i, &k) in free.iter().enumerate() {
                at[k] = self.coordinates[k].clamped(self.at[k] - shorten * way[i]);
                if at[k] == self.at[k] && way[i] != 0.0 {
                    outward = Some(k);
                }
            }
            if let Some(k) = outward {
                held[k] = true;
                continue;
            }
            let moved = DVector::from_iterator(at.len(), at.iter().zip(&self.at).map(|(b, a)| b - a));
            let promise = residuals.norm_squared() - (&residuals + &jacobian * moved).norm_squared();
            return Some((at, promise));
        }
    }

    /// Estimates of all parameters; `spread` widens the intervals where residuals exceed noise.
    pub fn estimates(&self, spread: f64) -> Vec<Estimate> {
        let covariance = self.covariance(spread);
        let estimate = |(k, coordinate): (usize, &Coordinate)| {
            let sigma = covariance.as_ref().map_or(f64::INFINITY, |c| c[(k, k)].max(0.0).sqrt());
            let bound = coordinate.bound(self.at[k]);
            Estimate { coordinate: coordinate.clone(), value: coordinate.value(self.at[k]), sigma, bound }
        };
        self.coordinates.iter().enumerate().map(estimate).collect()
    }

    /// For each coordinate, true if it lies on a bound and the next step would cross it.
    pub fn held_back(&self) -> Vec<bool> {
        let weights = weights(&self.residuals);
        let mut jacobian = self.jacobian.clone();
        jacobian.column_iter_mut().for_each(|mut column| column.component_mul_assign(&weights));
        let residuals = DVector::from_column_slice(&self.residuals).component_mul(&weights);
        let way = jacobian.svd(true, true).solve(&residuals, 1e-9).unwrap_or_else(|_| DVector::zeros(self.at.len()));
        let held = |(k, coordinate): (usize, &Coordinate)| match coordinate.bound(self.at[k]) {
            Some(Bound::Least) => way[k] > 0.0,
            Some(Bound::Greatest) => way[k] < 0.0,
            None => false,
        };
        self.coordinates.iter().enumerate().map(held).collect()
    }
}

#[cfg(test)]
mod tests;
