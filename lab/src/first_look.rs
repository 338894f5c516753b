//! First answer on a model, within a minute: a rough fit of its law on a coarser lattice, and the expected improvement
//! by each effect from the first look. It is no verdict: no effect is fitted, and no p-value is computed.

use effects::{CompiledModel, Library, Model, candidates};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::begin::with_matched_rate;
use super::diagnose::with_values;
use super::error::Result;
use super::evidence::Split;
use super::fit::{Fit, FitOptions};
use super::probe::Candidate;
use super::response::{Baseline, Projector};
use super::space_mapping::Surrogate;
use super::totals::Totals;
use super::verdict::rms;
use crate::criteria::{FIRST_LOOK_EFFECTS, ROUGH_FIT_DERIVATIVES, ROUGH_FIT_STEPS};

/// Cost of the fit.
const ROUGH: FitOptions = FitOptions { derivatives: ROUGH_FIT_DERIVATIVES, steps: ROUGH_FIT_STEPS };

/// An effect and its expected improvement from the first look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Promise {
    /// Name in the library.
    pub name: String,
    /// Expected fall of χ², as a share of the law's χ².
    pub share: f64,
}

/// Result of the first look.
#[derive(Clone)]
pub struct FirstLook {
    /// The fitted law.
    pub law: CompiledModel,
    /// Root mean square residual of the calibration data [unit of errors].
    pub rms: f64,
    /// The most promising effects.
    pub promises: Vec<Promise>,
}

impl FirstLook {
    /// Fits the law of a model roughly and takes a first look at every effect of a library beside it.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn new(evidence: &dyn Totals, model: &Model, library: &Library) -> Result<Self> {
        let compiled = CompiledModel::new(model, library, evidence.rows())?;
        let start = with_matched_rate(evidence, &compiled)?;
        let unfitted = Fit::unfitted(evidence, &start, evidence.coordinates(&start))?;
        let quicker = evidence.quicker();
        let surrogate = quicker.as_deref().and_then(|quicker| Surrogate::at(quicker, &unfitted));
        let quick: &dyn Totals = surrogate.as_ref().map_or(evidence, |surrogate| surrogate);
        let base = Fit::new(quick, &start, quick.coordinates(&start), ROUGH)?;
        let model = with_values(model, &base);
        let projector = Projector::new(&base);
        let baseline = Baseline { evidence: quick, base: &base, projector: &projector };
        let effects = candidates(&model, library).into_iter().filter(|effect| quick.is_blind_to(effect).is_none());
        let tried: Vec<Candidate> =
            effects.filter_map(|effect| Candidate::new(quick, &model, effect, library).ok()).collect();
        let promised = |candidate: Candidate| {
            let share = promised(&baseline, &candidate) / base.chi2;
            Promise { name: candidate.name, share }
        };
        let mut promises: Vec<Promise> = tried.into_par_iter().map(promised).collect();
        promises.retain(|promise| promise.share > 0.0);
        promises.sort_by(|a, b| b.share.total_cmp(&a.share));
        promises.truncate(FIRST_LOOK_EFFECTS);
        let left = evidence.agreement(&base.model, Split::Calibration)?;
        Ok(Self { rms: rms(&left, |scan| scan.rms), promises, law: base.model })
    }
}

/// Expected fall of χ² by an effect: each size at one middle value, its shape as in the library.
fn promised(baseline: &Baseline, candidate: &Candidate) -> f64 {
    let responses = candidate.typical().filter_map(|probe| baseline.at(candidate, probe));
    responses.map(|response| response.optimum(&baseline.projector.residuals).1).fold(0.0, f64::max)
}
