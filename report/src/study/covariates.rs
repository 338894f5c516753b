//! Residual over each covariate of the simulation.

use std::fmt::Write;

use super::number::{p_value, percent, share_cell, significant};
use crate::{Cell, Chart, Page, Series, Stroke, Table, escape};
use study::{Bin, CovariatePlot};

const SIZE: (f64, f64) = (440.0, 240.0);
const BASE: Stroke = Stroke { colour: "#d55e00", dashed: true };
const WITH_EFFECT: Stroke = Stroke { colour: "#0072b2", dashed: false };

/// Appends the covariates, those that explain most first.
pub(super) fn add(page: &mut Page, plots: &[CovariatePlot]) {
    if plots.is_empty() {
        return;
    }
    page.subsection("Residual against covariates");
    page.paragraph(
        "Mean of (measured − simulated) / simulated removal, or of the difference in exposed share when sanding, in bins of each covariate, with its 95 % \
         band: above zero the real tool takes off more. The share is that of the excess variance which the covariate explains by itself, the drop what all of them \
         together explain less without it. The p-value keeps the correlation of neighbouring tiles; the last one is corrected for the number of covariates.",
    );
    let mut sorted: Vec<&CovariatePlot> = plots.iter().collect();
    sorted.sort_by(|a, b| b.share.total_cmp(&a.share));
    let mut figures = String::new();
    let mut table = Table::new(
        "Covariates",
        &["covariate", "share explained", "drop without it", "p-value", "p among all", "residual at most"],
    );
    for plot in sorted {
        let name = escape(&plot.name);
        let stated = format!("{} explained, p {}", percent(plot.share), equals(plot.p_value));
        let _ = write!(
            figures,
            "<figure>{}<figcaption><b>{name}</b>: {}</figcaption></figure>",
            drawing(plot),
            escape(&stated)
        );
        table.rows.push(row(plot));
    }
    page.block(&format!("<div class=\"pair\">{figures}</div>\n{}", table.to_html()));
}

fn equals(p: f64) -> String {
    let text = p_value(p);
    if text.starts_with('<') { text } else { format!("= {text}") }
}

fn drawing(plot: &CovariatePlot) -> String {
    let line = |name: &str, bins: &[Bin], stroke| Series {
        stroke: Some(stroke),
        band: bins.iter().map(|bin| (100.0 * bin.band[0], 100.0 * bin.band[1])).collect(),
        ..Series::new(name, bins.iter().map(|b| (plot.unit.of(b.covariate), 100.0 * b.residual)).collect())
    };
    let mut series = vec![line("base model", &plot.bins, BASE)];
    if !plot.with_effect.is_empty() {
        series.push(line("with effect", &plot.with_effect, WITH_EFFECT));
    }
    let unit = if plot.unit.unit.is_empty() { String::new() } else { format!(" [{}]", plot.unit.unit) };
    Chart {
        title: &format!("Residual against {}", plot.name),
        x_label: &format!("{}{unit}", plot.name),
        y_label: "residual [%]",
        series: &series,
        size: SIZE,
        from_zero: false,
        band: None,
    }
    .to_svg()
}

fn row(plot: &CovariatePlot) -> Vec<Cell> {
    let most = plot.bins.iter().max_by(|a, b| a.residual.abs().total_cmp(&b.residual.abs()));
    let most = most.map_or(Cell::absent(), |bin| {
        let at = significant(plot.unit.of(bin.covariate), 3);
        let shown = format!("{} at {at} {}", percent(bin.residual), plot.unit.unit);
        Cell::number(shown.trim_end().to_owned(), bin.residual)
    });
    let p = |value: f64| Cell::number(p_value(value), value);
    let (share, drop) = (share_cell(Some(plot.share)), share_cell(Some(plot.drop)));
    vec![Cell::text(&plot.name), share, drop, p(plot.p_value), p(plot.p_value_of_all), most]
}
