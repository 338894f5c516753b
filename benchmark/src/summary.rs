//! Statistics over all cases.

use std::collections::BTreeMap;

use serde::Serialize;
use trials::measure::median;

use super::answer::{CaseAnswer, ExpectedAnswer, Judgement};
use super::baseline::most_common;
use super::cases::{Case, Family};
use super::coverage::{Coverage, coverage};
use super::error_gap::GapClosed;
use super::forecast::{Forecast, Reliability, most_probable};
use super::outcome::Outcome;
use super::power::Power;
use super::rate::Rate;
use lab::Verdict;

/// Shares of the answers by judgement. Every case counts in exactly one of the first five.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// Right answers.
    pub right: Rate,
    /// Uncertain answers that contain the hidden effect.
    pub class: Rate,
    /// Answers without a false statement that miss the hidden effect.
    pub too_shy: Rate,
    /// Answers that report something missing where nothing is.
    pub false_alarm: Rate,
    /// Answers that name an effect that does not act.
    pub wrong_name: Rate,
    /// Share of the cases with an effect outside the library in which the verdict is unknown.
    pub unknown_said: Rate,
    /// Mean Brier score; a guess without probabilities puts all probability on its answer.
    pub brier: f64,
}

impl Scores {
    fn new<'a>(answers: impl Iterator<Item = (&'a Case, &'a CaseAnswer, f64)>) -> Self {
        let answers: Vec<(ExpectedAnswer, Judgement, f64)> =
            answers.map(|(case, said, brier)| (case.asked(), said.judged(case), brier)).collect();
        let is = |wanted: Judgement| Rate::new(answers.iter().map(|(_, judged, _)| *judged == wanted));
        let unknown = answers.iter().filter(|(asked, _, _)| *asked == ExpectedAnswer::Unknown);
        Self {
            right: is(Judgement::Right),
            class: is(Judgement::Class),
            too_shy: is(Judgement::Shy),
            false_alarm: is(Judgement::Alarm),
            wrong_name: is(Judgement::Wrong),
            unknown_said: Rate::new(unknown.map(|(_, judged, _)| *judged == Judgement::Right)),
            brier: answers.iter().map(|(_, _, brier)| brier).sum::<f64>() / answers.len().max(1) as f64,
        }
    }

    /// Scores of studies.
    fn of(outcomes: &[&Outcome]) -> Self {
        Self::new(outcomes.iter().map(|o| (&o.case, &o.said, o.forecast.brier(&o.case))))
    }

    /// Scores of a baseline's guess for each of the cases.
    fn of_guess<'a>(outcomes: &[&'a Outcome], guess: impl Fn(&'a Outcome) -> &'a CaseAnswer) -> Self {
        Self::new(outcomes.iter().map(|o| (&o.case, guess(o), Forecast::sure(guess(o)).brier(&o.case))))
    }
}

/// Study and baselines, scored by the same rules.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// `robofin study`.
    pub study: Scores,
    /// Residual regression.
    pub residual_regression: Scores,
    /// Baseline that always names the effect that is hidden most often.
    pub most_common_effect: Scores,
}

/// Coverage of 95 % intervals in a group of cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoverageOf {
    /// Name of the group of cases, such as `right answers`.
    pub cases: &'static str,
    /// By parameter.
    pub parameters: Vec<Coverage>,
}

/// Statistics over all cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Number of cases that were made.
    pub cases: usize,
    /// Cases whose measurements the study refused, or in which it failed.
    pub refused: Rate,
    /// Scores of all cases, for the study and the baselines.
    pub all: Compared,
    /// Scores by family.
    pub families: BTreeMap<Family, Scores>,
    /// Scores by front end, in family H.
    pub front_ends: BTreeMap<&'static str, Scores>,
    /// Scores by process.
    pub processes: BTreeMap<&'static str, Scores>,
    /// Scores of single effects by rung relative to the visible size.
    pub rungs: Vec<(f64, Scores)>,
    /// Answers other than "nothing is missing" where nothing is hidden behind clean instruments.
    pub false_alarms: Rate,
    /// Wrong names among all answers that name an effect or hint at one.
    pub wrong_of_named: Rate,
    /// Reliability of all stated probabilities of effects, and of none of them, from 1 % on.
    pub reliability: Reliability,
    /// Reliability of the most probable statement of each case.
    pub reliability_of_first: Reliability,
    /// Coverage of the parameters' intervals.
    pub coverage: Vec<CoverageOf>,
    /// Closed share of the held-out error gap, where an effect is hidden.
    pub error_gap: GapClosed,
    /// The same where the answer is right.
    pub error_gap_of_right: GapClosed,
    /// Sizes from which effects are named.
    pub power: Vec<Power>,
    /// Ambiguous answers with a next trial.
    pub next_trials: Rate,
    /// Median time of a study [s].
    pub seconds: f64,
}

/// Groups outcomes by a key.
fn grouped<'a, K: Ord>(outcomes: &[&'a Outcome], key: impl Fn(&Outcome) -> K) -> BTreeMap<K, Vec<&'a Outcome>> {
    let mut groups: BTreeMap<K, Vec<&Outcome>> = BTreeMap::new();
    outcomes.iter().for_each(|outcome| groups.entry(key(outcome)).or_default().push(outcome));
    groups
}

