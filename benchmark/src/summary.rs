//! All cases in numbers.

use std::collections::BTreeMap;

use serde::Serialize;
use trials::measure::median;

use super::baseline::most_common;
use super::cases::{Case, Family};
use super::coverage::{Coverage, coverage};
use super::error_gap::GapClosed;
use super::forecast::{Forecast, Reliability, most_probable};
use super::outcome::Outcome;
use super::power::Power;
use super::rate::Rate;
use super::said::{Asked, Judgement, Said};
use lab::Verdict;

/// Shares of the answers by judgement. Every case counts in exactly one of the first five.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// As asked.
    pub right: Rate,
    /// With doubt, but with what is hidden in it.
    pub class: Rate,
    /// Nothing false, but not what is hidden.
    pub too_shy: Rate,
    /// Something said to be missing where nothing is.
    pub false_alarm: Rate,
    /// An effect named that is not there.
    pub wrong_name: Rate,
    /// Of the cases whose effect the library lacks, those in which that was said.
    pub unknown_said: Rate,
    /// Mean of Brier's score; a guess without probabilities puts all on what it says.
    pub brier: f64,
}

impl Scores {
    fn new<'a>(answers: impl Iterator<Item = (&'a Case, &'a Said, f64)>) -> Self {
        let answers: Vec<(Asked, Judgement, f64)> =
            answers.map(|(case, said, brier)| (case.asked(), said.judged(case), brier)).collect();
        let is = |wanted: Judgement| Rate::new(answers.iter().map(|(_, judged, _)| *judged == wanted));
        let unknown = answers.iter().filter(|(asked, _, _)| *asked == Asked::Unknown);
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

    /// Of studies.
    fn of(outcomes: &[&Outcome]) -> Self {
        Self::new(outcomes.iter().map(|o| (&o.case, &o.said, o.forecast.brier(&o.case))))
    }

    /// Of a guess for each of the cases.
    fn of_guess<'a>(outcomes: &[&'a Outcome], guess: impl Fn(&'a Outcome) -> &'a Said) -> Self {
        Self::new(outcomes.iter().map(|o| (&o.case, guess(o), Forecast::sure(guess(o)).brier(&o.case))))
    }
}

/// Studies and guesses, by the same rules.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// `robofin study`.
    pub study: Scores,
    /// Residual regression.
    pub residual_regression: Scores,
    /// Always the effect that is hidden most often.
    pub most_common_effect: Scores,
}

/// Coverage of 95 % intervals in some of the cases.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CoverageOf {
    /// Name of the group of cases, such as `right answers`.
    pub cases: &'static str,
    /// By parameter.
    pub parameters: Vec<Coverage>,
}

/// All cases in numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Cases that were made.
    pub cases: usize,
    /// Of these, whose measurements the study refused, or in which it failed.
    pub refused: Rate,
    /// All cases, by the study and by guesses.
    pub all: Compared,
    /// By family.
    pub families: BTreeMap<Family, Scores>,
    /// By front end, in family H.
    pub front_ends: BTreeMap<&'static str, Scores>,
    /// By process.
    pub processes: BTreeMap<&'static str, Scores>,
    /// Single effects by rung over the visible size.
    pub rungs: Vec<(f64, Scores)>,
    /// Answers other than that nothing is missing, where nothing is hidden behind clean instruments.
    pub false_alarms: Rate,
    /// Wrong names among all answers that name an effect or hint at one.
    pub wrong_of_named: Rate,
    /// All probabilities of effects, and of none, from 1 % on.
    pub reliability: Reliability,
    /// The same of the most probable statement of each case.
    pub reliability_of_first: Reliability,
    /// Coverage of the parameters' intervals.
    pub coverage: Vec<CoverageOf>,
    /// Held-out error explained, where an effect is hidden.
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

/// Outcomes by a key.
fn grouped<'a, K: Ord>(outcomes: &[&'a Outcome], key: impl Fn(&Outcome) -> K) -> BTreeMap<K, Vec<&'a Outcome>> {
    let mut groups: BTreeMap<K, Vec<&Outcome>> = BTreeMap::new();
    outcomes.iter().for_each(|outcome| groups.entry(key(outcome)).or_default().push(outcome));
    groups
}

/// Scores by a key.
fn scored<K: Ord>(outcomes: &[&Outcome], key: impl Fn(&Outcome) -> K) -> BTreeMap<K, Scores> {
    grouped(outcomes, key).into_iter().map(|(key, of)| (key, Scores::of(&of))).collect()
}

impl Summary {
    /// Counts outcomes.
    pub fn new(outcomes: &[Outcome]) -> Self {
        let all: Vec<&Outcome> = outcomes.iter().collect();
        let some = |is: &dyn Fn(&Outcome) -> bool| all.iter().filter(|o| is(o)).copied().collect::<Vec<_>>();
        let of_family = |family: Family| some(&|o: &Outcome| o.case.family == family);
        let names = some(&|o| o.case.asked() == Asked::Names);
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

/// The study and the guesses over the same cases.
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
    // Rungs are above zero, and so are ordered as their bits are.
    scored(singles, |o| o.case.rung.to_bits()).into_iter().map(|(rung, of)| (f64::from_bits(rung), of)).collect()
}

/// Coverage in all cases, where nothing is hidden, and where the answer is right.
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
