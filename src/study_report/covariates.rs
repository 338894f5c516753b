//! Residual against what the simulator knows of each place.

use std::fmt::Write;

use super::number::{chance, share_cell, significant};
use super::scan_data::{Bin, CovariatePlot, Misfit};
use crate::report::{Cell, Chart, Page, Series, Stroke, Table, escape};

const SIZE: (f64, f64) = (440.0, 240.0);
const BASE: Stroke = Stroke { colour: "#d55e00", dashed: true };
const WITH_EFFECT: Stroke = Stroke { colour: "#0072b2", dashed: false };

/// Appends the covariates, those that explain most first.
pub(super) fn add(page: &mut Page, plots: &[CovariatePlot], misfit: &Misfit) {
    if plots.is_empty() {
        return;
    }
    page.subsection("Residual against covariates");
    page.paragraph(
        "Mean of measured minus simulated in bins of each covariate, with its 95 % band. The share is that of the excess variance which the covariate \
         explains by itself; the p-value keeps the correlation of neighbouring pixels.",
    );
    let mut sorted: Vec<&CovariatePlot> = plots.iter().collect();
    sorted.sort_by(|a, b| b.share.total_cmp(&a.share));
    let mut figures = String::new();
    let mut table = Table::new("Covariates", &["covariate", "share explained", "p-value", "residual at most"]);
    for plot in sorted {
        let name = escape(&plot.name);
        let stated = format!("{} explained, p {}", super::number::percent(plot.share), equals(plot.p_value));
        let _ = write!(
            figures,
            "<figure>{}<figcaption><b>{name}</b>: {}</figcaption></figure>",
            drawing(plot, misfit),
            escape(&stated)
        );
        table.rows.push(row(plot, misfit));
    }
    page.block(&format!("<div class=\"pair\">{figures}</div>\n{}", table.to_html()));
}

fn equals(p: f64) -> String {
    let text = chance(p);
    if text.starts_with('<') { text } else { format!("= {text}") }
}

fn drawing(plot: &CovariatePlot, misfit: &Misfit) -> String {
    let line = |name: &str, bins: &[Bin], stroke| Series {
        stroke: Some(stroke),
        band: bins.iter().map(|bin| (misfit.unit.of(bin.band[0]), misfit.unit.of(bin.band[1]))).collect(),
        ..Series::new(name, bins.iter().map(|b| (plot.unit.of(b.covariate), misfit.unit.of(b.residual))).collect())
    };
    let mut series = vec![line("base model", &plot.bins, BASE)];
    if !plot.with_effect.is_empty() {
        series.push(line("with effect", &plot.with_effect, WITH_EFFECT));
    }
    let unit = if plot.unit.unit.is_empty() { String::new() } else { format!(" [{}]", plot.unit.unit) };
    Chart {
        title: &format!("Residual against {}", plot.name),
        x_label: &format!("{}{unit}", plot.name),
        y_label: &format!("residual [{}]", misfit.unit.unit),
        series: &series,
        size: SIZE,
        from_zero: false,
        band: None,
    }
    .to_svg()
}

fn row(plot: &CovariatePlot, misfit: &Misfit) -> Vec<Cell> {
    let most = plot.bins.iter().max_by(|a, b| a.residual.abs().total_cmp(&b.residual.abs()));
    let most = most.map_or(Cell::absent(), |bin| {
        let shown = format!(
            "{} {} at {} {}",
            significant(misfit.unit.of(bin.residual), 3),
            misfit.unit.unit,
            significant(plot.unit.of(bin.covariate), 3),
            plot.unit.unit
        );
        Cell::number(shown.trim_end().to_owned(), bin.residual)
    });
    vec![Cell::text(&plot.name), share_cell(Some(plot.share)), Cell::number(chance(plot.p_value), plot.p_value), most]
}
