//! A study on one picture: the hidden effects, the misfit of the base model, the suspects, the added effects, the fall
//! of the error, and the content of the seal.

use std::fmt::Write;

use super::colour_scale::{ColourScale, css};
use super::number::percent;
use super::waterfall;
use crate::escape;
use lab::EffectSummary;
use study::StudyReport;
use study::{HeightMaps, Maps, ScanComparison};
use trials::trial::Role;

const WIDTH: f64 = 1000.0;
const MARGIN: f64 = 20.0;
/// Width of one of three columns, and the gap between two [px].
const COLUMN: f64 = 306.0;
const GAP: f64 = 21.0;
const INK: &str = "#1c2330";
const PALE: &str = "#4b5566";
/// Space for the head of the picture, and for a panel's number and title [px].
const HEAD: f64 = 34.0;
const TITLE: f64 = 30.0;
/// Space below the maps for their words and the scale [px].
const BELOW: f64 = 64.0;
/// Height of a map and of the panels of the last row [px].
const MAP: f64 = 130.0;
const LAST_ROW: f64 = 220.0;
/// Greatest number of suspects named.
const SUSPECTS: usize = 4;

/// Sealed answer of a virtual experiment, and the result of the study.
pub struct Sealed {
    /// SHA-256 of the answer, published before the study.
    pub sha256: String,
    /// Hidden effects with their parameters, one a line; empty if none were hidden.
    pub hidden: Vec<String>,
    /// Conclusions of the study, one a line.
    pub found: Vec<String>,
    /// True if the study was right.
    pub is_right: bool,
}

/// Returns the picture as an SVG document. Panels without data stay empty.
pub fn story(report: &StudyReport, sealed: &Sealed) -> String {
    let (falls, falls_height) = waterfall::drawing(&report.waterfall);
    let wide = 2.0 * COLUMN + GAP;
    let scale = wide / waterfall::WIDTH;
    let last = (scale * falls_height).max(LAST_ROW - TITLE) + TITLE;
    let top = HEAD + TITLE + MAP + BELOW;
    let height = top + last + MARGIN;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height:.0}\" width=\"{WIDTH}\" height=\"{height:.0}\" \
         font-family=\"system-ui, sans-serif\" font-size=\"13\" fill=\"{INK}\">\n<title>{}</title>\n\
         <rect width=\"{WIDTH}\" height=\"{height:.0}\" fill=\"#fff\"/>\n",
        escape(&report.sentence)
    );
    let seal: String = sealed.sha256.chars().take(16).collect();
    let first = report.sentence.split_inclusive(". ").next().unwrap_or_default().trim_end();
    text(&mut svg, (MARGIN, 24.0), (16.0, INK), &format!("{}: {first}", report.compared.campaign));
    let _ = writeln!(
        svg,
        "<text x=\"{}\" y=\"24\" font-size=\"11\" fill=\"{PALE}\" text-anchor=\"end\">sealed before anyone looked: {seal}…</text>",
        WIDTH - MARGIN
    );
    add_maps(&mut svg, report);
    panel(&mut svg, (column(1), HEAD), "2", "The suspects");
    add_suspects(&mut svg, &report.suspects, (column(1), HEAD + TITLE + 8.0));
    panel(&mut svg, (MARGIN, top), "4", "How the error falls");
    let _ = writeln!(svg, "<g transform=\"translate({MARGIN} {:.1}) scale({scale:.4})\">{falls}</g>", top + TITLE);
    panel(&mut svg, (column(2), top), "5", "The seal is opened");
    add_seal(&mut svg, sealed, (column(2), top + TITLE + 14.0));
    svg + "</svg>\n"
}

/// Returns the left edge of column `k` of three [px].
fn column(k: usize) -> f64 {
    MARGIN + k as f64 * (COLUMN + GAP)
}

fn text(svg: &mut String, (x, y): (f64, f64), (size, colour): (f64, &str), words: &str) {
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" fill=\"{colour}\">{}</text>",
        escape(words)
    );
}

/// Draws number and title of a panel.
fn panel(svg: &mut String, (x, y): (f64, f64), number: &str, title: &str) {
    let (middle, line) = (x + 10.0, y + 22.0);
    let _ = writeln!(svg, "<circle cx=\"{middle}\" cy=\"{:.1}\" r=\"10\" fill=\"#1f5f99\"/>", y + 17.0);
    let _ = writeln!(
        svg,
        "<text x=\"{middle}\" y=\"{line:.1}\" fill=\"#fff\" font-weight=\"700\" text-anchor=\"middle\">{number}</text>\
         <text x=\"{:.1}\" y=\"{line:.1}\" font-size=\"14\" font-weight=\"700\">{}</text>",
        x + 28.0,
        escape(title)
    );
}

/// Finds the scan with the largest error of the base model, held-out scans first; returns it with its maps.
fn worst(report: &StudyReport) -> Option<(&ScanComparison, &HeightMaps)> {
    let heights = report.scans.iter().filter_map(|scan| match &scan.maps {
        Maps::Heights(maps) => Some((scan, maps)),
        Maps::Exposure(_) => None,
    });
    let key = |(scan, maps): &(&ScanComparison, &HeightMaps)| (scan.role == Role::Evaluation, rms(maps, &maps.base));
    heights.max_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal))
}

