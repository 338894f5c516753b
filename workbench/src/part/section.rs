//! A section along a line over the scan: removed depth, measured and simulated, and the residual.

use glam::DVec2;
use report::{Chart, Series, Stroke, stacked};
use serde::Deserialize;
use serde_json::{Value, json};

use super::picture::{PictureData, PictureRequest};
use crate::bench::{Residuals, ScanMap, interpolated};
use crate::error::Refusal;

/// Greatest number of points of a section.
const MOST_POINTS: usize = 400;
/// Width and height of the section's two charts [px].
const SIZES: [(f64, f64); 2] = [(720.0, 230.0), (720.0, 180.0)];
const MEASURED: Stroke = Stroke { colour: "#1c2330", dashed: false };
const SIMULATED: Stroke = Stroke { colour: "#d55e00", dashed: true };
const LEFT: Stroke = Stroke { colour: "#0072b2", dashed: false };

/// Two places in the plane of the scan [mm]: the ends of a section, or opposite corners of a region.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(crate) struct Line {
    x0: f64,
    y0: f64,
    x1: f64,
    y1: f64,
}

/// Values along a section [µm] over the distance along the line [mm].
struct Along {
    measured: Vec<(f64, f64)>,
    simulated: Vec<(f64, f64)>,
    left: Vec<(f64, f64)>,
}

/// Draws the charts of a section as SVG, and returns its root mean square residual.
///
/// # Errors
/// If the line lies outside the scan, or there is no height scan.
pub(crate) fn section(looked: &PictureData, asked: &PictureRequest, line: &Line) -> Result<Value, Refusal> {
    let map =
        looked.map(asked).ok_or_else(|| Refusal::early("a section needs a pass, and a model that is simulated"))?;
    let Residuals::Heights { left, floor, .. } = &map.residuals else {
        return Err(Refusal::wrong("sanding leaves the surface as it was: there are no heights to cut"));
    };
    let along = along(looked, asked, (map, left), line)?;
    let known: Vec<f64> = along.left.iter().map(|point| point.1).filter(|left| left.is_finite()).collect();
    if known.len() < 2 {
        return Err(Refusal::wrong("the line lies beside the scan; one over it is accepted"));
    }
    let rms = (known.iter().map(|left| left * left).sum::<f64>() / known.len() as f64).sqrt();
    let stroked = |name: &str, points: &[(f64, f64)], stroke: Stroke| Series {
        stroke: Some(stroke),
        ..Series::new(name, points.to_vec())
    };
    let removed = [stroked("measured", &along.measured, MEASURED), stroked("simulated", &along.simulated, SIMULATED)];
    let rest = [stroked("measured \u{2212} simulated", &along.left, LEFT)];
    let chart = |series, y_label, size, band| Chart {
        title: "Section",
        x_label: "way along the section [mm]",
        y_label,
        series,
        size,
        from_zero: false,
        band,
    };
    let band = 3e6 * floor;
    let charts = [
        chart(&removed[..], "removed depth [µm]", SIZES[0], None),
        chart(&rest[..], "left [µm]", SIZES[1], Some((-band, band))),
    ];
    let words = format!("From ({:.2}, {:.2}) mm to ({:.2}, {:.2}) mm", line.x0, line.y0, line.x1, line.y1);
    let svg = stacked(&words, &charts);
    Ok(json!({ "svg": svg, "words": words, "rmsUm": rms, "floorUm": 1e6 * floor, "leftUm": along.left }))
}

impl Line {
    /// Both places [m].
    pub(super) fn ends(&self) -> [DVec2; 2] {
        [1e-3 * DVec2::new(self.x0, self.y0), 1e-3 * DVec2::new(self.x1, self.y1)]
    }
}

fn along(
    looked: &PictureData,
    asked: &PictureRequest,
    (map, left): (&ScanMap, &[f64]),
    line: &Line,
) -> Result<Along, Refusal> {
    let [from, to] = line.ends();
    let length = from.distance(to);
    if !(length.is_finite() && length > 0.0) {
        return Err(Refusal::wrong("a line between two places is expected"));
    }
    let trial = looked.trial(asked)?;
    let scan = trial.heights(asked.pass).ok_or_else(|| Refusal::missing("there is no such scan"))?;
    let count = ((length / map.pixels.pitch).ceil() as usize + 1).clamp(2, MOST_POINTS);
    let mut along = Along { measured: Vec::new(), simulated: Vec::new(), left: Vec::new() };
    for k in 0..count {
        let share = k as f64 / (count - 1) as f64;
        let here = from.lerp(to, share);
        let at = |pixels, values: &[f64]| 1e6 * interpolated(pixels, values, here);
        let depth = at(&trial.before.pixels, &trial.before.heights) - at(&scan.pixels, &scan.heights);
        let (way, rest) = (1e3 * share * length, at(&map.pixels, left));
        along.measured.push((way, depth));
        along.simulated.push((way, depth + rest));
        along.left.push((way, rest));
    }
    Ok(along)
}
