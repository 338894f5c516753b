//! Two effects found together, where the best single one is no adequate fit. A third effect that mimics parts of both
//! may fit better than either alone, and either may degrade held-out data until the other is added.
//!
//! The first look gives the change by every effect, so the Δχ² of each pair follows from linear algebra: beside the
//! base model, and beside each effect that was fitted alone. The most promising pairs are fitted. Beside a strong
//! effect another may act differently from this estimate: where a significant effect explains most of the misfit but
//! cannot be the only one, all others that were fitted alone are also fitted beside it.

use std::collections::BTreeSet;

use effects::{Library, Model};
use nalgebra::DVector;
use rayon::prelude::*;

use super::coordinates::Coordinate;
use super::cross_validation::{CrossValidation, Prediction};
use super::diagnose::{OnProgress, spread, with_values};
use super::evidence::{Evidence, EvidenceError, Split};
use super::finding::{Against, Finding};
use super::fit::{Fit, FitOptions};
use super::leaders::{Contender, with_leaders_completed};
use super::model_weights::probabilities;
use super::probe::Candidate;
use super::response::{Projector, Response};
use super::round::Round;
use super::screen::Screened;
use super::significance::null_delta_chi2;
use super::space_mapping::{Lattices, Surrogate};
use super::suspect::{QUICK_FIT, REFINED_FIT, Suspect, is_at_far_end};
use crate::criteria::{
    LEAD_CHI2_SHARE, NAMED_PROBABILITY, PAIR_SINE_SQUARED, PAIRS_FITTED, PAIRS_PER_LEAD, PAIRS_REFINED,
    PARTNER_FIT_DERIVATIVES, PARTNER_FIT_STEPS, PARTNERS_REFINED,
};

/// Cost of the fit of another effect beside a significant one.
const PARTNER_FIT: FitOptions = FitOptions { derivatives: PARTNER_FIT_DERIVATIVES, steps: PARTNER_FIT_STEPS };

/// Two effects fitted together.
#[derive(Clone)]
struct Joint {
    /// The effect that is better alone, at the starting values of the joint fit.
    lead: Screened,
    /// The other effect, with the joint fit.
    both: Suspect,
}

/// The pair of effects that describes what a first search could not name, as two successive searches; `None` if there
/// is none, or several that share no effect.
///
/// # Errors
/// If the model cannot be simulated.
pub(super) fn pair(
    evidence: &dyn Evidence,
    first: &Round,
    (model, library): (&Model, &Library),
    (seed, on_progress): (u64, OnProgress),
) -> Result<Option<[Round; 2]>, EvidenceError> {
    let quicker = evidence.quicker();
    let surrogate = quicker.as_deref().and_then(|quicker| Surrogate::around(evidence, quicker, &first.base));
    let lattices = Lattices { usual: evidence, quicker: surrogate.as_ref().map(|surrogate| surrogate as _) };
    let mut joints = fitted(lattices, first, (model, library), on_progress);
    joints.extend(beside_surest(lattices, first, (model, library), on_progress));
    joints.sort_by(|a, b| a.both.fit.chi2.total_cmp(&b.both.fit.chi2));
    let mut known = BTreeSet::new();
    joints.retain(|joint| known.insert(joint.names()));
    let mut joints = with_leaders_completed(lattices, &first.base, joints, seed);
    joints.sort_by(|a, b| a.both.fit.chi2.total_cmp(&b.both.fit.chi2));
    let Some(least) = joints.first() else { return Ok(None) };
    let (folds, spread) = (CrossValidation::new(evidence, &least.both.fit), spread(&least.both.fit.residuals));
    let predictions: Vec<Prediction> = joints.par_iter().map(|joint| folds.prediction(&joint.both.fit)).collect();
    let base = folds.prediction(&first.base);
    let densities: Vec<Vec<f64>> =
        std::iter::once(base).chain(predictions).map(|prediction| prediction.densities).collect();
    let priors: Vec<f64> = std::iter::once(1.0).chain(joints.iter().map(|joint| joint.both.prior())).collect();
    let weights = probabilities(&densities, &priors, seed);
    let mut weighed: Vec<(f64, Joint)> = weights.into_iter().skip(1).zip(joints).collect();
    weighed.sort_by(|a, b| b.0.total_cmp(&a.0));
    let lead = weighed[0].1.lead.candidate.name.clone();
    weighed.retain(|(_, joint)| joint.lead.candidate.name == lead);
    let sure: f64 = weighed.iter().map(|(weight, _)| weight).sum();
    if sure < NAMED_PROBABILITY {
        return Ok(None);
    }
    let joints = weighed.into_iter().map(|(_, joint)| joint).collect();
    let (half, second) = two_searches(evidence, first, joints, (&folds, spread, seed))?;
    let is_adequate = |both: &Finding| {
        let at_end = |c: &Coordinate| is_at_far_end(c, value_of(c, &both.suspect.fit));
        let lead_is_free = !half.suspect.screened.candidate.coordinates.iter().any(at_end);
        lead_is_free && !both.as_searched().standing().is_open()
    };
    if !second.nameable().is_some_and(is_adequate) {
        return Ok(None);
    }
    Ok(Some([halved(first, Finding { probability: sure, ..half }), second]))
}

