//! Scored effects, and the tests for missing effects.

use super::number::{cell, p_value, percent, significant};
use crate::{Cell, Page, Table, escape};
use lab::{EffectSummary, StructureTest, Unfitted};
use study::{StudyReport, with_raised_powers};

/// Appends the tests of the base model's residual.
pub(super) fn add_tests(page: &mut Page, tests: &[StructureTest]) {
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
pub(super) fn add(page: &mut Page, report: &StudyReport) {
    let (fitted, unfitted, misfit) = (&report.suspects, &report.unfitted, &report.waterfall.misfit);
    page.part("suspects", "Suspects");
    if fitted.is_empty() && unfitted.is_empty() {
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
    table.rows = fitted.iter().map(|one| row(one, misfit.unit.si_per_unit)).chain(unfitted.iter().map(bare)).collect();
    page.block(&table.to_html());
    let note = |(name, words): (&str, String)| {
        format!("<dt><code>{}</code></dt><dd>{}</dd>\n", escape(name), escape(&with_raised_powers(&words)))
    };
    let notes: String = reasons(fitted, unfitted).into_iter().map(note).collect();
    page.subsection("Why each is in or out");
    page.block(&format!("<dl>\n{notes}</dl>\n"));
}

fn row(suspect: &EffectSummary, si: f64) -> Vec<Cell> {
    let indistinguishable = &suspect.indistinguishable_from;
    vec![
        Cell::text(&suspect.name),
        Cell::text(&suspect.title),
        Cell::number(percent(suspect.probability), suspect.probability),
        cell(Some(suspect.delta_chi2), 1.0, 3),
        cell(suspect.evaluation_rms_before, si, 3),
        cell(suspect.evaluation_rms_after, si, 3),
        Cell::text(if indistinguishable.is_empty() { "none".to_owned() } else { indistinguishable.join(", ") }),
    ]
}

fn bare(one: &Unfitted) -> Vec<Cell> {
    let absent = [Cell::absent(), Cell::absent(), Cell::absent(), Cell::text("none")];
    let known = [Cell::text(&one.name), Cell::text(&one.title), Cell::number(percent(0.0), 0.0)];
    known.into_iter().chain(absent).collect()
}

/// The reason for or against each effect, fitted ones first.
fn reasons<'a>(fitted: &'a [EffectSummary], unfitted: &'a [Unfitted]) -> Vec<(&'a str, String)> {
    let searches = fitted.iter().map(|suspect| suspect.search).max().unwrap_or(0);
    let of_search = |search| if searches > 1 { format!("Search {search} of {searches}. ") } else { String::new() };
    let ranked = fitted.chunk_by(|a, b| a.search == b.search).flat_map(|search| search.iter().enumerate());
    let weighed = ranked.map(|(rank, one)| (one.name.as_str(), of_search(one.search) + &reason(one, rank)));
    let left = unfitted.iter().map(|one| (one.name.as_str(), format!("{}Out: {}.", of_search(one.search), one.reason)));
    weighed.chain(left).collect()
}

/// - `rank`: rank in its search by probability, from 0
fn reason(suspect: &EffectSummary, rank: usize) -> String {
    match (&suspect.ruled_out, &suspect.indistinguishable_from[..]) {
        (Some(reason), _) => format!("Out: {reason}."),
        (None, []) if rank == 0 => "In: the most probable one.".to_owned(),
        (None, []) => "In: the data do not decide between it and the most probable one.".to_owned(),
        (None, alike) => {
            format!("In: the most probable one, which these data cannot distinguish from {}.", alike.join(", "))
        }
    }
}
