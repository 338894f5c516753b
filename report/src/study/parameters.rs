//! Fitted parameters with their intervals, and their correlations.

use std::fmt::Write;

use super::number::{cell, fixed};
use crate::{Cell, Page, Table, escape, exact};
use lab::{Correlation, ParameterSummary};
use study::with_raised_powers;

/// Absolute correlation from which a cell is emphasised.
const STRONG: f64 = 0.9;

/// Appends parameters and correlations.
pub(super) fn add(page: &mut Page, parameters: &[ParameterSummary], correlations: &[Correlation]) {
    if parameters.is_empty() {
        return;
    }
    page.part("parameters", "Parameters");
    let mut table =
        Table::new("Values with 95 % intervals", &["parameter", "value", "95 % from", "to", "unit", "remark"]);
    table.rows = parameters.iter().map(row).collect();
    page.block(&table.to_html());
    if !correlations.is_empty() {
        let names: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
        page.block(&matrix(&names, correlations));
    }
}

fn row(parameter: &ParameterSummary) -> Vec<Cell> {
    let end = |k: usize| cell(parameter.interval.map(|interval| interval[k]), 1.0, 4);
    vec![
        Cell::text(&parameter.name),
        cell(Some(parameter.value), 1.0, 4),
        end(0),
        end(1),
        Cell::text(with_raised_powers(&parameter.unit)),
        Cell::text(parameter.state.words().unwrap_or_default()),
    ]
}

/// Draws the lower triangle of the correlations; rows are numbered to keep columns narrow.
fn matrix(names: &[&str], correlations: &[Correlation]) -> String {
    let count = names.len();
    let value = |a: &str, b: &str| {
        let same = |pair: &&Correlation| pair.between == [a, b] || pair.between == [b, a];
        correlations.iter().find(same).and_then(|pair| pair.value).unwrap_or(f64::NAN)
    };
    let heads: String = (1..count).map(|k| format!("<th scope=\"col\" class=\"n\">{k}</th>")).collect();
    let mut rows = String::new();
    for (i, name) in names.iter().enumerate() {
        let _ = write!(rows, "<tr><th scope=\"row\">{} {}</th>", i + 1, escape(name));
        for (j, other) in names[..count - 1].iter().enumerate() {
            let value = value(name, other);
            let strong = if value.abs() >= STRONG { " strong" } else { "" };
            let _ = match (j < i, value.is_finite()) {
                (true, true) => {
                    let (full, shown) = (exact(value), fixed(value, 2));
                    write!(rows, "<td class=\"n{strong}\" data-value=\"{full}\">{shown}</td>")
                }
                (true, false) => write!(rows, "<td class=\"n\">–</td>"),
                _ => write!(rows, "<td></td>"),
            };
        }
        rows += "</tr>\n";
    }
    format!(
        "<div class=\"scroll\"><table class=\"matrix\">\n<caption>Correlations of the estimates; {STRONG} and more are in bold</caption>\n\
         <thead><tr><th scope=\"col\">parameter</th>{heads}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n"
    )
}
