//! Summary of a diagnosis: parameters in the library's units, errors in [`ErrorUnit`].

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::detectable::Detectable;
use super::diagnose::Diagnosis;
use super::evidence::{Agreement, ErrorUnit, Evidence, EvidenceError, Split};
use super::finding::Finding;
use super::fit::{Estimate, Fit};
use super::frame::FrameEstimate;
use super::next_trial::NextTrial;
use super::pass_trend::PassTrend;
use super::reserve::Reserve;
use super::round::Round;
use super::sentence::sentence;
use super::unfitted::Unfitted;
use super::unlisted::Proposal;
use super::verdict::{Verdict, rms};
use crate::criteria::{CriterionValues, INTERVAL_SIGMAS, NOT_IDENTIFIABLE_SHARE};

/// Name of the waterfall step that calibrates the base law.
pub const BASE_STEP: &str = "base model";

/// A parameter with its interval, in the library's unit.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ParameterSummary {
    /// `effect.parameter`.
    pub name: String,
    /// Best value.
    pub value: f64,
    /// 95 % interval; absent if the data do not determine it.
    pub interval: Option<[f64; 2]>,
    /// Unit.
    pub unit: String,
    /// State of its determination by the data.
    pub state: ParameterState,
    /// End of the library's range that the value exceeds, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub listed_to: Option<f64>,
}

/// State of a parameter's determination by the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ParameterState {
    /// The interval is narrower than half of the range.
    Identifiable,
    /// The best value lies on the lower bound.
    OnLeast,
    /// The best value lies on the upper bound.
    OnGreatest,
    /// The interval is wider than half of the range.
    NotIdentifiable,
    /// No fit varied it.
    Fixed,
}

impl ParameterState {
    /// State in words; `None` if identifiable.
    pub fn words(self) -> Option<&'static str> {
        match self {
            Self::Identifiable => None,
            Self::OnLeast => Some("on its least value"),
            Self::OnGreatest => Some("on its greatest value"),
            Self::NotIdentifiable => Some("not identifiable from these data"),
            Self::Fixed => Some("held fixed"),
        }
    }
}

/// An effect that was found, or is indistinguishable from it.
#[derive(Clone, Debug, Serialize)]
pub struct EffectSummary {
    /// Name in the library.
    pub name: String,
    /// Title in the library.
    pub title: String,
    /// Posterior probability among all fitted effects.
    pub probability: f64,
    /// Effects that these data cannot distinguish from it.
    pub indistinguishable_from: Vec<String>,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, ParameterSummary>,
    /// Fall of χ², divided by the variance of the remaining residuals.
    pub delta_chi2: f64,
    /// P-value: probability that noise alone gives the best of all effects such a Δχ².
    pub p_value: f64,
    /// Number of the search that fitted it, from 1.
    pub search: usize,
    /// Reason against it; absent for the best one of a search and for those that these data cannot distinguish from it.
    pub ruled_out: Option<String>,
    /// Root mean square error of held-out passes without the effect [unit of errors]; absent if none is held out.
    pub evaluation_rms_before: Option<f64>,
    /// The same with the effect.
    pub evaluation_rms_after: Option<f64>,
}

/// A step of the waterfall.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct WaterfallStep {
    /// Name of the step.
    pub step: String,
    /// Root mean square over the calibration scans [unit of errors].
    pub calibration_rms: f64,
    /// Over the evaluation scans; absent where there are none.
    pub evaluation_rms: Option<f64>,
}

impl WaterfallStep {
    /// Formats name and errors in one line.
    pub fn shown(&self, unit: ErrorUnit) -> String {
        let held_out = self.evaluation_rms.map_or(String::new(), |rms| format!(", {} held out", unit.shown(rms)));
        format!("{}: {}{held_out}", self.step, unit.shown(self.calibration_rms))
    }
}

