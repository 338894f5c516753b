//! One effect tried beside a model: both are fitted to the same data and compared block by block.
//!
//! Scans are fitted on a coarser lattice first ([`Evidence::quicker`]), so that an attempt takes seconds; both fits end
//! on the usual lattice. Coordinates and sum of squares are those of a calibration.

use effects::{CompiledModel, Library, Model, Scale};
use rayon::prelude::*;

use super::begin::with_matched_rate;
use super::calibration::{at_null, with_values_of};
use super::coordinates::{Coordinate, moved};
use super::cross_validation::CrossValidation;
use super::diagnose::{spread, with_values};
use super::evidence::{Evidence, EvidenceError};
use super::fit::{Fit, FitOptions};
use super::paired::{Better, Paired};
use super::rows::RowEvidence;
use super::scans::ScanEvidence;
use super::space_mapping::Surrogate;
use super::totals::Totals;
use crate::criteria::{
    ATTEMPT_FITS, ATTEMPT_ROUNDS, ATTEMPT_STARTS, FIT_CONVERGED_DELTA_CHI2, QUICK_FIT_DERIVATIVES, QUICK_FIT_STEPS,
    REFINED_FIT_DERIVATIVES, REFINED_FIT_STEPS,
};

/// Cost of a fit until convergence, and of one whose derivatives are known.
const REFINED: FitOptions = FitOptions { derivatives: REFINED_FIT_DERIVATIVES, steps: REFINED_FIT_STEPS };
const LAST: FitOptions = FitOptions { derivatives: 1, steps: REFINED_FIT_STEPS };
const CARRIED: FitOptions = FitOptions { derivatives: QUICK_FIT_DERIVATIVES, steps: QUICK_FIT_STEPS };
/// Factors from a parameter's usual value to its starting values, for ratios and for sizes with a null.
const RATIOS: [f64; 3] = [1.0, 0.2, 5.0];
const SIZES: [f64; 4] = [1.0, -1.0, 3.0, -3.0];

/// A model without and with one more effect, both fitted.
pub struct Attempt {
    /// Fit of the model without the effect.
    pub before: Fit,
    /// Fit of the model with the effect.
    pub with: Fit,
    /// Models with the fitted values: without and with the effect.
    pub models: [Model; 2],
    /// Comparison of both on the same data.
    pub paired: Paired,
    /// Cross-validated log density of whole passes with the effect, minus that without it [nats].
    pub predicts_better_by: f64,
}

impl Attempt {
    /// Returns the better model. Held-out data decide where there are any. The model with the effect must also predict
    /// better the whole passes that are left out of the fit.
    pub fn better(&self) -> Better {
        match self.paired.deciding().better() {
            Better::Second if self.predicts_better_by <= 0.0 => Better::Neither,
            better => better,
        }
    }

    /// Standard deviation of the whitened residuals of the model with the effect; at least one.
    pub fn spread(&self) -> f64 {
        spread(&self.with.residuals)
    }
}

/// A model without and with one more effect, and how to fit them.
pub struct Rivals<'a> {
    /// The model without the effect.
    pub model: &'a CompiledModel,
    /// True if its values come from a fit to the same data.
    pub is_known: bool,
    /// The model with the effect.
    pub larger: &'a CompiledModel,
    /// Name of the added effect.
    pub effect: &'a str,
}

/// Data on which an effect can be tried.
pub trait Tried: Totals {
    /// Fits a model without and with an effect.
    ///
    /// # Errors
    /// If one of them cannot be simulated.
    fn fits(&mut self, rivals: &Rivals) -> Result<[Fit; 2], EvidenceError>;
}

impl Attempt {
    /// Tries an effect of a library beside a model.
    ///
    /// - `is_known`: true if the model's values come from a fit to these data
    ///
    /// # Errors
    /// If the data cannot show the effect, or a model cannot be simulated.
    pub fn new(
        evidence: &mut dyn Tried,
        (model, is_known): (&Model, bool),
        library: &Library,
        effect: &str,
    ) -> Result<Self, super::LabError> {
        let refused = |why: &str| super::LabError::Refused(format!("{effect}: these data cannot show it: {why}"));
        if let Some(why) = library.find(effect).and_then(|effect| evidence.is_blind_to(effect)) {
            return Err(refused(&why));
        }
        let mut larger = model.clone().with(effect);
        if let Some(free) = &mut larger.free {
            let own = library.find(effect).into_iter().flat_map(|effect| &effect.parameters);
            let own = own.filter(|parameter| parameter.free.of(larger.process));
            free.extend(own.map(|parameter| format!("{effect}.{}", parameter.name)));
        }
        let larger = evidence.adapted(larger, library);
        let compiled = |model: &Model| CompiledModel::new(model, library, evidence.rows());
        let (small, large) = (compiled(model)?, compiled(&larger)?);
        if evidence.coordinates(&large).len() == evidence.coordinates(&small).len() {
            return Err(refused("none of its parameters can be fitted"));
        }
        let [before, with] = evidence.fits(&Rivals { model: &small, is_known, larger: &large, effect })?;
        let folds = CrossValidation::by_pass(&*evidence, &with);
        let [without, beside] = [&before, &with].map(|fit| folds.prediction(fit).total());
        let paired = Paired::new(&*evidence, [&before.model, &with.model])?;
        let models = [with_values(model, &before), with_values(&larger, &with)];
        Ok(Self { before, with, models, paired, predicts_better_by: beside - without })
    }
}

impl Tried for RowEvidence<'_> {
    fn fits(&mut self, rivals: &Rivals) -> Result<[Fit; 2], EvidenceError> {
        rivals.fits(self)
    }
}