/// The lead of some pairs fitted alone, and the search beside it, in which each pair's other effect is a finding.
fn two_searches(
    evidence: &dyn Evidence,
    first: &Round,
    joints: Vec<Joint>,
    (folds, spread, seed): (&CrossValidation, f64, u64),
) -> Result<(Finding, Round), EvidenceError> {
    let (lead, left) = (&joints[0].lead, &joints[0].both.fit.residuals);
    let blocks = evidence.blocks(Split::Calibration);
    let draws = null_delta_chi2(&Projector::new(&first.base), &first.screened, left, &blocks, seed);
    let alone = match known(first, lead) {
        Some(alone) => alone.clone(),
        None => Suspect::quick(evidence, &first.base, lead.clone())?,
    };
    let (own, calibration) = (first.spread, &first.calibration);
    let against = Against { base: &first.base, calibration, draws: &draws, folds, spread: own };
    let half = Finding::new(evidence, alone, &against)?;
    let base = half.suspect.fit.clone();
    let calibration = evidence.agreement(&base.model, Split::Calibration)?;
    let against = Against { base: &base, calibration: &calibration, spread, ..against };
    let findings = joints.into_iter().map(|joint| Finding::new(evidence, joint.both, &against));
    let findings = findings.collect::<Result<Vec<_>, _>>()?;
    let half = Finding { calibration: calibration.clone(), is_admissible: true, ..half };
    let second = (base, calibration, half.prediction.clone());
    let second = Round::weighed(evidence, second, (findings, spread), seed);
    Ok((half, second))
}

/// The first search with one half of the pair as its result.
fn halved(first: &Round, half: Finding) -> Round {
    let others = first.findings.iter().filter(|finding| finding.suspect.name() != half.suspect.name());
    let others: Vec<Finding> = others.map(|other| Finding { probability: 0.0, ..other.clone() }).collect();
    Round { findings: std::iter::once(half).chain(others).collect(), is_half: true, ..first.clone() }
}

/// Value of a parameter in a fit that varies it, possibly at another index among the model's parameters.
fn value_of(coordinate: &Coordinate, fit: &Fit) -> f64 {
    let own = fit.coordinates.iter().find(|own| own.slot.name() == coordinate.slot.name());
    own.map_or(f64::NAN, |own| fit.model.value(own.index))
}

impl Joint {
    /// Names of its effects, in alphabetical order.
    fn names(&self) -> [String; 2] {
        let mut names = [self.lead.candidate.name.clone(), self.both.name().to_owned()];
        names.sort();
        names
    }

    /// Ends its fit on the data.
    fn thoroughly(self, lattices: Lattices) -> Self {
        let both = self.both.mapped(lattices, REFINED_FIT).finished(lattices.usual, REFINED_FIT);
        Self { both: Suspect { is_completed: true, ..both }, ..self }
    }
}

impl Contender for Joint {
    fn suspect(&self) -> &Suspect {
        &self.both
    }

    fn completed(self, lattices: Lattices, _: &Fit) -> Self {
        self.thoroughly(lattices)
    }
}

/// An effect as it was fitted alone.
fn known<'a>(first: &'a Round, effect: &Screened) -> Option<&'a Suspect> {
    let alone = first.findings.iter().map(|finding| &finding.suspect);
    alone.into_iter().find(|alone| alone.name() == effect.candidate.name)
}

