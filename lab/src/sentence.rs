//! A verdict in a sentence.

use super::diagnose::Diagnosis;
use super::evidence::ErrorUnit;
use super::finding::Finding;
use super::summary::{EffectSummary, parameter_summary, significant};
use super::verdict::Verdict;
use crate::criteria::NEAREST_SHARE;

/// Sentence on a hint: the effect, its size, and the size at which it would be named.
fn hint_words((hint, least): (&Finding, f64), diagnosis: &Diagnosis, unit: ErrorUnit) -> String {
    let name = hint.suspect.name();
    let estimates = hint.suspect.fit.estimates(diagnosis.rounds[0].spread);
    let own = estimates.iter().filter(|estimate| estimate.coordinate.slot.owner == name);
    let values: Vec<String> = own.map(|estimate| parameter_summary(estimate).shown()).collect();
    let [size, least] = [hint.size, least].map(|size| significant(size * unit.per_one()));
    let symbol = unit.symbol();
    format!(
        "{name} is visible, but too small to be named: {}. It changes {size} {symbol}, and {least} {symbol} would \
         suffice to name it: passes in which it is that much stronger would decide.",
        values.join("; ")
    )
}

pub(super) fn sentence((diagnosis, unit): (&Diagnosis, ErrorUnit), effects: &[EffectSummary]) -> String {
    let names: Vec<&str> = effects.iter().map(|effect| effect.name.as_str()).collect();
    let first = effects.first();
    let reserve = diagnosis.found().first().and_then(|found| found.reserve);
    let alike = first.map_or(String::new(), |effect| effect.indistinguishable_from.join(", "));
    match diagnosis.verdict {
        Verdict::Identified => {
            let named: Vec<String> = effects.iter().map(with_values).collect();
            format!("The model lacks {}.", named.join(" and "))
        }
        Verdict::Ambiguous => format!(
            "The model lacks {} or an effect that these data cannot distinguish from it{}{}.",
            names.first().unwrap_or(&"an effect"),
            if alike.is_empty() { String::new() } else { format!(" ({alike})") },
            reserve.map_or(String::new(), |reserve| format!(": {}", reserve.words()))
        ),
        Verdict::Partly => format!("The model lacks {}, and more that was not found.", names.join(" and ")),
        Verdict::Unknown => {
            let beside = predicts_worse(diagnosis).unwrap_or_else(|| nearest(diagnosis));
            format!("Something is missing that no effect of the library describes.{beside}")
        }
        Verdict::Hint => diagnosis.hint().map_or(String::new(), |hint| hint_words(hint, diagnosis, unit)),
        Verdict::NothingMissing => {
            let beside = predicts_worse(diagnosis).unwrap_or_default();
            match too_small(diagnosis, unit) {
                Some(visible) => format!("{visible}{beside}"),
                None => format!("Nothing is missing that these data could show.{beside}"),
            }
        }
        Verdict::NotTestable if let Some(why) = &diagnosis.unrelated => format!("Nothing can be said: {why}."),
        Verdict::NotTestable if diagnosis.misses_held_out() => {
            "The calibration passes show nothing missing, but the model misses the held-out passes: calibrate it with \
             passes that vary as much."
                .to_owned()
        }
        Verdict::NotTestable => "These data cannot show most effects: nothing can be said.".to_owned(),
    }
}

/// An effect with its values and their intervals.
fn with_values(effect: &EffectSummary) -> String {
    let values: Vec<String> = effect.parameters.values().map(|parameter| parameter.shown()).collect();
    format!("{}: {}", effect.name, values.join("; "))
}

/// Phrase on an effect that was taken back because of the held-out passes.
fn predicts_worse(diagnosis: &Diagnosis) -> Option<String> {
    let best = diagnosis.rounds.first()?.taken_back()?;
    Some(format!(" The most probable effect is {}: {}.", best.suspect.name(), best.reserve?.words()))
}

/// Sentence on what is visible, but too small to be named, where several effects explain it.
fn too_small(diagnosis: &Diagnosis, unit: ErrorUnit) -> Option<String> {
    let round = diagnosis.rounds.first()?;
    let effects = round.too_small();
    let size = effects.first()?.size;
    let names: Vec<&str> = effects.iter().map(|finding| finding.suspect.name()).collect();
    let [size, least] = [size, round.least_size()].map(|size| significant(size * unit.per_one()));
    let symbol = unit.symbol();
    Some(format!(
        "Nothing is missing that matters. What is visible changes {size} {symbol}, and {least} {symbol} would suffice to \
         name its cause; these data would not tell which it is: {}.",
        names.join(", ")
    ))
}

/// Phrase on the effect that comes nearest, if it explains a good part of the misfit.
fn nearest(diagnosis: &Diagnosis) -> String {
    let Some(first) = diagnosis.rounds.first() else { return String::new() };
    let excess = first.base.chi2 - first.base.residuals.len() as f64;
    let explained = |finding: &Finding| (first.base.chi2 - finding.suspect.fit.chi2) / excess;
    let best = first.findings.iter().max_by(|a, b| a.prediction.total().total_cmp(&b.prediction.total()));
    match best.map(|best| (best, explained(best))) {
        Some((best, share)) if excess > 0.0 && share >= NEAREST_SHARE => {
            let why = best.reserve.filter(|_| !best.may_be_cause());
            let why = why.map_or(String::new(), |reserve| format!(": {}", reserve.words()));
            format!(
                " The nearest is {}, which accounts for {:.0} % of it{why}.",
                best.suspect.name(),
                100.0 * share.min(1.0)
            )
        }
        _ => String::new(),
    }
}