impl Tried for ScanEvidence<'_> {
    fn fits(&mut self, rivals: &Rivals) -> Result<[Fit; 2], EvidenceError> {
        self.limit_steps(rivals.model)?;
        let start = rivals.start(self)?;
        let unfitted = Fit::unfitted(self, &start, self.coordinates(&start))?;
        let [before, with] = {
            let quicker = self.quicker();
            let surrogate = quicker.as_deref().and_then(|quicker| Surrogate::at(quicker, &unfitted));
            rivals.fits(surrogate.as_ref().map_or(&*self, |surrogate| surrogate))?
        };
        self.measure_simulation_errors(&with.model)?;
        let end = |fit: Fit, options: FitOptions| -> Result<Fit, EvidenceError> {
            Ok(fit.reevaluated(self)?.finished(self, options))
        };
        let (before, with) = rayon::join(|| end(before, CARRIED), || end(with, LAST));
        let (before, with) = (before?, with?);
        if with.chi2 <= before.chi2 {
            return Ok([before, with]);
        }
        let null = at_null(&with_values_of(rivals.larger, &before), rivals.effect);
        let with = Fit::unfitted(self, &null, self.coordinates(&null))?;
        Ok([before, with.refined(self, LAST)])
    }
}

impl Rivals<'_> {
    /// Returns the model with the starting values of its fit: its own, or with the rate matched to the total removal.
    fn start(&self, evidence: &dyn Totals) -> Result<CompiledModel, EvidenceError> {
        if self.is_known { Ok(self.model.clone()) } else { with_matched_rate(evidence, self.model) }
    }

    /// Fits both models; each also starts from the other's result.
    fn fits(&self, evidence: &dyn Totals) -> Result<[Fit; 2], EvidenceError> {
        let start = self.start(evidence)?;
        let before = to_the_end(evidence, Fit::new(evidence, &start, evidence.coordinates(&start), REFINED)?)?;
        let with = self.grown(evidence, &before)?;
        let again = begun(evidence, &with_values_of(self.model, &with), &with)?;
        Ok([lower(before, again), with])
    }

    /// Fits the larger model from several sizes of the effect. The other parameters start at their fitted values and at
    /// their starting values: a model that lacks the effect may have converged far away.
    fn grown(&self, evidence: &dyn Totals, before: &Fit) -> Result<Fit, EvidenceError> {
        let coordinates = evidence.coordinates(self.larger);
        let beginning = moved(&before.model, &before.coordinates, &before.begun);
        let beginning = with_values_of(self.larger, &Fit { model: beginning, ..before.clone() });
        let beside = with_values_of(self.larger, before);
        let null = at_null(&beside, self.effect);
        let starts = [beside, beginning].into_iter().flat_map(|place| sized(&place, &coordinates, self.effect));
        let unfitted = |start: &CompiledModel| Fit::unfitted(evidence, start, coordinates.clone()).ok();
        let mut fits: Vec<Fit> = starts.collect::<Vec<_>>().par_iter().filter_map(unfitted).collect();
        fits.sort_by(|a, b| a.chi2.total_cmp(&b.chi2));
        let best: Vec<CompiledModel> = fits.into_iter().take(ATTEMPT_FITS).map(|fit| fit.model).chain([null]).collect();
        let fits: Vec<Fit> = best.par_iter().filter_map(|start| begun(evidence, start, before).ok()).collect();
        match fits.into_iter().reduce(lower) {
            Some(best) => to_the_end(evidence, best.refined(evidence, REFINED)),
            None => Fit::unfitted(evidence, &best[best.len() - 1], coordinates),
        }
    }
}

/// Refines a model from a starting point, with the derivatives of another fit.
fn begun(evidence: &dyn Totals, start: &CompiledModel, like: &Fit) -> Result<Fit, EvidenceError> {
    let mut fit = Fit::unfitted(evidence, start, evidence.coordinates(start))?;
    fit.borrow_derivatives(evidence, |coordinate| like.column(coordinate));
    Ok(fit.refined(evidence, CARRIED))
}

/// Restarts a fit where it ended until χ² falls no further: on an uneven lattice a step may fail that succeeds with new
/// derivatives.
fn to_the_end(evidence: &dyn Totals, mut fit: Fit) -> Result<Fit, EvidenceError> {
    for _ in 0..ATTEMPT_ROUNDS {
        let again = Fit::new(evidence, &fit.model, fit.coordinates.clone(), REFINED)?;
        let gained = fit.chi2 - again.chi2;
        fit = Fit { begun: fit.begun, ..again };
        if gained < FIT_CONVERGED_DELTA_CHI2 * (fit.chi2 / fit.residuals.len() as f64).max(1.0) {
            break;
        }
    }
    Ok(fit)
}

fn lower(a: Fit, b: Fit) -> Fit {
    if b.chi2 < a.chi2 { b } else { a }
}

/// Returns the model with an effect at up to [`ATTEMPT_STARTS`] combinations of its parameters' starting sizes.
fn sized(model: &CompiledModel, coordinates: &[Coordinate], effect: &str) -> Vec<CompiledModel> {
    let own = coordinates.iter().filter(|coordinate| coordinate.slot.owner == effect);
    let mut starts = vec![model.clone()];
    for coordinate in own {
        let usual = model.value(coordinate.index);
        let factors: &[f64] = if coordinate.slot.scale == Scale::Log { &RATIOS } else { &SIZES };
        let set = |start: &CompiledModel, factor: f64| {
            let mut start = start.clone();
            start.set(coordinate.index, coordinate.value(coordinate.clamped(coordinate.from_value(factor * usual))));
            start
        };
        starts = starts.iter().flat_map(|start| factors.iter().map(move |factor| set(start, *factor))).collect();
        starts.truncate(ATTEMPT_STARTS);
    }
    starts
}