/// Fits the most promising pairs, the best of them until convergence. Least χ² first.
///
/// - `lattices`: the data, and their surrogate near the base fit
fn fitted(
    lattices: Lattices,
    first: &Round,
    (model, library): (&Model, &Library),
    on_progress: OnProgress,
) -> Vec<Joint> {
    let base = with_values(model, &first.base);
    let fit = |[lead, other]: [Screened; 2]| {
        let alone = known(first, &lead).filter(|alone| alone.at_its_fit().best == lead.best).cloned();
        let begun = alone.map_or_else(|| Suspect::begun(lattices.quick(), &first.base, lead.clone()), Ok).ok()?;
        let with_lead = with_values(&base.clone().with(&lead.candidate.name), &begun.fit);
        let effect = library.find(&other.candidate.name)?;
        let candidate = Candidate::new(lattices.quick(), &with_lead, effect, library).ok()?;
        let both = Suspect::begun(lattices.quick(), &begun.fit, Screened { candidate, ..other }).ok()?;
        on_progress(&format!("{} and {}", lead.candidate.name, both.name()), PAIRS_FITTED, PAIRS_FITTED);
        Some(Joint { lead, both: both.finished(lattices.quick(), QUICK_FIT).evaluated_on(lattices.usual).ok()? })
    };
    to_the_end(lattices, promising(first).into_par_iter().filter_map(fit).collect(), PAIRS_REFINED)
}

/// Fits the best `count` pairs until convergence. Least χ² first.
fn to_the_end(lattices: Lattices, mut joints: Vec<Joint>, count: usize) -> Vec<Joint> {
    let sort = |joints: &mut Vec<Joint>| joints.sort_by(|a, b| a.both.fit.chi2.total_cmp(&b.both.fit.chi2));
    sort(&mut joints);
    let rest = joints.split_off(count.min(joints.len()));
    let mut joints: Vec<Joint> = joints.into_par_iter().map(|joint| joint.thoroughly(lattices)).collect();
    joints.extend(rest);
    sort(&mut joints);
    joints
}

/// A significant effect that explains most of the misfit but cannot be the only one, paired with each other effect that
/// was fitted alone, starting from its fitted values. The best pairs are fitted until convergence.
///
/// - `lattices`: as in [`fitted`]
fn beside_surest(
    lattices: Lattices,
    first: &Round,
    (model, library): (&Model, &Library),
    on_progress: OnProgress,
) -> Vec<Joint> {
    let explains_most = |best: &&Finding| best.suspect.fit.chi2 < LEAD_CHI2_SHARE * first.base.chi2;
    let sure = first.best().filter(|best| best.probability >= NAMED_PROBABILITY);
    let Some(lead) = sure.filter(explains_most).map(|best| &best.suspect) else { return Vec::new() };
    let with_lead = with_values(&model.clone().with(lead.name()), &lead.fit);
    let fit = |other: &Suspect| {
        let effect = library.find(other.name())?;
        let candidate = Candidate::new(lattices.quick(), &with_lead, effect, library).ok()?;
        let both = Suspect::begun(lattices.quick(), &lead.fit, Screened { candidate, ..other.at_its_fit() }).ok()?;
        on_progress(&format!("{} and {}", lead.name(), both.name()), PAIRS_FITTED, PAIRS_FITTED);
        Some(Joint {
            lead: lead.at_its_fit(),
            both: both.finished(lattices.quick(), PARTNER_FIT).evaluated_on(lattices.usual).ok()?,
        })
    };
    let standing = first.findings.par_iter().filter(|finding| finding.share > 0.0);
    let others = standing.map(|finding| &finding.suspect);
    let joints = others.filter(|other| other.name() != lead.name()).filter_map(fit).collect();
    to_the_end(lattices, joints, PARTNERS_REFINED)
}

/// A pair before it is fitted: lead and other effect at their expected best values.
struct Promise {
    effects: [Screened; 2],
    /// Expected χ².
    left: f64,
}

/// The most promising pairs, a few for each lead.
fn promising(first: &Round) -> Vec<[Screened; 2]> {
    let mut promises = beside_fitted(first);
    promises.extend(beside_base(first));
    promises.sort_by(|a, b| a.left.total_cmp(&b.left));
    let mut chosen: Vec<[Screened; 2]> = Vec::new();
    for Promise { effects, .. } in promises {
        let names = |pair: &[Screened; 2]| pair.each_ref().map(|effect| effect.candidate.name.clone());
        let [lead, other] = names(&effects);
        let known: Vec<[String; 2]> = chosen.iter().map(names).collect();
        let is_new = known.iter().all(|[a, b]| [a, b] != [&lead, &other] && [b, a] != [&lead, &other]);
        if is_new && known.iter().filter(|[a, _]| *a == lead).count() < PAIRS_PER_LEAD {
            chosen.push(effects);
        }
    }
    chosen.truncate(PAIRS_FITTED);
    chosen
}

