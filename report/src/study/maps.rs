//! Residual maps of base model and best model, with their statistics.

use std::fmt::Write;

use super::colour_scale::{BAND_FLOORS, ColourScale, css};
use super::number::{fixed, fixed_cell, share_cell};
use super::statistics::Statistics;
use super::words::role;
use crate::map_image::{MapImage, Values};
use crate::{Cell, Page, Table, escape, short};
use study::{HeightMaps, Maps, ScanComparison};

/// Width of a map beside another, and of a single map [px].
pub(super) const BESIDE: f64 = 480.0;
pub(super) const ALONE: f64 = 900.0;
/// Histogram bins in each step of the colour scale.
const BINS: usize = 4;
/// Height of the histogram and of the colour bar below it [px].
const HISTOGRAM: f64 = 44.0;
const BAR: f64 = 12.0;
const LEFT: f64 = 34.0;
const RIGHT: f64 = 8.0;
/// Space below the colour bar for the numbers, the bracket of the band and its name with descenders [px].
const BELOW: f64 = 38.0;

/// Appends the residual maps of all height scans.
pub(super) fn add(page: &mut Page, scans: &[ScanComparison]) {
    let heights = |scan| match scan {
        &ScanComparison { maps: Maps::Heights(ref maps), .. } => Some(maps),
        _ => None,
    };
    let floor = page_noise(scans);
    if !scans.iter().any(|scan| heights(scan).is_some()) {
        return;
    }
    page.subsection("Residual maps");
    if floor <= 0.0 {
        return page.paragraph("The noise of no scan is known, so that no tolerance band and no scale can be stated.");
    }
    let residuals = scans.iter().filter_map(heights).flat_map(|m| m.base.iter().chain(m.with_effect.iter().flatten()));
    let scale = ColourScale::new(floor, residuals.copied());
    page.paragraph(&reading(&scale, floor));
    for scan in scans {
        if let Maps::Heights(maps) = &scan.maps {
            page.block(&scan_html(scan, maps, &scale));
        }
    }
}

/// Returns the greatest scan noise of all scans [m], from which the tolerance band of the page follows.
pub(super) fn page_noise(scans: &[ScanComparison]) -> f64 {
    let noise = |scan: &ScanComparison| if let Maps::Heights(maps) = &scan.maps { maps.noise_floor } else { 0.0 };
    scans.iter().map(noise).fold(0.0, f64::max)
}

fn reading(scale: &ColourScale, floor: f64) -> String {
    format!(
        "Measured minus simulated: orange is material left over, blue is too much taken off, grey is not measured. All maps share one scale. The \
         tolerance band, in pale colours, is ±{} µm, which is {BAND_FLOORS:.0} times the scan noise of {} µm; beyond it each step is twice as wide as \
         the one before.",
        fixed(scale.band * 1e6, 1),
        fixed(floor * 1e6, 2)
    )
}

fn scan_html(scan: &ScanComparison, maps: &HeightMaps, scale: &ColourScale) -> String {
    let width = if maps.with_effect.is_some() { BESIDE } else { ALONE };
    let mut table = Table::new(
        &format!("Residuals of {} over the pixels {} [µm]", scan.pass, maps.judged_as),
        &["model", "within band", "mean", "std. dev.", "rms", "5 %", "95 %", "pixels", "missing"],
    );
    let mut figures = String::new();
    for (label, residuals) in residual_maps(maps) {
        let judged = || residuals.iter().zip(&maps.judged).filter(|(_, judged)| **judged).map(|(r, _)| *r);
        let title = format!("{}: measured minus {label}, by place", scan.pass);
        let image = MapImage {
            pixels: maps.pixels,
            colours: residuals.iter().map(|&r| scale.colour(r)).collect(),
            values: Values::Heights(residuals),
            label,
            title: &title,
            width,
            lines: Vec::new(),
        };
        let histogram = histogram(judged(), scale, width, &scan.pass);
        let _ = write!(
            figures,
            "<figure>{}{histogram}<figcaption>{}</figcaption></figure>",
            image.to_svg(),
            escape(&format!("measured − {label}"))
        );
        table.rows.push(row(label, judged(), scale.band));
    }
    let heading = format!("{}, {} pass", scan.pass, role(scan.role));
    format!(
        "<section class=\"scan\"><h4>{}</h4>\n<div class=\"pair\">{figures}</div>\n{}</section>\n",
        escape(&heading),
        table.to_html()
    )
}

