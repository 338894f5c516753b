//! Error after each step, from the raw difference to the noise floor: bars and table.

use std::fmt::Write;

use super::number::{cell, percent, share_cell, significant};
use super::words::list;
use crate::{Cell, Page, Table, escape};
use study::{Waterfall, WaterfallStep};

/// Width of the picture [px].
pub(super) const WIDTH: f64 = 900.0;
const LEFT: f64 = 190.0;
const RIGHT: f64 = 110.0;
const TOP: f64 = 30.0;
/// Height of a step, and of each of its two bars [px].
const STEP: f64 = 40.0;
const BAR: f64 = 13.0;
/// Greatest ratio of the longest bar to the second longest; a longer bar is cut, so that the last steps stay readable.
const MOST_RATIO: f64 = 1.15;
const CALIBRATION: &str = "#1f5f99";
const EVALUATION: &str = "#e08a2e";

/// Name of the removed volume whose errors the page states.
pub(super) const VOLUME: &str = "the volume that each pass removed, with scans aligned on the untouched surface,";

/// Appends the waterfall.
pub(super) fn add(page: &mut Page, waterfall: &Waterfall) {
    page.part("waterfall", "How the error falls");
    if waterfall.steps.is_empty() {
        return page.paragraph("No step of the model was computed.");
    }
    page.drawing(&picture(waterfall), &caption(waterfall));
    page.block(&table(waterfall).without_empty_columns().to_html());
    page.block(&list(&waterfall.notes));
    if let Some(volumes) = volumes(waterfall) {
        page.block(&volumes.to_html());
    }
}

fn caption(waterfall: &Waterfall) -> String {
    let cut = if longest(waterfall).1 { " A bar with a gap is cut; its number is the true one." } else { "" };
    format!(
        "What is left between measurement and simulation ({}), step by step; the dashed lines are the noise floors of the passes of \
         their colour.{cut}",
        waterfall.misfit.name
    )
}

/// Returns the value at the end of the axis [SI]; the second value is true if a bar is longer.
fn longest(waterfall: &Waterfall) -> (f64, bool) {
    let of = |step: &WaterfallStep| step.calibration.unwrap_or(0.0).max(step.evaluation.unwrap_or(0.0));
    let mut lengths: Vec<f64> = waterfall.steps.iter().map(of).collect();
    lengths.sort_by(|a, b| b.total_cmp(a));
    let second = lengths.get(1).copied().unwrap_or(lengths[0]);
    let end = if second > 0.0 { lengths[0].min(MOST_RATIO * second) } else { lengths[0] };
    (if end > 0.0 { end } else { waterfall.misfit.unit.si_per_unit }, lengths[0] > end)
}

fn picture(waterfall: &Waterfall) -> String {
    let (bars, height) = drawing(waterfall);
    format!(
        "<svg viewBox=\"0 0 {WIDTH} {height}\" style=\"width:{WIDTH}px\" role=\"img\" font-family=\"system-ui, sans-serif\" \
         font-size=\"13\"><title>Error after each step, in calibration and evaluation passes</title>{bars}</svg>"
    )
}

