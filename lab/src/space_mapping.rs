//! Fits by space mapping (Bandler et al. 2004): steps are taken on a faster lattice, corrected to agree with the usual
//! one at the present fit. The usual lattice evaluates their result, and the surrogate is corrected again.

use effects::CompiledModel;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::coordinates::{Coordinate, moved};
use super::derivatives::{difference, slope};
use super::evidence::{Evidence, EvidenceError, Split};
use super::fit::{Fit, FitOptions, Place};
use super::probe::probe_change;
use super::repredicted::{Prediction, Repredicted};
use super::totals::{Total, Totals};
use crate::criteria::{DERIVATIVE_CHANGE_LEAST, FIT_CONVERGED_DELTA_CHI2, MAPPING_ROUNDS};

/// A faster prediction of data that reproduces the residuals of a fit at its values.
pub(super) type Surrogate<'a> = Repredicted<'a, Mapped<'a>>;

/// A faster prediction with a constant and a linear correction.
pub(super) struct Mapped<'a> {
    quicker: &'a dyn Totals,
    /// Whitened residuals of the fit minus those of the faster prediction at its values.
    offset: Vec<f64>,
    coordinates: Vec<Coordinate>,
    /// Values of the fit [coordinates].
    from: Vec<f64>,
    /// Correction of the derivatives, shape [data, coordinates].
    slope: DMatrix<f64>,
}

impl<'a> Surrogate<'a> {
    /// Corrects the residuals to those of a fit; `None` if its model cannot be predicted by the faster way.
    pub(super) fn at(quicker: &'a dyn Totals, fit: &Fit) -> Option<Self> {
        let own = quicker.residuals(&fit.model, Split::Calibration).ok()?;
        let offset = fit.residuals.iter().zip(own).map(|(usual, quicker)| usual - quicker).collect();
        let slope = DMatrix::zeros(fit.residuals.len(), fit.at.len());
        let (coordinates, from) = (fit.coordinates.clone(), fit.at.clone());
        Some(Self { data: quicker, prediction: Mapped { quicker, offset, coordinates, from, slope } })
    }

    /// Corrects the residuals to those of a fit, and their linear change by the discrepancy between both lattices at pairs
    /// of places around the fit; `None` as in [`Self::at`].
    ///
    /// The places change the data as much as probes of effects do: over shorter steps the unevenness of the faster
    /// lattice would pass for a derivative.
    pub(super) fn around(usual: &dyn Evidence, quicker: &'a dyn Totals, fit: &Fit) -> Option<Self> {
        let surrogate = Self::at(quicker, fit)?;
        let pairs = fit.pairs_around(usual, probe_change(fit.chi2.sqrt()));
        let discrepancy = |place: &Place| {
            let quick = quicker.residuals(&moved(&fit.model, &fit.coordinates, &place.at), Split::Calibration).ok()?;
            Some(difference(&place.residuals, &quick))
        };
        let changes: Option<Vec<DVector<f64>>> =
            pairs.par_iter().map(|[a, b]| Some(discrepancy(b)? - discrepancy(a)?)).collect();
        let slope = changes.and_then(|changes| slope(&pairs, &changes));
        Some(if let Some(slope) = slope { surrogate.beside(slope) } else { surrogate })
    }

    /// Adds a correction of the derivatives.
    fn beside(mut self, slope: DMatrix<f64>) -> Self {
        self.prediction.slope = slope;
        self
    }
}

impl Prediction for Mapped<'_> {
    fn residuals(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let mut residuals = self.quicker.residuals(model, split)?;
        if split == Split::Calibration {
            let way = |(own, from): (&Coordinate, &f64)| {
                model.index(&own.slot.name()).map_or(0.0, |index| own.from_value(model.value(index)) - from)
            };
            let way = DVector::from_iterator(self.from.len(), self.coordinates.iter().zip(&self.from).map(way));
            let beside = &self.slope * way;
            let lacking = self.offset.iter().zip(beside.iter()).map(|(offset, beside)| offset + beside);
            residuals.iter_mut().zip(lacking).for_each(|(residual, lacking)| *residual += lacking);
        }
        Ok(residuals)
    }

    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError> {
        self.quicker.totals(model, split)
    }
}

/// Data, and their surrogate for first looks and steps if there is one.
#[derive(Clone, Copy)]
pub(super) struct Lattices<'a> {
    /// The data.
    pub(super) usual: &'a dyn Evidence,
    /// Their surrogate.
    pub(super) quicker: Option<&'a dyn Totals>,
}

impl<'a> Lattices<'a> {
    /// The surrogate, or else the data.
    pub(super) fn quick(self) -> &'a dyn Evidence {
        self.quicker.map_or(self.usual, |quicker| quicker)
    }
}

impl Fit {
    /// Continues the fit, on a surrogate if possible, and ends on the data themselves.
    pub fn refined(self, evidence: &dyn Evidence, options: FitOptions) -> Self {
        // A few steps with known derivatives are not worth a surrogate.
        match evidence.quicker().filter(|_| options.derivatives > 0) {
            Some(quicker) => self.mapped(evidence, &*quicker, options).finished(evidence, options),
            None => self.finished(evidence, options),
        }
    }

    /// Takes steps on a surrogate and evaluates their result on the usual lattice, until the two agree there or no
    /// further fall is predicted. Residuals and χ² are those of the data, derivatives those of the surrogate.
    pub(super) fn mapped(mut self, evidence: &dyn Evidence, quicker: &dyn Totals, options: FitOptions) -> Self {
        let mut slope = DMatrix::zeros(self.residuals.len(), self.at.len());
        for _ in 0..MAPPING_ROUNDS {
            let Some(surrogate) = Surrogate::at(quicker, &self) else { break };
            let there = self.clone().stepped(&surrogate.beside(slope.clone()), options);
            if there.at == self.at {
                return there;
            }
            let Ok(seen) = there.clone().evaluated_on(evidence) else { break };
            let missing = missing_slope(&self, &there, &seen);
            let worth = FIT_CONVERGED_DELTA_CHI2 * self.chi2_per_datum().max(1.0);
            let is_right = seen.chi2 < self.chi2 && (seen.chi2 - there.chi2).abs() < worth;
            let lower = if seen.chi2 < self.chi2 { seen } else { Self { jacobian: there.jacobian, ..self } };
            self = Self { runs: there.runs + 1, converged: there.converged, ..lower };
            let Some(missing) = missing.filter(|_| !is_right) else { return self };
            self.jacobian += &missing;
            slope += missing;
        }
        Self { converged: false, ..self }
    }

    /// The same values with the residuals of other data, or on another lattice; derivatives stay.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn evaluated_on(self, evidence: &dyn Evidence) -> Result<Self, EvidenceError> {
        let residuals = evidence.residuals(&self.model, Split::Calibration)?;
        Ok(self.with_residuals(residuals))
    }
}

/// Error of a surrogate's derivatives along the step from one fit to another (Broyden 1965), from its residuals there
/// and the observed ones; `None` for a step that changes the data by no more than the simulation's numerical noise.
fn missing_slope(from: &Fit, there: &Fit, seen: &Fit) -> Option<DMatrix<f64>> {
    if difference(&seen.residuals, &from.residuals).norm() < DERIVATIVE_CHANGE_LEAST {
        return None;
    }
    let way = difference(&there.at, &from.at);
    let missing = difference(&seen.residuals, &there.residuals) / way.norm_squared();
    Some(missing * way.transpose())
}