/// Returns the residual maps with their names: base model, and with effect if there is one.
fn residual_maps(maps: &HeightMaps) -> impl Iterator<Item = (&'static str, &Vec<f64>)> {
    let after = maps.with_effect.as_ref().map(|map| ("with effect", map));
    [("base model", &maps.base)].into_iter().chain(after)
}

fn row(label: &str, residuals: impl Iterator<Item = f64> + Clone, band: f64) -> Vec<Cell> {
    let all = residuals.clone().count();
    let Some(found) = Statistics::new(residuals, band) else {
        return vec![Cell::text(label), Cell::text("nothing was measured here")];
    };
    let height = |value: f64| fixed_cell(Some(value), 1e-6, 2);
    let missing = (all - found.count) as f64 / all as f64;
    vec![
        Cell::text(label),
        share_cell(Some(found.within)),
        height(found.mean),
        height(found.deviation),
        height(found.rms),
        height(found.quantiles[0]),
        height(found.quantiles[1]),
        Cell::number(found.count.to_string(), found.count as f64),
        share_cell(Some(missing)),
    ]
}

/// Draws the colour bar with the histogram of the residuals as an SVG element.
fn histogram(residuals: impl Iterator<Item = f64>, scale: &ColourScale, width: f64, pass: &str) -> String {
    let steps = scale.steps();
    let mut counts = vec![0usize; 2 * steps * BINS];
    for residual in residuals.filter(|r| r.is_finite()) {
        counts[((scale.place(residual) + steps as f64) * BINS as f64) as usize] += 1;
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let total = counts.iter().sum::<usize>().max(1) as f64;
    let bin = (width - LEFT - RIGHT) / counts.len() as f64;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width} {}\" style=\"width:{width}px\" role=\"img\" font-family=\"system-ui, sans-serif\" \
         font-size=\"11\"><title>Colour scale with the histogram of {}</title>",
        HISTOGRAM + BAR + BELOW,
        escape(pass)
    );
    for (k, &count) in counts.iter().enumerate() {
        let (x, height) = (LEFT + bin * k as f64, (HISTOGRAM - 4.0) * count as f64 / most);
        let share = short(100.0 * count as f64 / total);
        let _ = write!(
            svg,
            r##"<rect x="{x:.2}" y="{:.1}" width="{:.2}" height="{height:.1}" fill="#5b6577"><title>{share} % of the pixels</title></rect>"##,
            HISTOGRAM - height,
            bin - 0.6
        );
    }
    draw_bar(&mut svg, scale, bin * BINS as f64);
    svg + "</svg>"
}

fn draw_bar(svg: &mut String, scale: &ColourScale, step: f64) {
    let steps = scale.steps();
    for k in 0..2 * steps {
        let below = k < steps;
        let colour = css(scale.step_colour(if below { steps - 1 - k } else { k - steps }, below));
        let x = LEFT + step * k as f64;
        let _ = write!(svg, r#"<rect x="{x:.2}" y="{HISTOGRAM}" width="{step:.2}" height="{BAR}" fill="{colour}"/>"#);
    }
    let middle = LEFT + step * steps as f64;
    let _ = write!(
        svg,
        r##"<rect x="{LEFT}" y="{HISTOGRAM}" width="{:.2}" height="{BAR}" fill="none" stroke="#8a93a3"/>"##,
        step * 2.0 * steps as f64
    );
    let y = HISTOGRAM + BAR + 13.0;
    let _ = write!(svg, r#"<text x="{middle:.1}" y="{y}" text-anchor="middle">0</text>"#);
    for (k, bound) in scale.bounds.iter().enumerate().skip(1) {
        for side in [-1.0, 1.0] {
            let x = middle + side * step * (k + 1) as f64;
            let label = short(side * (bound * 1e7).round() * 0.1);
            let _ = write!(svg, r#"<text x="{x:.1}" y="{y}" text-anchor="middle">{label}</text>"#);
        }
    }
    let band = 2.0 * step;
    let _ = write!(
        svg,
        r##"<path d="M{:.1} {y2}v4H{:.1}v-4" fill="none" stroke="#1c2330"/><text x="{middle:.1}" y="{y3}" text-anchor="middle" dy="0">band [µm]</text>"##,
        middle - band,
        middle + band,
        y2 = y + 3.0,
        y3 = y + 17.0
    );
}
