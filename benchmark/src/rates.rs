//! How many cases came out right, with intervals, and the table.

use std::collections::BTreeMap;

use serde::Serialize;

use super::cases::{Family, Sized};
use super::outcome::Outcome;
use lab::Verdict;
use trials::measure::median;

/// Normal quantile of a 95 % interval.
const QUANTILE: f64 = 1.959_964;
/// Multiple of the detectable size from which an effect should be named.
const LARGE: f64 = 4.0;
/// Effects that are faults of the scanner.
const MEASUREMENT: [&str; 8] = [
    "scan-shift",
    "slope-bias",
    "lateral-blur",
    "height-gain",
    "stitching",
    "scan-tilt",
    "exposure-threshold",
    "clock-offset",
];

/// A share with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Cases for which it holds.
    pub hits: usize,
    /// All cases.
    pub of: usize,
    /// Interval of 95 % (Wilson 1927).
    pub interval: [f64; 2],
}

impl Rate {
    /// Counts what holds.
    pub fn new(holds: impl Iterator<Item = bool>) -> Self {
        let (mut hits, mut of) = (0, 0);
        for holds in holds {
            hits += usize::from(holds);
            of += 1;
        }
        let (n, z2) = (of.max(1) as f64, QUANTILE * QUANTILE);
        let share = hits as f64 / n;
        let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = QUANTILE * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt() / (1.0 + z2 / n);
        let interval = if of == 0 { [0.0, 1.0] } else { [(middle - half).max(0.0), (middle + half).min(1.0)] };
        Self { hits, of, interval }
    }
}

impl std::fmt::Display for Rate {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let [low, high] = self.interval.map(|share| 100.0 * share);
        write!(f, "{}/{} ({low:.0} to {high:.0} %)", self.hits, self.of)
    }
}

impl Outcome {
    fn is_named(&self) -> bool {
        !self.named.is_empty()
    }

    /// Whether a hidden effect was named, or is one of those that the data cannot tell from a named one.
    fn has(&self, hidden: &str) -> bool {
        let named = self.named.iter().zip(&self.alike);
        named.clone().any(|(name, alike)| name == hidden || alike.iter().any(|other| other == hidden))
    }

    /// Whether just the hidden effects were named, without doubt.
    pub fn is_exact(&self) -> bool {
        let all = self.case.hidden.iter().all(|hidden| self.named.contains(hidden));
        all && self.named.len() == self.case.hidden.len() && self.verdict == Verdict::Identified
    }

    /// Whether the answer is what the family asks for.
    pub fn is_right(&self) -> bool {
        let nothing = matches!(self.verdict, Verdict::NothingMissing | Verdict::NotTestable);
        let hidden = &self.case.hidden;
        match self.case.family {
            _ if hidden.is_empty() => nothing,
            Family::A => nothing,
            Family::U => self.verdict == Verdict::Unknown,
            Family::M => self.named.iter().all(|name| MEASUREMENT.contains(&name.as_str())),
            Family::D => {
                let found = hidden.iter().filter(|hidden| self.has(hidden)).count();
                let said = matches!(self.verdict, Verdict::Partly | Verdict::Ambiguous);
                found == hidden.len() || (found > 0 && said)
            }
            Family::P => self.has(&hidden[0]) && (self.verdict != Verdict::Ambiguous || self.next_trial),
            _ => self.has(&hidden[0]),
        }
    }

    /// Whether an effect was named that is not there.
    pub fn is_false_name(&self) -> bool {
        let hidden = &self.case.hidden;
        match self.case.family {
            Family::U | Family::A => self.is_named(),
            Family::M => !self.is_right(),
            _ if hidden.is_empty() => self.is_named(),
            _ => self.is_named() && !hidden.iter().any(|hidden| self.has(hidden)),
        }
    }
}

/// The cases of one family in numbers.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FamilyRates {
    /// Cases in which just the hidden effects were named, without doubt.
    pub exact: Rate,
    /// Cases answered as the family asks.
    pub right: Rate,
    /// Cases in which an effect was named that is not there.
    pub false_names: Rate,
    /// Median time of a diagnosis [s].
    pub seconds: f64,
}

impl FamilyRates {
    fn new(of: &[&Outcome]) -> Self {
        let rate = |is: fn(&Outcome) -> bool| Rate::new(of.iter().map(|outcome| is(outcome)));
        Self {
            exact: rate(Outcome::is_exact),
            right: rate(Outcome::is_right),
            false_names: rate(Outcome::is_false_name),
            seconds: median(of.iter().map(|outcome| outcome.seconds).collect()).unwrap_or(0.0),
        }
    }
}

