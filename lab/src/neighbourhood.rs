//! A local minimum of a model, and what shows near it.

use std::sync::atomic::{AtomicUsize, Ordering};

use effects::{Library, Model, candidates};
use rayon::prelude::*;

use super::diagnose::{OnProgress, with_values};
use super::evidence::Evidence;
use super::fit::Fit;
use super::probe::Candidate;
use super::response::{Baseline, Projector};
use super::screen::Screened;
use super::space_mapping::Surrogate;
use super::totals::Totals;

/// A local minimum of a model, with a first look at every effect beside it.
pub(super) struct Neighbourhood<'a> {
    /// The minimum.
    pub(super) place: Fit,
    /// Surrogate of the data near it.
    pub(super) surrogate: Option<Surrogate<'a>>,
    /// First looks at all effects, by name.
    pub(super) screened: Vec<Screened>,
}

impl<'a> Neighbourhood<'a> {
    /// Takes the first looks, on the faster lattice if there is one.
    pub(super) fn new(
        (evidence, quicker): (&'a dyn Evidence, Option<&'a dyn Totals>),
        (model, place): (&Model, Fit),
        library: &Library,
        progress: OnProgress,
    ) -> Self {
        let surrogate = quicker.and_then(|quicker| Surrogate::around(evidence, quicker, &place));
        let quick: &dyn Evidence = surrogate.as_ref().map_or(evidence, |surrogate| surrogate);
        let projector = Projector::new(&place);
        let baseline = Baseline { evidence: quick, base: &place, projector: &projector };
        let model = with_values(model, &place);
        let tried = candidates(&model, library).into_iter().filter(|effect| evidence.is_blind_to(effect).is_none());
        let known: Vec<String> = model.effects.iter().map(|part| evidence.family(&part.name)).collect();
        let tried = tried.filter(|effect| !known.contains(&evidence.family(&effect.name)));
        let tried: Vec<Candidate> =
            tried.filter_map(|effect| Candidate::new(evidence, &model, effect, library).ok()).collect();
        let (count, done) = (tried.len(), AtomicUsize::new(0));
        let screen = |candidate: Candidate| {
            let name = candidate.name.clone();
            let screened = Screened::new(&baseline, candidate);
            progress(&name, 1 + done.fetch_add(1, Ordering::Relaxed), count);
            screened
        };
        let screened = tried.into_par_iter().map(screen).collect();
        Self { place, surrogate, screened }
    }

    /// The minimum beside which an effect is expected to leave the lower χ². A model that lacks something may have its
    /// least χ² where it hides what it lacks; the effect then shows beside another minimum.
    pub(super) fn or(self, other: Self) -> Self {
        let least = |own: &Self| {
            let looks = own.screened.iter().filter(|look| look.candidate.explains());
            own.place.chi2 - looks.map(|look| look.delta_chi2).fold(0.0, f64::max)
        };
        if least(&other) < least(&self) { other } else { self }
    }
}
