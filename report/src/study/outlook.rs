//! Detectable sizes, next steps, and a proposed form for an unlisted effect.

use super::number::{cell, percent, significant};
use super::words::list;
use crate::{Cell, Page, Table};
use lab::{Detectable, MenuChoice, MenuLine, NextTrial, ParameterState, ParameterSummary, Sides, Verdict, Worth};
use study::{Conclusion, StudyReport, with_raised_powers};

/// Appends the detectable size of each effect.
pub(super) fn add_detectable(page: &mut Page, detectable: &[Detectable]) {
    if detectable.is_empty() {
        return;
    }
    page.part("detectable", "What these passes could show");
    page.paragraph(
        "The least size of each effect that would have been found, at 5 % error over all effects and 80 % power. What is smaller may be present.",
    );
    let mut table = Table::new("Detectable sizes", &["effect", "parameter", "least size", "unit", "remark"]);
    for row in detectable {
        let size =
            if row.size.is_some() { cell(row.size, 1.0, 3) } else { Cell::number("none shows".to_owned(), f64::NAN) };
        table.rows.push(vec![
            Cell::text(&row.effect),
            Cell::text(&row.parameter),
            size,
            Cell::text(with_raised_powers(&row.unit)),
            Cell::text(limits(row)),
        ]);
    }
    page.block(&table.without_empty_columns().to_html());
}

/// Conditions under which a size is detectable, in words.
fn limits(row: &Detectable) -> &'static str {
    match (row.testable, row.sides) {
        (false, _) => "not testable with these passes",
        (true, Sides::All) => "",
        (true, Sides::Above) => "only above its null",
        (true, Sides::Below) => "only below its null",
    }
}

/// Appends the next trial.
pub(super) fn add_next(page: &mut Page, report: &StudyReport) {
    page.part("next", "The next trial");
    let Some(next) = &report.next_trial else {
        return page.paragraph(&worth_of_another(report));
    };
    page.paragraph(&next.summary);
    let settings =
        [("force", &next.force_n, "N"), ("feed", &next.feed_mm_s, "mm/s"), ("spindle speed", &next.spindle_rpm, "rpm")];
    let known = settings.iter().filter(|(_, values, _)| !values.is_empty());
    let settings: Vec<_> = known.map(|(name, values, unit)| (*name, format!("{} {unit}", listed(values)))).collect();
    if !settings.is_empty() {
        page.facts(&settings);
    }
    let question = match &next.separates[..] {
        [tested] => format!("Whether {tested} predicts passes that no fit has seen."),
        rivals => {
            let probability = next.probability_right;
            page.block(&format!(
                "<p data-value=\"{}\">Probability that it names the right one: <b>{}</b>.</p>\n",
                crate::exact(probability),
                percent(probability)
            ));
            format!("Whether it is {}.", rivals.join(" or "))
        }
    };
    if let Some(choice) = &next.choice {
        add_menu(page, next, choice);
    }
    page.block(&format!("<h3>It would settle</h3>\n{}", list(&[question])));
}

/// Formats the settings of several passes.
fn listed(values: &[f64]) -> String {
    let shown = |value: &f64| format!("{value:.4}").trim_end_matches('0').trim_end_matches('.').to_owned();
    values.iter().map(shown).collect::<Vec<_>>().join(", ")
}

/// Appends the best trials of the menu, with their costs and expected information.
fn add_menu(page: &mut Page, next: &NextTrial, choice: &MenuChoice) {
    let headings = ["place", "trial", "time [min]", "workpieces", "information [nat]", "per hour [nat]"];
    let mut table = Table::new("The best trials of the menu", &headings);
    let mut add = |place: &str, summary: &str, worth: &Worth| {
        let number = |value: f64| Cell::number(significant(value, 3), value);
        table.rows.push(vec![
            Cell::text(place),
            Cell::text(summary),
            number(worth.minutes),
            Cell::number(worth.workpieces.to_string(), worth.workpieces as f64),
            number(worth.expected_information_nats),
            number(60.0 * worth.nats_per_minute),
        ]);
    };
    add("1", &next.summary, &choice.worth);
    let runners_up = (2..).zip(&choice.runners_up).map(|(place, line): (usize, &MenuLine)| (place.to_string(), line));
    let then = choice.then.iter().map(|line| ("after 1".to_owned(), line));
    runners_up.chain(then).for_each(|(place, line)| add(&place, &line.summary, &line.worth));
    page.block(&table.to_html());
    page.paragraph(
        "Time counts set-up, scans, dressing and passes, by the assumptions that the documents list. Information is the least \
         expected fall of the entropy of the probabilities.",
    );
}

/// Describes the benefit of another trial if no two effects have to be distinguished.
fn worth_of_another(report: &StudyReport) -> String {
    let open = |parameter: &&ParameterSummary| parameter.state == ParameterState::NotIdentifiable;
    let open: Vec<&str> = report.parameters.iter().filter(open).map(|parameter| parameter.name.as_str()).collect();
    let open = match &open[..] {
        [] => String::new(),
        names => {
            format!(" Other settings of force, feed or speed could show what these leave open: {}.", names.join(", "))
        }
    };
    // The standard error of a mean falls with the square root of the number of measurements.
    let buys = match report.conclusion {
        Conclusion::Searched(Verdict::Identified) => {
            "One effect is left, so no trial has to separate two. The same passes on another workpiece would make the intervals of its parameters about 0.7 times as wide."
        }
        Conclusion::Searched(Verdict::Hint) => {
            "One effect shows, so no trial has to separate two. Passes in which it is stronger, longer ones or such at other forces and speeds, would make sure of it."
        }
        Conclusion::Searched(Verdict::NothingMissing) => {
            "Nothing is missing, so no trial has to separate two effects. The same passes on another workpiece would make the least detectable sizes about 0.7 times as large."
        }
        Conclusion::Searched(Verdict::NotTestable) => {
            "These passes leave no two effects to separate. Passes at other forces, feeds and spindle speeds would \
             make more of them detectable."
        }
        _ => {
            "No two effects of the library remain to be separated. A trial that changes force, feed or spindle speed \
             within a pass would show what the remaining error depends on."
        }
    };
    format!("{buys}{open}")
}