/// Summary of a diagnosis.
#[derive(Clone, Debug, Serialize)]
pub struct DiagnosisSummary {
    /// Verdict in one word.
    pub verdict: Verdict,
    /// Verdict in one sentence.
    pub sentence: String,
    /// Effects found; the first is the most probable.
    pub effects: Vec<EffectSummary>,
    /// Probability, in the first search, that no effect of the library is the cause of the misfit, if there is one.
    pub none_probability: f64,
    /// Unit of the errors below: metres for scans, shares of the removal for tables.
    pub error_unit: ErrorUnit,
    /// Noise floor of the calibration passes.
    pub noise_floor: f64,
    /// Noise floor of the evaluation passes; absent where none is held out.
    pub evaluation_noise_floor: Option<f64>,
    /// Root mean square error of the base model.
    pub base_rms: f64,
    /// Root mean square error of the final model.
    pub final_rms: f64,
    /// Errors from the base model to the noise floor.
    pub waterfall: Vec<WaterfallStep>,
    /// Trend of equal passes, and the changes that the base law can produce; absent if there are no equal passes.
    pub equal_passes: Option<PassTrend>,
    /// All parameters of the final model.
    pub parameters: Vec<ParameterSummary>,
    /// Frame offset of the logs; absent if none were moved.
    pub frame: Option<FrameEstimate>,
    /// Every effect that was fitted.
    pub suspects: Vec<EffectSummary>,
    /// Every other effect that was looked at.
    pub unfitted: Vec<Unfitted>,
    /// Proposed next trial; absent where no rivals are left.
    pub next_trial: Option<NextTrial>,
    /// Effect proposed where no library effect describes the data; absent if there is none.
    pub proposal: Option<Proposal>,
    /// Detectable size of each effect.
    pub detectable: Vec<Detectable>,
    /// Effects that were not tried, with the reason.
    pub blind: BTreeMap<String, String>,
    /// Values of all decision criteria, by name.
    pub criteria: CriterionValues,
}

/// Noise floor of some scans [unit of errors]; `None` without a scan.
pub(super) fn floor_of(of: &[Agreement]) -> Option<f64> {
    (!of.is_empty()).then(|| rms(of, |a| a.floor))
}

/// Converts an estimate to the library's unit.
pub fn parameter_summary(estimate: &Estimate) -> ParameterSummary {
    let (coordinate, slot) = (&estimate.coordinate, &estimate.coordinate.slot);
    let at = coordinate.from_value(estimate.value);
    let [least, greatest] = coordinate.listed();
    let wide =
        !estimate.sigma.is_finite() || estimate.sigma * INTERVAL_SIGMAS > NOT_IDENTIFIABLE_SHARE * (greatest - least);
    let end = |sign: f64| {
        slot.unit.from_si(coordinate.value(coordinate.clamped(at + sign * INTERVAL_SIGMAS * estimate.sigma)))
    };
    let state = match (wide, estimate.bound) {
        (true, _) => ParameterState::NotIdentifiable,
        (false, Some(super::Bound::Least)) => ParameterState::OnLeast,
        (false, Some(_)) => ParameterState::OnGreatest,
        (false, None) => ParameterState::Identifiable,
    };
    ParameterSummary {
        name: slot.name(),
        value: slot.unit.from_si(estimate.value),
        interval: (!wide).then(|| [end(-1.0), end(1.0)]),
        unit: slot.unit_text.clone(),
        state,
        listed_to: coordinate.beyond_listed(at).map(|end| slot.unit.from_si(coordinate.value(end))),
    }
}

impl ParameterSummary {
    /// Formats value, interval and remarks in one line.
    pub fn shown(&self) -> String {
        let interval = self
            .interval
            .map_or(String::new(), |[low, high]| format!(", 95 % from {} to {}", significant(low), significant(high)));
        let state = self.state.words().map_or(String::new(), |words| format!(", {words}"));
        let listed = self.listed_to.map_or(String::new(), |end| format!(", listed to {}", significant(end)));
        format!("{} = {}{interval}{state}{listed}", self.name, self.quantity())
    }

    /// Formats the value with its unit.
    pub fn quantity(&self) -> String {
        let unit = if self.unit == "1" { String::new() } else { format!(" {}", self.unit) };
        format!("{}{unit}", significant(self.value))
    }
}

/// Formats to four digits.
pub(super) fn significant(value: f64) -> String {
    format!("{value:.3e}").parse::<f64>().unwrap_or(value).to_string()
}

impl EffectSummary {
    /// Formats probability, Δχ² and values in one line.
    pub fn shown(&self) -> String {
        let value = |(name, p): (&String, &ParameterSummary)| format!("{name} = {}", p.quantity());
        let values: Vec<String> = self.parameters.iter().map(value).collect();
        let Self { name, probability, delta_chi2, p_value, .. } = self;
        format!(
            "{name}: probability {probability:.3}, Δχ² {delta_chi2:.1}, p-value {p_value:.3}; {}",
            values.join(", ")
        )
    }