/// Returns the root mean square over the judged pixels [m].
fn rms(maps: &HeightMaps, residuals: &[f64]) -> f64 {
    let judged = residuals.iter().zip(&maps.judged).filter(|(residual, judged)| **judged && residual.is_finite());
    let (sum, count) = judged.fold((0.0, 0.0), |(sum, count), (residual, _)| (sum + residual * residual, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

fn add_maps(svg: &mut String, report: &StudyReport) {
    panel(svg, (column(0), HEAD), "1", "Where the model fails");
    panel(svg, (column(2), HEAD), "3", "With what was found");
    let top = HEAD + TITLE + 8.0;
    let Some((scan, maps)) = worst(report) else { return };
    let mut below = top;
    let all = maps.base.iter().chain(maps.with_effect.iter().flatten()).copied();
    let scale = ColourScale::new(maps.noise_floor, all);
    for (k, residuals) in [Some(&maps.base), maps.with_effect.as_ref()].into_iter().enumerate() {
        let place = (column(2 * k), top);
        let Some(residuals) = residuals else {
            text(svg, (place.0, place.1 + 20.0), (13.0, PALE), "nothing was found to add");
            continue;
        };
        let bottom = draw_map(svg, (maps, residuals), &scale, place);
        let role = if scan.role == Role::Evaluation { "held out, " } else { "" };
        let words = format!("{}: {role}{:.1} µm rms", scan.pass, 1e6 * rms(maps, residuals));
        text(svg, (place.0, bottom + 18.0), (12.0, INK), &words);
        below = below.max(bottom + 18.0);
    }
    legend(svg, &scale, (column(0), below + 14.0));
}

/// Draws a map as runs of one colour; returns its lower end [px].
fn draw_map(
    svg: &mut String,
    (maps, residuals): (&HeightMaps, &[f64]),
    scale: &ColourScale,
    (x, y): (f64, f64),
) -> f64 {
    let (nx, ny) = (maps.pixels.nx, maps.pixels.ny);
    let pixel = (COLUMN / nx as f64).min(MAP / ny as f64);
    let _ = write!(svg, "<g transform=\"translate({x:.1} {y:.1}) scale({pixel:.4})\" shape-rendering=\"crispEdges\">");
    for (row, line) in residuals.chunks(nx).rev().enumerate() {
        let colours: Vec<String> = line.iter().map(|residual| css(scale.colour(*residual))).collect();
        let mut start = 0;
        for run in colours.chunk_by(|a, b| a == b) {
            let _ = write!(svg, "<path fill=\"{}\" d=\"M{start} {row}h{}v1h-{}z\"/>", run[0], run.len(), run.len());
            start += run.len();
        }
    }
    svg.push_str("</g>\n");
    y + pixel * ny as f64
}

/// Draws the steps of the scale, from the lowest to the highest.
fn legend(svg: &mut String, scale: &ColourScale, (x, y): (f64, f64)) {
    let steps = scale.bounds.len() as i64;
    let wide = 13.0;
    for (k, step) in (-steps..=steps).enumerate() {
        let size = step.unsigned_abs() as usize;
        let colour = css(scale.step_colour(size, step < 0));
        let _ = write!(
            svg,
            "<rect x=\"{:.1}\" y=\"{y:.1}\" width=\"{wide}\" height=\"9\" fill=\"{colour}\"/>",
            x + wide * k as f64
        );
    }
    let most = scale.bounds.last().map_or(0.0, |bound| bound * 1e6);
    let words = format!("±{most:.0} µm; pale: within {:.0} µm", scale.band * 1e6);
    text(svg, (x + wide * (2 * steps + 2) as f64, y + 9.0), (11.0, PALE), &words);
    text(svg, (x, y + 24.0), (11.0, PALE), "measured − simulated: orange was left over, blue was taken off too much");
}

fn add_suspects(svg: &mut String, suspects: &[EffectSummary], (x, y): (f64, f64)) {
    if suspects.is_empty() {
        return text(svg, (x, y + 20.0), (13.0, PALE), "no effect is significant");
    }
    for (k, suspect) in suspects.iter().take(SUSPECTS).enumerate() {
        let top = y + 40.0 * k as f64;
        let probability = if suspect.probability.is_finite() { suspect.probability } else { 0.0 };
        text(svg, (x, top + 12.0), (13.0, INK), &suspect.name);
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"9\" fill=\"#dfe5ee\"/><rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"9\" fill=\"#0b6b58\"/>",
            top + 18.0,
            COLUMN - 60.0,
            top + 18.0,
            (COLUMN - 60.0) * probability
        );
        text(svg, (x + COLUMN - 52.0, top + 27.0), (12.0, INK), &percent(probability));
    }
}

fn add_seal(svg: &mut String, sealed: &Sealed, (x, y): (f64, f64)) {
    let (word, colour) = if sealed.is_right { ("right", "#0b6b58") } else { ("wrong", "#8a2a2a") };
    let mut line = y;
    for (title, lines) in [("hidden", &sealed.hidden), ("found", &sealed.found)] {
        text(svg, (x, line), (12.0, PALE), title);
        for words in lines {
            line += 20.0;
            text(svg, (x, line), (13.0, INK), words);
        }
        line += 30.0;
    }
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"20\" font-weight=\"700\" fill=\"{colour}\">{word}</text>",
        line + 6.0
    );
}
