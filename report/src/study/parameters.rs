//! Fitted parameters with their intervals, and their correlations.

use std::fmt::Write;

use super::number::{cell, fixed};
use crate::{Cell, Page, Table, escape, exact};
use study::{Correlations, ParameterEstimate};

/// Absolute correlation from which a cell is emphasised.
const STRONG: f64 = 0.9;

/// Appends parameters and correlations.
pub(super) fn add(page: &mut Page, parameters: &[ParameterEstimate], correlations: Option<&Correlations>) {
    if parameters.is_empty() {
        return;
    }
    page.part("parameters", "Parameters");
    let mut table =
        Table::new("Values with 95 % intervals", &["parameter", "value", "95 % from", "to", "unit", "remark"]);
    table.rows = parameters.iter().map(row).collect();
    page.block(&table.to_html());
    if let Some(correlations) = correlations.filter(|correlations| correlations.names.len() > 1) {
        page.block(&matrix(correlations));
    }
}

fn row(parameter: &ParameterEstimate) -> Vec<Cell> {
    let si = parameter.unit.si_per_unit;
    let end = |k: usize| cell(parameter.interval.map(|interval| interval[k]), si, 4);
    vec![
        Cell::text(&parameter.name),
        cell(Some(parameter.value), si, 4),
        end(0),
        end(1),
        Cell::text(&parameter.unit.unit),
        Cell::text(remark(parameter)),
    ]
}

fn remark(parameter: &ParameterEstimate) -> String {
    let remarks = [
        (parameter.fixed, "held fixed"),
        (parameter.on_bound, "on a bound"),
        (!parameter.identifiable && !parameter.fixed, "not identifiable"),
    ];
    let remarks: Vec<&str> = remarks.iter().filter(|(holds, _)| *holds).map(|(_, words)| *words).collect();
    remarks.join(", ")
}

/// Draws the lower triangle of the correlations; rows are numbered to keep columns narrow.
fn matrix(correlations: &Correlations) -> String {
    let count = correlations.names.len();
    let heads: String = (1..count).map(|k| format!("<th scope=\"col\" class=\"n\">{k}</th>")).collect();
    let mut rows = String::new();
    for (i, name) in correlations.names.iter().enumerate() {
        let _ = write!(rows, "<tr><th scope=\"row\">{} {}</th>", i + 1, escape(name));
        for j in 0..count - 1 {
            let value = correlations.values[i * count + j];
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