/// All cases in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// By family.
    pub families: BTreeMap<Family, FamilyRates>,
    /// Testable single effects of at least four detectable sizes that were named, or their class.
    pub large_singles: Rate,
    /// The same by multiple of the detectable size.
    pub by_size: Vec<(f64, Rate)>,
    /// Effects named where nothing is hidden.
    pub false_alarms: Rate,
    /// Effects named where the hidden one is unknown or absorbed.
    pub false_names: Rate,
}

impl Summary {
    /// Counts outcomes.
    pub fn new(outcomes: &[Outcome]) -> Self {
        let mut families: BTreeMap<Family, Vec<&Outcome>> = BTreeMap::new();
        outcomes.iter().for_each(|outcome| families.entry(outcome.case.family).or_default().push(outcome));
        let single = |outcome: &&Outcome| outcome.case.family == Family::S && outcome.testable == Some(true);
        let singles = || outcomes.iter().filter(single);
        let multiple = |outcome: &Outcome| match outcome.case.size {
            Sized::Detectable(multiple) => multiple,
            Sized::Visible => f64::NAN,
        };
        let mut sizes: Vec<f64> = singles().map(multiple).collect();
        sizes.sort_by(f64::total_cmp);
        sizes.dedup();
        let sized = |&size: &f64| (size, Rate::new(singles().filter(|o| multiple(o) == size).map(Outcome::is_right)));
        let empty = outcomes.iter().filter(|outcome| outcome.case.hidden.is_empty());
        let foreign = outcomes.iter().filter(|outcome| matches!(outcome.case.family, Family::U | Family::A));
        Self {
            families: families.iter().map(|(family, of)| (*family, FamilyRates::new(of))).collect(),
            large_singles: Rate::new(singles().filter(|o| multiple(o) >= LARGE).map(Outcome::is_right)),
            by_size: sizes.iter().map(sized).collect(),
            false_alarms: Rate::new(empty.map(Outcome::is_named)),
            false_names: Rate::new(foreign.map(Outcome::is_false_name)),
        }
    }

    /// Tables in Markdown: the rates, then every case, failures included.
    pub fn to_markdown(&self, outcomes: &[Outcome]) -> String {
        let mut text = String::from(
            "# Benchmark of the diagnosis\n\n| family | named exactly | as asked | false names | median s |\n|---|---|---|---|---|\n",
        );
        for (family, FamilyRates { exact, right, false_names, seconds }) in &self.families {
            text += &format!("| {family:?} | {exact} | {right} | {false_names} | {seconds:.0} |\n");
        }
        text += &format!(
            "\n- testable single effects of at least {LARGE} detectable sizes, class named: {}\n",
            self.large_singles
        );
        for (size, rate) in &self.by_size {
            text += &format!("- of {size} detectable sizes: {rate}\n");
        }
        text += &format!("- false alarms where nothing is hidden: {}\n", self.false_alarms);
        text += &format!("- false names where the effect is unknown or absorbed: {}\n\n", self.false_names);
        text += "| case | design | hidden | size | verdict | named (look-alikes) | p | held out before, after, floor [µm] | as asked |\n\
                 |---|---|---|---|---|---|---|---|---|\n";
        outcomes.iter().for_each(|outcome| text += &row(outcome));
        text
    }
}

fn row(outcome: &Outcome) -> String {
    let case = &outcome.case;
    let name = |(name, alike): (&String, &Vec<String>)| match alike.is_empty() {
        true => name.clone(),
        false => format!("{name} ({})", alike.join(", ")),
    };
    let named: Vec<String> = outcome.named.iter().zip(&outcome.alike).map(name).collect();
    let error = |error: Option<f64>| error.map_or("-".to_owned(), |error| format!("{error:.2}"));
    let size = match (case.size, outcome.testable) {
        (Sized::Visible, _) => "visible".to_owned(),
        (Sized::Detectable(multiple), Some(true)) => format!("{multiple}"),
        (Sized::Detectable(_), _) => "not testable".to_owned(),
    };
    format!(
        "| {} | {} | {}{} | {size} | {} | {} | {} | {}, {}, {:.2} | {} |\n",
        case.id(),
        case.design.id(),
        case.hidden.join(" + "),
        if case.left_out { " (not in the library)" } else { "" },
        serde_json::to_value(outcome.verdict).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default(),
        named.join(" + "),
        outcome.probability.map_or("-".to_owned(), |p| format!("{p:.2}")),
        error(outcome.evaluation_um[0]),
        error(outcome.evaluation_um[1]),
        outcome.floor_um,
        if outcome.is_right() { "yes" } else { "no" },
    )
}
