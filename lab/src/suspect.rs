//! Effects fitted together with the base parameters, and their order.

use effects::Scale;
use rayon::prelude::*;

use super::coordinates::Coordinate;
use super::evidence::{Evidence, EvidenceError};
use super::fit::{Fit, FitOptions};
use super::leaders::Contender;
use super::response::{Projector, shifted};
use super::screen::Screened;
use super::space_mapping::Lattices;
use crate::criteria::{
    EFFECTS_FITTED, EFFECTS_REFINED, FAR_END_RATIO, FITTED_DELTA_CHI2, LAST_FIT_DELTA_CHI2, LAST_FIT_DERIVATIVES,
    LAST_FIT_STEPS, LISTED_ODDS, NULL_RATIO, NULL_SHARE, QUICK_FIT_DERIVATIVES, QUICK_FIT_STEPS,
    REFINED_FIT_DERIVATIVES, REFINED_FIT_STEPS, REFINED_GAIN_SHARE, STARTS_PER_EFFECT,
};

/// Cost of the quick fit.
pub(super) const QUICK_FIT: FitOptions = FitOptions { derivatives: QUICK_FIT_DERIVATIVES, steps: QUICK_FIT_STEPS };
pub(super) const REFINED_FIT: FitOptions =
    FitOptions { derivatives: REFINED_FIT_DERIVATIVES, steps: REFINED_FIT_STEPS };
/// Cost of the last fit, for effects whose refined fit did not converge.
const LAST_FIT: FitOptions = FitOptions { derivatives: LAST_FIT_DERIVATIVES, steps: LAST_FIT_STEPS };

/// An effect at its best values.
#[derive(Clone)]
pub struct Suspect {
    /// The first look at it.
    pub screened: Screened,
    /// Joint fit of base parameters and effect.
    pub fit: Fit,
    /// True once the fit was continued until its end.
    pub(super) is_completed: bool,
}

impl Suspect {
    /// Name of the effect.
    pub fn name(&self) -> &str {
        &self.screened.candidate.name
    }

    /// Number of free parameters of the effect.
    pub fn degrees_of_freedom(&self) -> usize {
        self.screened.candidate.coordinates.len()
    }

    /// The first look with the fitted values as its best ones.
    pub(super) fn at_its_fit(&self) -> Screened {
        let best = self.screened.candidate.coordinates.iter().map(|c| self.fit.model.value(c.index)).collect();
        Screened { best, shift: Vec::new(), ..self.screened.clone() }
    }

    /// Returns true if the effect ended at its null.
    pub fn is_null(&self) -> bool {
        let amplitudes = self.screened.candidate.coordinates.iter().filter(|c| c.slot.null.is_some());
        amplitudes.clone().all(|c| {
            let value = self.fit.model.value(c.index);
            let [least, greatest] = c.reach();
            match (c.slot.null, c.slot.scale) {
                (Some(null), _) if value == null => true,
                (Some(null), Scale::Log) if null.is_infinite() => value >= (1.0 - NULL_RATIO) * greatest,
                (Some(null), Scale::Log) => null <= least && value <= (1.0 + NULL_RATIO) * least,
                (Some(null), Scale::Linear) => (value - null).abs() < NULL_SHARE * (greatest - least),
                (None, _) => true,
            }
        })
    }

    /// Prior odds of its values relative to the library's ranges: a factor for each value outside its range, and for
    /// each pass after the first that needs a value of its own.
    pub(super) fn prior(&self) -> f64 {
        let own = self.screened.candidate.coordinates.iter();
        let beyond = own.clone().filter(|c| c.beyond_listed(c.from_value(self.fit.model.value(c.index))).is_some());
        let again = own.filter(|c| c.slot.row.is_some_and(|row| row > 0));
        LISTED_ODDS.recip().powi((beyond.count() + again.count()) as i32)
    }

    /// Expected fall of the sum of squares beside the base fit. A quick fit that has not converged is no evidence against
    /// an effect, because its derivatives are borrowed: the first look counts if it expects more.
    fn promise(&self, base: &Fit) -> f64 {
        let found = base.chi2 - self.fit.chi2;
        if self.fit.converged { found } else { found.max(self.screened.delta_chi2) }
    }

    /// As [`Candidate::explains`](super::probe::Candidate::explains).
    pub(super) fn explains(&self) -> bool {
        self.screened.candidate.explains()
    }

    /// Returns true if a size of the effect ended at the far end of its range.
    pub fn is_on_bound(&self) -> bool {
        self.screened.candidate.coordinates.iter().any(|c| is_at_far_end(c, self.fit.model.value(c.index)))
    }

    /// Fits the effect quickly.
    ///
    /// # Errors
    /// If the model cannot be simulated with it.
    pub(super) fn quick(evidence: &dyn Evidence, base: &Fit, screened: Screened) -> Result<Self, EvidenceError> {
        Ok(Self::begun(evidence, base, screened)?.finished(evidence, QUICK_FIT))
    }

