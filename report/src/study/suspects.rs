//! Scored effects, and the tests for missing effects.

use super::number::{cell, p_value, percent, significant};
use crate::{Cell, Page, Table, escape};
use study::Misfit;
use study::with_raised_powers;
use study::{Suspect, TestOfMissing};

/// Appends the tests of the base model's residual.
pub(super) fn add_tests(page: &mut Page, tests: &[TestOfMissing]) {
    if tests.is_empty() {
        return;
    }
    page.subsection("Is anything missing?");
    let mut table = Table::new(
        "Tests of the base model's residual for structure; each verdict is corrected for their number",
        &["test", "statistic", "p-value", "structure"],
    );
    for test in tests {
        table.rows.push(vec![
            Cell::text(&test.name),
            Cell::number(significant(test.statistic, 3), test.statistic),
            Cell::number(p_value(test.p_value), test.p_value),
            Cell::text(if test.rejects { "found" } else { "not found" }),
        ]);
    }
    page.block(&table.to_html());
}

/// Appends the table of suspects and a sentence for each.
pub(super) fn add(page: &mut Page, suspects: &[Suspect], misfit: &Misfit) {
    page.part("suspects", "Suspects");
    if suspects.is_empty() {
        return page.paragraph("No effect was scored.");
    }
    let unit = &misfit.unit.unit;
    let mut table = Table::new(
        "All effects that were tried. Δχ² is the fall of the whitened sum of squares when the effect is added; effects \
         without one were not fitted",
        &["effect", "what it is", "probability", "Δχ²", "", "", "indistinguishable from"],
    );
    table.headings[4] = format!("evaluation before [{unit}]");
    table.headings[5] = format!("after [{unit}]");
    table.rows = suspects.iter().map(|suspect| row(suspect, misfit)).collect();
    page.block(&table.to_html());
    let note = |suspect: &Suspect| {
        let words = escape(&with_raised_powers(&suspect.note));
        format!("<dt><code>{}</code></dt><dd>{words}</dd>\n", escape(&suspect.name))
    };
    let notes: String = suspects.iter().filter(|suspect| !suspect.note.is_empty()).map(note).collect();
    if !notes.is_empty() {
        page.subsection("Why each is in or out");
        page.block(&format!("<dl>\n{notes}</dl>\n"));
    }
}

fn row(suspect: &Suspect, misfit: &Misfit) -> Vec<Cell> {
    let si = misfit.unit.si_per_unit;
    let look_alikes = if suspect.look_alikes.is_empty() { "none".to_owned() } else { suspect.look_alikes.join(", ") };
    vec![
        Cell::text(&suspect.name),
        Cell::text(&suspect.title),
        Cell::number(percent(suspect.probability), suspect.probability),
        cell(suspect.delta_chi2, 1.0, 3),
        cell(suspect.evaluation_before, si, 3),
        cell(suspect.evaluation_after, si, 3),
        Cell::text(look_alikes),
    ]
}