/// Scores outcomes by a key.
fn scored<K: Ord>(outcomes: &[&Outcome], key: impl Fn(&Outcome) -> K) -> BTreeMap<K, Scores> {
    grouped(outcomes, key).into_iter().map(|(key, of)| (key, Scores::of(&of))).collect()
}

impl Summary {
    /// Computes the statistics of outcomes.
    pub fn new(outcomes: &[Outcome]) -> Self {
        let all: Vec<&Outcome> = outcomes.iter().collect();
        let some = |is: &dyn Fn(&Outcome) -> bool| all.iter().filter(|o| is(o)).copied().collect::<Vec<_>>();
        let of_family = |family: Family| some(&|o: &Outcome| o.case.family == family);
        let names = some(&|o| o.case.asked() == ExpectedAnswer::Names);
        let right: Vec<&Outcome> = names.iter().filter(|o| o.judgement == Judgement::Right).copied().collect();
        let statements: Vec<_> = all.iter().map(|o| o.forecast.statements(&o.case)).collect();
        let ambiguous = all.iter().filter(|o| o.said.verdict == Some(Verdict::Ambiguous));
        let is_name = |o: &&&Outcome| !o.said.named.is_empty() || o.said.hint.is_some();
        Self {
            cases: all.len(),
            refused: Rate::new(all.iter().map(|o| o.refused.is_some())),
            all: compared(&all),
            families: scored(&all, |o| o.case.family),
            front_ends: scored(&of_family(Family::H), |o| o.case.design.front.word()),
            processes: scored(&all, |o| o.case.design.process.name()),
            rungs: rungs(&some(&|o| matches!(o.case.family, Family::S | Family::W))),
            false_alarms: Rate::new(of_family(Family::N).iter().map(|o| o.judgement != Judgement::Right)),
            wrong_of_named: Rate::new(all.iter().filter(is_name).map(|o| o.judgement == Judgement::Wrong)),
            reliability: Reliability::new(&statements.concat()),
            reliability_of_first: Reliability::new(
                &statements.iter().filter_map(|of| most_probable(of)).collect::<Vec<_>>(),
            ),
            coverage: coverages(&all, &right),
            error_gap: GapClosed::new(names.iter().map(|o| &o.errors)),
            error_gap_of_right: GapClosed::new(right.iter().map(|o| &o.errors)),
            power: power(&some(&|o| matches!(o.case.family, Family::S | Family::W))),
            next_trials: Rate::new(ambiguous.map(|o| o.next_trial)),
            seconds: median(all.iter().map(|o| o.seconds).collect()).unwrap_or(0.0),
        }
    }
}

/// Scores of the study and the baselines over the same cases.
fn compared(all: &[&Outcome]) -> Compared {
    let common = most_common(&all.iter().map(|o| &o.case).collect::<Vec<_>>());
    Compared {
        study: Scores::of(all),
        residual_regression: Scores::of_guess(all, |o| &o.regression),
        most_common_effect: Scores::new(all.iter().map(|o| (&o.case, &common, Forecast::sure(&common).brier(&o.case)))),
    }
}

/// Scores by rung, the smallest first.
fn rungs(singles: &[&Outcome]) -> Vec<(f64, Scores)> {
    // Rungs are positive, so that their bits have the same order.
    scored(singles, |o| o.case.rung.to_bits()).into_iter().map(|(rung, of)| (f64::from_bits(rung), of)).collect()
}

/// Coverage in all cases, in those with nothing hidden, and in those with a right answer.
fn coverages(all: &[&Outcome], right: &[&Outcome]) -> Vec<CoverageOf> {
    let of = |cases: &'static str, outcomes: &[&Outcome]| {
        let is_there = |o: &&Outcome, name: &str| {
            name.split_once('.').is_none_or(|(owner, _)| o.case.hidden.iter().any(|hidden| hidden == owner))
        };
        let own = outcomes
            .iter()
            .flat_map(|o| o.intervals.iter().filter(move |interval| interval.is_base || is_there(o, &interval.name)));
        CoverageOf { cases, parameters: coverage(own) }
    };
    let nothing: Vec<&Outcome> = all.iter().filter(|o| o.case.family == Family::N).copied().collect();
    vec![of("nothing hidden", &nothing), of("right answers", right), of("all cases", all)]
}

/// Sizes from which effects are named, for each effect with enough cases and for all of [`Family::S`] together.
fn power(singles: &[&Outcome]) -> Vec<Power> {
    let named = |o: &&Outcome| (o.case.rung, matches!(o.judgement, Judgement::Right | Judgement::Class));
    let tried = |of: &[&Outcome]| of.iter().map(named).collect::<Vec<_>>();
    let of_each = grouped(singles, |o| format!("{}, {}", o.case.hidden[0], o.case.design.process.name()));
    let each = of_each.into_iter().filter_map(|(name, of)| Power::new(name, &tried(&of)));
    let library: Vec<&Outcome> = singles.iter().filter(|o| o.case.family == Family::S).copied().collect();
    each.chain(Power::new("all effects of the library".to_owned(), &tried(&library))).collect()
}