    /// Start of its fit: the best values and the derivatives of the first look.
    ///
    /// # Errors
    /// If the model cannot be simulated with it.
    pub(super) fn begun(evidence: &dyn Evidence, base: &Fit, screened: Screened) -> Result<Self, EvidenceError> {
        let model = shifted(screened.candidate.at(&screened.best), base, &screened.shift);
        let own = |name: &str| base.coordinates.iter().any(|c| c.slot.name() == name);
        let effect = &screened.candidate.name;
        let coordinates = Coordinate::of(&model, |slot| own(&slot.name()) || slot.owner == *effect);
        let mut fit = Fit::unfitted(evidence, &model, coordinates)?;
        let lent = |coordinate: &Coordinate| {
            let own = screened.candidate.coordinates.iter().position(|c| c.slot.name() == coordinate.slot.name());
            own.map_or_else(|| base.column(coordinate), |k| screened.slope(k))
        };
        fit.borrow_derivatives(evidence, lent);
        Ok(Self { screened, fit, is_completed: false })
    }

    /// The same values with the residuals of other data, or on another lattice.
    ///
    /// # Errors
    /// If the model cannot be simulated with it.
    pub(super) fn evaluated_on(self, evidence: &dyn Evidence) -> Result<Self, EvidenceError> {
        Ok(Self { fit: self.fit.evaluated_on(evidence)?, ..self })
    }

    /// Its fit, or a better one from the starting values of the base model: a base model without the effect may have
    /// converged far away to compensate for it.
    fn or_from_beginning(self, evidence: &dyn Evidence, base: &Fit) -> Self {
        let place = self.fit.with_beginning_of(base);
        match self.fit.begun_at(evidence, &place, LAST_FIT) {
            Ok(fit) if fit.chi2 < self.fit.chi2 => Self { fit, ..self },
            _ => self,
        }
    }

    /// Continues its fit on a surrogate, or on the data if there is none.
    pub(super) fn mapped(self, lattices: Lattices, options: FitOptions) -> Self {
        let fit = match lattices.quicker {
            Some(quicker) => self.fit.mapped(lattices.usual, quicker, options),
            None => self.fit.finished(lattices.usual, options),
        };
        Self { fit, ..self }
    }

    /// Continues its fit on the data.
    pub(super) fn finished(self, evidence: &dyn Evidence, options: FitOptions) -> Self {
        Self { fit: self.fit.finished(evidence, options), ..self }
    }

    /// Ends its fit on the data.
    fn ended(self, evidence: &dyn Evidence) -> Self {
        Self { is_completed: true, ..self.finished(evidence, LAST_FIT) }
    }
}

impl Contender for Suspect {
    fn suspect(&self) -> &Suspect {
        self
    }

    /// If the fit stays poor, it is also restarted at the starting values of the base fit.
    fn completed(self, lattices: Lattices, base: &Fit) -> Self {
        let ended = self.mapped(lattices, REFINED_FIT).ended(lattices.usual);
        if ended.fit.is_poor() { ended.or_from_beginning(lattices.usual, base) } else { ended }
    }
}

/// Returns true if a value of a parameter with a null is at the end of the range farthest from it.
pub(super) fn is_at_far_end(coordinate: &Coordinate, value: f64) -> bool {
    let [least, greatest] = coordinate.reach();
    let at = |end: f64| (value - end).abs() <= FAR_END_RATIO * end.abs();
    coordinate.slot.null.is_some_and(|null| (at(least) && null > least) || (at(greatest) && null < greatest))
}

/// Fits the most promising effects, the best of them until convergence: those of the first [`EFFECTS_REFINED`] families,
/// and, as long as none of them explains the data, of as many more. Best first.
///
/// - `lattices`: the data, and their surrogate near the base fit
pub(super) fn suspects(
    lattices: Lattices,
    base: &Fit,
    screened: &[Screened],
    on_progress: &(dyn Fn(&str) + Sync),
) -> Vec<Suspect> {
    let delta_chi2 = |suspect: &Suspect| base.chi2 - suspect.fit.chi2;
    let mut suspects = quickly(lattices, base, screened, on_progress);
    let worth = suspects.iter().find(|best| best.explains()).map_or(0.0, |best| REFINED_GAIN_SHARE * delta_chi2(best));
    suspects.sort_by(|a, b| b.promise(base).total_cmp(&a.promise(base)));
    let (mut open, rest): (Vec<_>, Vec<_>) = suspects.into_iter().partition(|suspect| suspect.promise(base) >= worth);
    let mut ended: Vec<Suspect> = Vec::new();
    while !open.is_empty() && is_unexplained(&ended) {
        let later = open.split_off(first_families(&open, EFFECTS_REFINED));
        let thorough = |suspect: Suspect| {
            let suspect = suspect.mapped(lattices, REFINED_FIT);
            on_progress(suspect.name());
            suspect
        };
        ended.par_extend(open.into_par_iter().map(thorough));
        end_what_may_win(lattices, base, &mut ended);
        open = later;
    }
    if is_unexplained(&ended) {
        ended = restarted(lattices.usual, base, in_order(ended));
    }
    ended.extend(open.into_iter().chain(rest));
    ended.retain(|suspect| delta_chi2(suspect) > 0.0);
    in_order(ended)
}

