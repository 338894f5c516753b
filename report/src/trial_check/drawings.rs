//! Drawings of a checked trial: maps with paths, a section with the tool, and the logs.

use std::ops::Range;

use glam::{DVec2, DVec3};
use image::Rgb;
use robot::Tool;
use sdf_bake::HeightMap;
use trials::measure::{CLEARANCE, DegreesOfFreedom, register, untouched_in_passes};
use trials::trial::{ExposureMask, HeldTool, ToolPath, ToolPose, Trial};

use super::TrialCheck;
use crate::map_image::{Line, MapImage, Values};
use crate::study::colour_scale::{ColourScale, MISSING};
use crate::{Chart, Page, Series, Stroke, WIDE};

/// Width of a map [px].
const MAP: f64 = 900.0;
/// Colours of the path with the tool pressed, and without.
const PRESSED: &str = "#d6006c";
const IN_AIR: &str = "#f0a000";
/// Strokes of a section's lines.
const BEFORE: Stroke = Stroke { colour: "#1c2330", dashed: false };
const AFTER: Stroke = Stroke { colour: "#0072b2", dashed: false };
const TOOL: Stroke = Stroke { colour: "#d55e00", dashed: true };
/// Number of points across the outline of a tool.
const OUTLINE: usize = 120;
/// Height of the tool's sides in the drawing [m].
const OUTLINE_HEIGHT: f64 = 3e-3;

/// Appends the scan before the first pass, and the removal of each pass, under the paths.
pub(super) fn add_maps(page: &mut Page, check: &TrialCheck) {
    let trial = check.trial;
    page.paragraph(
        "The path of each log lies over the scans: magenta while the force says that the tool pressed, yellow \
         otherwise. What was removed must lie under the magenta line.",
    );
    let before = &trial.scans.before;
    page.drawing(&heights(before, lines(trial, 0..trial.passes.len())), "Heights before the first pass.");
    let (mut earlier, mut since) = (before, 0);
    for (k, pass) in trial.passes.iter().enumerate().filter(|(_, pass)| !pass.scan.is_missing()) {
        if let Some(mask) = pass.scan.mask() {
            page.drawing(&exposed(mask), &format!("Exposed after pass {}: orange.", k + 1));
        }
        let Some(after) = pass.scan.heights() else { continue };
        let worked = since..k + 1;
        let left = change(trial, worked.clone(), earlier, after);
        let scale = ColourScale::new(check.noise.floor.sigma, left.iter().copied());
        let passes = if since < k { format!("Passes {} to {}", since + 1, k + 1) } else { format!("Pass {}", k + 1) };
        let title = format!("{passes}: height after minus height before, by place");
        let image = MapImage {
            pixels: after.pixels,
            colours: left.iter().map(|&change| scale.colour(change)).collect(),
            values: Values::Heights(&left),
            label: "change",
            title: &title,
            width: MAP,
            lines: lines(trial, worked),
        };
        page.drawing(
            &image.to_svg(),
            &format!("{passes}: blue was removed, orange rose; pale within {:.1} µm.", scale.band * 1e6),
        );
        (earlier, since) = (after, k + 1);
    }
}

/// Returns the height after some passes minus the height before them [m], registered on the untouched surface.
fn change(trial: &Trial, passes: Range<usize>, before: &HeightMap, after: &HeightMap) -> Vec<f64> {
    let free = untouched_in_passes(before, &trial.passes[passes], &trial.tool, CLEARANCE);
    let registration = register(after, before, DegreesOfFreedom::All, |at| free[at])
        .or_else(|_| register(after, before, DegreesOfFreedom::Plane, |_| true))
        .unwrap_or_default();
    registration.left(after, before)
}

fn path_of(trial: &Trial, pass: usize) -> ToolPath {
    ToolPath::of(&trial.passes[pass].log, &trial.tool, trial.passes[pass].force_setpoint)
}

/// Returns the paths of some passes; pressed parts are drawn over those in the air.
fn lines(trial: &Trial, passes: Range<usize>) -> Vec<Line> {
    let of = |pass: usize| {
        let path = path_of(trial, pass);
        let points = |kept: &dyn Fn(&ToolPose) -> bool| -> Vec<DVec2> {
            path.poses.iter().filter(|pose| kept(pose)).map(|pose| pose.centre.truncate()).collect()
        };
        let contact = path.contact;
        let pressed =
            |pose: &ToolPose| contact.is_some_and(|contact| (contact.start..=contact.end).contains(&pose.time));
        [Line { points: points(&|_| true), colour: IN_AIR }, Line { points: points(&pressed), colour: PRESSED }]
    };
    passes.flat_map(of).collect()
}

/// Draws a map of heights in shades of grey.
fn heights(map: &HeightMap, lines: Vec<Line>) -> String {
    let known = || map.heights.iter().copied().filter(|height| height.is_finite());
    let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)));
    let grey = |height: &f64| {
        let share = (height - low) / (high - low).max(f64::MIN_POSITIVE);
        let level = 60.0 + 180.0 * share;
        if height.is_finite() { Rgb([level as u8; 3]) } else { MISSING }
    };
    let image = MapImage {
        pixels: map.pixels,
        colours: map.heights.iter().map(grey).collect(),
        values: Values::Heights(&map.heights),
        label: "height",
        title: "height before the first pass, by place",
        width: MAP,
        lines,
    };
    image.to_svg()
}