/// Each effect that was fitted alone, with each other one beside it, whose changes are those beside the base model.
fn beside_fitted(first: &Round) -> Vec<Promise> {
    let with = |finding: &Finding| {
        let lead = &finding.suspect;
        let projector = Projector::new(&lead.fit);
        let others = first.screened.iter().filter(|other| other.candidate.name != lead.name() && first.stands(other));
        let beside = others.filter_map(|other| {
            let other = other.clone().beside(&projector);
            let left = lead.fit.chi2 - other.delta_chi2;
            (other.delta_chi2 > 0.0).then(|| Promise { effects: [lead.at_its_fit(), other], left })
        });
        beside.collect::<Vec<_>>()
    };
    first.findings.par_iter().filter(|finding| finding.share > 0.0).flat_map(with).collect()
}

/// All pairs at the jointly best amplitudes of their probes beside the base model; the lead is the effect with the
/// lower χ² alone.
fn beside_base(first: &Round) -> Vec<Promise> {
    let residuals = &Projector::new(&first.base).residuals;
    let alone =
        |effect: &Screened| known(first, effect).map_or(first.base.chi2 - effect.delta_chi2, |alone| alone.fit.chi2);
    let mut promises = Vec::new();
    let standing: Vec<&Screened> = first.screened.iter().filter(|screened| first.stands(screened)).collect();
    for (at, &a) in standing.iter().enumerate() {
        for &b in &standing[at + 1..] {
            let effects = if alone(a) <= alone(b) { [a, b] } else { [b, a] };
            let shares = couples(effects).filter_map(|couple| together(residuals, couple));
            promises.extend(shares.max_by(|a, b| a.delta_chi2.total_cmp(&b.delta_chi2)).map(|best| (effects, best)));
        }
    }
    promises.sort_by(|a, b| b.1.delta_chi2.total_cmp(&a.1.delta_chi2));
    promises.truncate(PAIRS_FITTED);
    let promise = |(effects, together): ([&Screened; 2], Together)| Promise {
        effects: [0, 1].map(|k| effects[k].clone().moved_to(together.responses[k], together.shares[k])),
        left: first.base.chi2 - together.delta_chi2,
    };
    promises.into_iter().map(promise).collect()
}

/// All combinations of a probe of one effect with one of another.
fn couples<'a>([a, b]: [&'a Screened; 2]) -> impl Iterator<Item = [&'a Response; 2]> {
    let distinct = |effect: &'a Screened| effect.responses.iter().flatten().filter(|response| response.is_distinct());
    distinct(a).flat_map(move |a| distinct(b).map(move |b| [a, b]))
}

/// Jointly best amplitudes of two probes.
struct Together<'a> {
    responses: [&'a Response; 2],
    shares: [f64; 2],
    /// Expected fall of χ².
    delta_chi2: f64,
}

/// The best amplitudes of two probes, each within its reach; `None` where their changes are nearly collinear.
fn together<'a>(residuals: &DVector<f64>, responses: [&'a Response; 2]) -> Option<Together<'a>> {
    let [a, b] = responses.map(|response| &response.change);
    let (aa, bb, ab) = (a.norm_squared(), b.norm_squared(), a.dot(b));
    let (ar, br) = (a.dot(residuals), b.dot(residuals));
    let apart = aa * bb - ab * ab;
    if apart <= PAIR_SINE_SQUARED * aa * bb {
        return None;
    }
    let within = |k: usize, share: f64| share.clamp(responses[k].reach[0], responses[k].reach[1]);
    let (s, t) = ((br * ab - ar * bb) / apart, (ar * ab - br * aa) / apart);
    let held = (within(0, s), within(1, t));
    let ends = [(held.0, within(1, -(br + held.0 * ab) / bb)), (within(0, -(ar + held.1 * ab) / aa), held.1)];
    let delta_chi2 = |(s, t): (f64, f64)| -(2.0 * (s * ar + t * br) + s * s * aa + 2.0 * s * t * ab + t * t * bb);
    let best = if delta_chi2(ends[0]) >= delta_chi2(ends[1]) { ends[0] } else { ends[1] };
    Some(Together { responses, shares: [best.0, best.1], delta_chi2: delta_chi2(best) })
}