    fn new(evidence: &dyn Evidence, (search, round): (usize, &Round), finding: &Finding, title: &str) -> Self {
        let is_shown = finding.is_admissible || finding.reserve == Some(Reserve::PredictsWorse);
        let before: &[Agreement] = if is_shown { &round.evaluation } else { &[] };
        let own = |e: &Estimate| e.coordinate.slot.owner == finding.suspect.name();
        let estimates = finding.suspect.fit.estimates(round.spread);
        let row = |e: &Estimate| e.coordinate.slot.row.map_or(String::new(), |row| format!("[{}]", row + 1));
        let parameters = estimates
            .iter()
            .filter(|e| own(e))
            .map(|e| (format!("{}{}", e.coordinate.slot.parameter, row(e)), parameter_summary(e)));
        let unit = evidence.unit();
        let error = |of: &[Agreement]| (!of.is_empty()).then(|| rms(of, |a| a.rms));
        let alike = round.indistinguishable().into_iter().map(|other| other.suspect.name().to_owned());
        let is_best = round.best().is_some_and(|best| best.suspect.name() == finding.suspect.name());
        Self {
            name: finding.suspect.name().to_owned(),
            title: title.to_owned(),
            probability: finding.probability,
            indistinguishable_from: if is_best { alike.collect() } else { Vec::new() },
            parameters: parameters.collect(),
            delta_chi2: finding.delta_chi2,
            p_value: finding.p_value,
            search,
            ruled_out: round.ruled_out(finding, unit),
            evaluation_rms_before: error(before),
            evaluation_rms_after: error(&finding.evaluation),
        }
    }
}

impl DiagnosisSummary {
    /// Summarises a diagnosis.
    ///
    /// # Errors
    /// If a model cannot be simulated.
    pub fn new(
        evidence: &dyn Evidence,
        diagnosis: &Diagnosis,
        title: &dyn Fn(&str) -> String,
    ) -> Result<Self, EvidenceError> {
        let (unit, first) = (evidence.unit(), &diagnosis.rounds[0]);
        let summary =
            |round, finding: &Finding| EffectSummary::new(evidence, round, finding, &title(finding.suspect.name()));
        let rounds = || (1..).zip(&diagnosis.rounds);
        let pairs = rounds().flat_map(|(number, round)| round.findings.iter().map(move |f| ((number, round), f)));
        let suspects = pairs.map(|(round, finding)| summary(round, finding)).collect();
        let left = rounds().flat_map(|(search, round)| round.unfitted().into_iter().map(move |one| (search, one)));
        let unfitted =
            left.map(|(search, (name, reason))| Unfitted { name: name.to_owned(), title: title(name), search, reason });
        let unfitted = unfitted.collect();
        let found = diagnosis.found();
        let mut effects: Vec<EffectSummary> =
            rounds().zip(&found).map(|(round, finding)| summary(round, finding)).collect();
        if diagnosis.verdict == Verdict::Identified {
            effects.extend(diagnosis.frame.and_then(|frame| frame.as_effect(title)));
        }
        let frame =
            diagnosis.frame.and_then(|frame| frame.sentence()).map_or(String::new(), |words| format!(" {words}"));
        let added = |finding: &&Finding| {
            step(format!("+ {}", finding.suspect.name()), &finding.calibration, &finding.evaluation)
        };
        let base_step = step(BASE_STEP.to_owned(), &first.calibration, &first.evaluation);
        let waterfall = [base_step].into_iter().chain(found.iter().map(added)).collect();
        let equal_passes = evidence.trend(&first.base.model)?;
        let beyond = equal_passes.as_ref().filter(|trend| trend.out_of_reach);
        let beyond = beyond.map_or(String::new(), |trend| format!(" {}", trend.sentence()));
        let sizes: String =
            effects.iter().filter_map(|effect| evidence.words(effect)).map(|w| format!(" {w}")).collect();
        let last = evidence.agreement(&diagnosis.fit.model, Split::Calibration)?;
        let spread = diagnosis.rounds.last().map_or(1.0, |round| round.spread);
        Ok(Self {
            verdict: diagnosis.verdict,
            sentence: sentence((diagnosis, unit), &effects) + &sizes + &beyond + &frame,
            effects,
            none_probability: first.none,
            error_unit: unit,
            noise_floor: rms(&first.calibration, |a| a.floor),
            evaluation_noise_floor: floor_of(&first.evaluation),
            base_rms: rms(&first.calibration, |a| a.rms),
            final_rms: rms(&last, |a| a.rms),
            waterfall,
            equal_passes,
            parameters: parameters(&diagnosis.fit, spread),
            frame: diagnosis.frame,
            suspects,
            unfitted,
            next_trial: None,
            proposal: None,
            detectable: diagnosis.detectable.clone(),
            blind: diagnosis.blind.clone(),
            criteria: CriterionValues,
        })
    }
}

/// All parameters of a fit.
pub fn parameters(fit: &Fit, spread: f64) -> Vec<ParameterSummary> {
    fit.estimates(spread).iter().map(parameter_summary).collect()
}

pub(super) fn step(step: String, calibration: &[Agreement], evaluation: &[Agreement]) -> WaterfallStep {
    let evaluation_rms = (!evaluation.is_empty()).then(|| rms(evaluation, |a| a.rms));
    WaterfallStep { step, calibration_rms: rms(calibration, |a| a.rms), evaluation_rms }
}