/// Draws an exposure mask in three colours.
fn exposed(mask: &ExposureMask) -> String {
    const WORDS: [&str; 3] = ["coated", "exposed", "unknown"];
    let classes: Vec<usize> = mask.exposed.iter().map(|seen| seen.map_or(2, usize::from)).collect();
    let colours = [Rgb([0xf3, 0xf4, 0xf6]), Rgb([0xee, 0x8a, 0x2c]), MISSING];
    let image = MapImage {
        pixels: mask.pixels,
        colours: classes.iter().map(|&class| colours[class]).collect(),
        values: Values::Words(&WORDS, &classes),
        label: "exposed",
        title: "exposed substrate, by place",
        width: MAP,
        lines: Vec::new(),
    };
    image.to_svg()
}

/// Appends a section across the path in the middle of the contact, with the tool at its logged pose.
pub(super) fn add_section(page: &mut Page, trial: &Trial) {
    for k in 0..trial.passes.len() {
        let path = path_of(trial, k);
        let Some(contact) = path.contact else {
            page.paragraph(&format!("Pass {}: the force never says that the tool pressed.", k + 1));
            continue;
        };
        let pose = path.at(0.5 * (contact.start + contact.end));
        let along = trial.passes[k].direction.truncate().normalize_or(DVec2::X);
        let across = along.perp();
        let series = section(trial, k, (&pose, across));
        let chart = Chart {
            title: "section across the path",
            x_label: "across the path [mm]",
            y_label: "height [mm]",
            series: &series,
            size: WIDE,
            from_zero: false,
            band: None,
        };
        let place = pose.centre * 1e3;
        page.drawing(
            &chart.to_svg(),
            &format!(
                "Pass {}, in the middle of the contact at x {:.1} mm, y {:.1} mm: the tool must lie on the surface that it left, a \
                 pad as deep in it as its foam gives.",
                k + 1,
                place.x,
                place.y
            ),
        );
    }
}

fn section(trial: &Trial, pass: usize, (pose, across): (&ToolPose, DVec2)) -> Vec<Series> {
    let before = &trial.scans.before;
    let reach = 1.2 * trial.tool.half_width().max(5.0 * before.pixels.pitch);
    let steps = (2.0 * reach / before.pixels.pitch).ceil() as usize;
    let line = |map: &HeightMap| {
        let at = |k: usize| {
            let way = -reach + 2.0 * reach * k as f64 / steps as f64;
            let nearest = map.pixels.nearest(pose.centre.truncate() + across * way);
            (way * 1e3, nearest.map_or(f64::NAN, |at| map.heights[at] * 1e3))
        };
        (0..=steps).map(at).collect::<Vec<_>>()
    };
    let named = |name: &str, stroke, points| Series { stroke: Some(stroke), ..Series::new(name, points) };
    let mut series = vec![named("before the first pass", BEFORE, line(before))];
    let scan = &trial.passes[pass].scan;
    if let Some(after) = scan.heights().filter(|_| !scan.is_missing()) {
        series.push(named("after this pass", AFTER, line(after)));
    }
    series.push(named("tool by its log", TOOL, outline(&trial.tool, pose, across)));
    series
}

/// Returns the lower outline of the tool across the path [mm].
fn outline(tool: &HeldTool, pose: &ToolPose, across: DVec2) -> Vec<(f64, f64)> {
    let half = tool.half_width();
    let drop = tool.shape.drop();
    let side = DVec3::new(across.x, across.y, 0.0);
    // The face of a tilted tool rises to one side.
    let slope = match tool.shape {
        Tool::Wheel(_) => pose.axis.dot(DVec3::Z) / pose.axis.dot(side).abs().max(0.1) * pose.axis.dot(side).signum(),
        _ => -pose.approach.dot(side) / pose.approach.z.max(0.1),
    };
    let lowest = pose.centre.z - drop * pose.approach.z;
    let face = (0..=OUTLINE).map(|k| -half + 2.0 * half * k as f64 / OUTLINE as f64);
    let mut points: Vec<(f64, f64)> = face.map(|way| (way * 1e3, (lowest + slope * way) * 1e3)).collect();
    points.insert(0, (-half * 1e3, (lowest - slope * half + OUTLINE_HEIGHT) * 1e3));
    points.push((half * 1e3, (lowest + slope * half + OUTLINE_HEIGHT) * 1e3));
    points
}

/// Appends force and gap over time for each log.
pub(super) fn add_logs(page: &mut Page, trial: &Trial) {
    let passes: Vec<ToolPath> = (0..trial.passes.len()).map(|k| path_of(trial, k)).collect();
    let series = |value: &dyn Fn(&ToolPose) -> f64| -> Vec<Series> {
        let line = |(k, path): (usize, &ToolPath)| {
            let points = path.poses.iter().map(|pose| (pose.time, value(pose))).collect();
            Series::new(format!("pass {}", k + 1), points)
        };
        passes.iter().enumerate().map(line).collect()
    };
    let before = &trial.scans.before;
    let gap = |pose: &ToolPose| {
        let lowest = pose.centre - pose.approach * trial.tool.shape.drop();
        before.pixels.nearest(lowest.truncate()).map_or(f64::NAN, |at| (lowest.z - before.heights[at]) * 1e3)
    };
    for (label, caption, series, from_zero) in [
        ("force [N]", "Force by the log; the setpoint is in the table above.", series(&|pose| pose.force), true),
        ("height [mm]", "Lowest point of the tool above the scan before, by log and scan.", series(&gap), false),
    ] {
        let chart = Chart {
            title: caption,
            x_label: "time [s]",
            y_label: label,
            series: &series,
            size: WIDE,
            from_zero,
            band: None,
        };
        page.drawing(&chart.to_svg(), caption);
    }
}
