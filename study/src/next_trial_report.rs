//! Report of the next trial.

use super::MenuRow;
use lab::{MenuChoice, MenuLine, NextTrial, Worth};

/// Converts a proposed trial to the report: description, questions that it settles, and the alternatives on the menu.
pub(super) fn next_trial(next: &NextTrial) -> crate::NextTrial {
    let list = |values: &[f64]| {
        values
            .iter()
            .map(|value| format!("{value:.4}").trim_end_matches('0').trim_end_matches('.').to_owned())
            .collect::<Vec<_>>()
            .join(", ")
    };
    let steps =
        [("force", &next.force_n, "N"), ("feed", &next.feed_mm_s, "mm/s"), ("spindle speed", &next.spindle_rpm, "rpm")];
    let steps = steps.iter().filter(|(_, values, _)| !values.is_empty());
    let (question, probability_right) = match &next.separates[..] {
        [tested] => (format!("Whether {tested} predicts passes that no fit has seen."), None),
        rivals => (format!("Whether it is {}.", rivals.join(" or ")), Some(next.probability_right)),
    };
    crate::NextTrial {
        summary: next.summary.clone(),
        steps: steps.map(|(name, values, unit)| ((*name).to_owned(), format!("{} {unit}", list(values)))).collect(),
        settles: vec![question],
        leaves_open: Vec::new(),
        probability_right,
        menu: next.choice.as_ref().map_or_else(Vec::new, |choice| menu(next, choice)),
    }
}

/// The trial itself, the next best ones, and the one that would follow.
fn menu(next: &NextTrial, choice: &MenuChoice) -> Vec<MenuRow> {
    let row = |place: &str, summary: &str, worth: Worth| MenuRow {
        place: place.to_owned(),
        summary: summary.to_owned(),
        minutes: worth.minutes,
        workpieces: worth.workpieces,
        information: worth.expected_information_nats,
        information_per_minute: worth.nats_per_minute,
    };
    let line = |place: &str, line: &MenuLine| row(place, &line.summary, line.worth);
    let runners_up = (2..).zip(&choice.runners_up).map(|(place, runner)| line(&place.to_string(), runner));
    let first = row("1", &next.summary, choice.worth);
    let then = choice.then.iter().map(|then| line("after 1", then));
    std::iter::once(first).chain(runners_up).chain(then).collect()
}
