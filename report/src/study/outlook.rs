//! Detectable sizes, next steps, and a proposed form for an unlisted effect.

use super::number::{cell, percent, significant};
use super::words::list;
use crate::{Cell, Page, Table};
use study::{Detectable, MenuRow, ParameterEstimate, StudyReport, Verdict};

/// Appends the detectable size of each effect.
pub(super) fn add_detectable(page: &mut Page, detectable: &[Detectable]) {
    if detectable.is_empty() {
        return;
    }
    page.part("detectable", "What these passes could show");
    page.paragraph(
        "The least size of each effect that would have been found, at 5 % error over all effects and 80 % power. What is smaller may be present.",
    );
    let mut table = Table::new(
        "Detectable sizes",
        &["effect", "parameter", "least size", "typical", "unit", "its map, rms [µm]", "remark"],
    );
    for row in detectable {
        let si = row.unit.si_per_unit;
        let size =
            if row.size.is_some() { cell(row.size, si, 3) } else { Cell::number("none shows".to_owned(), f64::NAN) };
        table.rows.push(vec![
            Cell::text(&row.name),
            Cell::text(&row.parameter),
            size,
            cell(row.typical, si, 3),
            Cell::text(&row.unit.unit),
            cell(row.map_rms, 1e-6, 3),
            Cell::text(&row.note),
        ]);
    }
    page.block(&table.without_empty_columns().to_html());
}

/// Appends the next trial.
pub(super) fn add_next(page: &mut Page, report: &StudyReport) {
    page.part("next", "The next trial");
    let Some(next) = &report.next_trial else {
        return page.paragraph(&worth_of_another(report));
    };
    page.paragraph(&next.summary);
    if !next.steps.is_empty() {
        page.facts(&next.steps);
    }
    if let Some(probability) = next.probability_right {
        let html = format!(
            "<p data-value=\"{}\">Probability that it names the right one: <b>{}</b>.</p>\n",
            crate::exact(probability),
            percent(probability)
        );
        page.block(&html);
    }
    add_menu(page, &next.menu);
    for (heading, items) in [("It would settle", &next.settles), ("It would leave open", &next.leaves_open)] {
        if !items.is_empty() {
            page.block(&format!("<h3>{heading}</h3>\n{}", list(items)));
        }
    }
}

/// Appends the best trials of the menu, with their costs and expected information.
fn add_menu(page: &mut Page, menu: &[MenuRow]) {
    if menu.is_empty() {
        return;
    }
    let headings = ["place", "trial", "time [min]", "workpieces", "information [nat]", "per hour [nat]"];
    let mut table = Table::new("The best trials of the menu", &headings);
    for row in menu {
        let number = |value: f64, digits: usize| Cell::number(significant(value, digits), value);
        table.rows.push(vec![
            Cell::text(&row.place),
            Cell::text(&row.summary),
            number(row.minutes, 3),
            Cell::number(row.workpieces.to_string(), row.workpieces as f64),
            number(row.information, 3),
            number(60.0 * row.information_per_minute, 3),
        ]);
    }
    page.block(&table.to_html());
    page.paragraph(
        "Time counts set-up, scans, dressing and passes, by the assumptions that the documents list. Information is the least \
         expected fall of the entropy of the probabilities.",
    );
}

/// Describes the benefit of another trial if no two effects have to be distinguished.
fn worth_of_another(report: &StudyReport) -> String {
    let open = |parameter: &&ParameterEstimate| !parameter.fixed && !parameter.identifiable;
    let open: Vec<&str> = report.parameters.iter().filter(open).map(|parameter| parameter.name.as_str()).collect();
    let open = match &open[..] {
        [] => String::new(),
        names => {
            format!(" Other settings of force, feed or speed could show what these leave open: {}.", names.join(", "))
        }
    };
    // The standard error of a mean falls with the square root of the number of measurements.
    let buys = match report.verdict {
        Verdict::Identified => {
            "One effect is left, so no trial has to separate two. The same passes on another workpiece would make the intervals of its parameters about 0.7 times as wide."
        }
        Verdict::Hint => {
            "One effect shows, so no trial has to separate two. Passes in which it is stronger, longer ones or such at other forces and speeds, would make sure of it."
        }
        Verdict::NothingMissing => {
            "Nothing is missing, so no trial has to separate two effects. The same passes on another workpiece would make the least detectable sizes about 0.7 times as large."
        }
        Verdict::NotTestable => {
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