/// True if all fits are poor. An effect that explains nothing does not count.
fn is_unexplained(suspects: &[Suspect]) -> bool {
    suspects.iter().filter(|suspect| suspect.explains()).all(|suspect| suspect.fit.is_poor())
}

/// Number of suspects up to the last of the first `most` families. An effect that explains nothing takes no place.
fn first_families(suspects: &[Suspect], most: usize) -> usize {
    let mut families = Vec::new();
    let mut is_first =
        |suspect: &Suspect| !suspect.explains() || is_among(&mut families, &suspect.screened.candidate.family, most);
    suspects.iter().take_while(|suspect| is_first(suspect)).count()
}

/// Fits the most promising effects quickly, and evaluates them on the usual lattice. Best first.
fn quickly(lattices: Lattices, base: &Fit, screened: &[Screened], on_progress: &(dyn Fn(&str) + Sync)) -> Vec<Suspect> {
    let mut order = by_promise(screened.iter().filter(|screened| screened.delta_chi2 > FITTED_DELTA_CHI2));
    let mut families = Vec::new();
    order.retain(|screened| is_among(&mut families, &screened.candidate.family, EFFECTS_FITTED));
    let residuals = Projector::new(base).residuals;
    let fitted = |screened: &&Screened| {
        let starts = screened.starts(&residuals).into_par_iter().take(STARTS_PER_EFFECT);
        let suspects: Vec<Suspect> =
            starts.filter_map(|start| Suspect::quick(lattices.quick(), base, start).ok()).collect();
        on_progress(&screened.candidate.name);
        suspects.into_iter().min_by(|a, b| a.fit.chi2.total_cmp(&b.fit.chi2))?.evaluated_on(lattices.usual).ok()
    };
    in_order(order.par_iter().filter_map(fitted).collect())
}

/// Continues on the data the fits that may still be the best: those that take a good part of what the best takes.
fn end_what_may_win(lattices: Lattices, base: &Fit, suspects: &mut [Suspect]) {
    let explaining = suspects.iter().filter(|suspect| suspect.explains());
    let gain = base.chi2 - explaining.map(|suspect| suspect.fit.chi2).fold(base.chi2, f64::min);
    // On a surrogate a fit may seem to have converged far from where it would end on the data.
    let may_win = |suspect: &Suspect| {
        let own = base.chi2 - suspect.fit.chi2;
        let is_underway = !suspect.is_completed && (!suspect.fit.converged || lattices.quicker.is_some());
        own >= LAST_FIT_DELTA_CHI2 && is_underway && own >= REFINED_GAIN_SHARE * gain
    };
    suspects.par_iter_mut().filter(|suspect| may_win(suspect)).for_each(|suspect| {
        *suspect = suspect.clone().ended(lattices.usual);
    });
}

/// Restarts the best fits at the starting values of the base fit.
fn restarted(evidence: &dyn Evidence, base: &Fit, suspects: Vec<Suspect>) -> Vec<Suspect> {
    let best = first_families(&suspects, EFFECTS_REFINED);
    let again = |(k, suspect): (usize, Suspect)| match k < best && suspect.explains() {
        true => suspect.or_from_beginning(evidence, base),
        false => suspect,
    };
    suspects.into_par_iter().enumerate().map(again).collect()
}

/// Returns true if a family is among the first `most` families; adds a new one while there are fewer.
fn is_among(families: &mut Vec<String>, family: &str, most: usize) -> bool {
    let is_known = families.iter().any(|known| known == family);
    if !is_known && families.len() < most {
        families.push(family.to_owned());
        return true;
    }
    is_known
}

/// Effects by expected Δχ² from the first look, in descending order.
pub(super) fn by_promise<'a>(screened: impl Iterator<Item = &'a Screened>) -> Vec<&'a Screened> {
    let mut order: Vec<&Screened> = screened.collect();
    order.sort_by(|a, b| b.delta_chi2.total_cmp(&a.delta_chi2).then_with(|| a.candidate.name.cmp(&b.candidate.name)));
    order
}

/// Suspects by χ², least first.
pub(super) fn in_order(mut suspects: Vec<Suspect>) -> Vec<Suspect> {
    suspects.sort_by(|a, b| a.fit.chi2.total_cmp(&b.fit.chi2).then_with(|| a.name().cmp(b.name())));
    suspects
}