/// Draws the bars as SVG elements, [`WIDTH`] wide; returns them with their height [px].
pub(super) fn drawing(waterfall: &Waterfall) -> (String, f64) {
    let (end, _) = longest(waterfall);
    let height = TOP + STEP * waterfall.steps.len() as f64 + 8.0;
    let mut svg = String::new();
    for (k, (colour, name)) in
        [(CALIBRATION, "calibration passes"), (EVALUATION, "evaluation passes")].iter().enumerate()
    {
        let x = LEFT + 170.0 * k as f64;
        let _ = write!(svg, r#"<rect x="{x}" y="6" width="22" height="11" fill="{colour}"/>"#);
        let _ = write!(svg, r#"<text x="{}" y="16">{name}</text>"#, x + 28.0);
    }
    for (k, step) in waterfall.steps.iter().enumerate() {
        let top = TOP + STEP * k as f64 + 4.0;
        let _ = write!(
            svg,
            r#"<text x="{}" y="{}" text-anchor="end">{}</text>"#,
            LEFT - 10.0,
            top + BAR + 4.0,
            escape(&step.name)
        );
        for (row, (value, colour)) in
            [(step.calibration, CALIBRATION), (step.evaluation, EVALUATION)].iter().enumerate()
        {
            if let Some(value) = value {
                draw_bar(&mut svg, waterfall, (*value, end), top + (BAR + 2.0) * row as f64, colour);
            }
        }
    }
    draw_floor(&mut svg, waterfall, end, height);
    (svg, height)
}

fn draw_bar(svg: &mut String, waterfall: &Waterfall, (value, end): (f64, f64), y: f64, colour: &str) {
    let unit = &waterfall.misfit.unit;
    let room = WIDTH - LEFT - RIGHT;
    let length = room * (value / end).min(1.0);
    let _ = write!(svg, r#"<rect x="{LEFT}" y="{y:.1}" width="{length:.1}" height="{BAR}" fill="{colour}"/>"#);
    if value > end * (1.0 + 1e-9) {
        let x = LEFT + 0.9 * room;
        let _ = write!(svg, r##"<path d="M{x} {:.1}l6 -17h7l-6 17z" fill="#fff"/>"##, y + BAR + 2.0);
    }
    let _ = write!(
        svg,
        r#"<text x="{:.1}" y="{:.1}" font-size="12">{} {}</text>"#,
        LEFT + length + 6.0,
        y + BAR - 2.0,
        significant(unit.of(value), 3),
        escape(&unit.unit)
    );
}

/// Draws a dashed line at the last step, the noise floor, for each kind of passes.
fn draw_floor(svg: &mut String, waterfall: &Waterfall, end: f64, height: f64) {
    let floor = waterfall.steps.last().filter(|_| waterfall.steps.len() > 1);
    let floors = floor
        .map_or([(None, CALIBRATION); 2], |floor| [(floor.calibration, CALIBRATION), (floor.evaluation, EVALUATION)]);
    for (floor, colour) in floors {
        let Some(floor) = floor else { continue };
        let x = LEFT + (WIDTH - LEFT - RIGHT) * (floor / end).min(1.0);
        let _ = write!(svg, r##"<path d="M{x:.1} {TOP}V{height}" stroke="{colour}" stroke-dasharray="4 3"/>"##);
    }
    let _ = write!(svg, r##"<path d="M{LEFT} {TOP}V{height}" stroke="#8a93a3"/>"##);
}

fn table(waterfall: &Waterfall) -> Table {
    let unit = &waterfall.misfit.unit;
    let mut headings =
        vec!["step".to_owned(), format!("calibration [{}]", unit.unit), format!("evaluation [{}]", unit.unit)];
    headings.push("still unexplained (calibration)".to_owned());
    let has = |of: fn(&WaterfallStep) -> Option<f64>| waterfall.steps.iter().any(|step| of(step).is_some());
    let (slopes, overlaps) = (has(|step| step.plateau_slope), has(|step| step.overlap));
    headings.extend(slopes.then(|| "plateau slope [mrad]".to_owned()));
    headings.extend(overlaps.then(|| "intersection over union".to_owned()));
    let row = |step: &WaterfallStep| {
        let misfit = |value| cell(value, unit.si_per_unit, 3);
        let mut row = vec![Cell::text(&step.name), misfit(step.calibration), misfit(step.evaluation)];
        row.push(share_cell(step.unexplained));
        row.extend(slopes.then(|| cell(step.plateau_slope, 1e-3, 3)));
        row.extend(overlaps.then(|| share_cell(step.overlap)));
        row
    };
    Table {
        caption: format!("What is left after each step: {}", waterfall.misfit.name),
        headings,
        rows: waterfall.steps.iter().map(row).collect(),
    }
}

/// Builds the table of each pass's volume error after each step; `None` if no step has one.
fn volumes(waterfall: &Waterfall) -> Option<Table> {
    let steps: Vec<&WaterfallStep> =
        waterfall.steps.iter().filter(|step| step.volume_errors.iter().any(Option::is_some)).collect();
    let mut headings = vec!["pass"];
    headings.extend(steps.iter().map(|step| step.name.as_str()));
    let mut table = Table::new(
        &format!(
            "Error of {VOLUME} after each step: (simulated − measured) / measured; ± is the standard uncertainty. \
         In \"raw\" the scan has the pose of its file"
        ),
        &headings,
    );
    for (k, pass) in waterfall.passes.iter().enumerate() {
        let errors = steps.iter().map(|step| volume_cell(step.volume_errors.get(k)));
        table.rows.push([Cell::text(pass)].into_iter().chain(errors).collect());
    }
    (!steps.is_empty() && !table.rows.is_empty()).then_some(table)
}

fn volume_cell(error: Option<&Option<(f64, f64)>>) -> Cell {
    match error {
        Some(Some((value, uncertainty))) => {
            let shown = format!("{} ± {}", percent(*value).trim_end_matches(" %"), percent(*uncertainty));
            Cell::number(shown, *value)
        }
        _ => Cell::absent(),
    }
}
