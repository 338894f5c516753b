//! Numbers of the welds on the page: what was reached, what was chosen for the part, how far each dial goes.

use serde_json::{Value, json};
use weldgen::dials::{Dial, Unit};
use weldgen::{Difficulty, Weld, WeldRequest};

use super::easel::Easel;
use super::flags::{Flags, dials};

impl Easel<'_> {
    /// Places the welds of some flags, and returns their figures, or the reason why there is none.
    pub(crate) fn figures(&mut self, flags: &Flags) -> Value {
        let (request, _) = self.request(flags);
        let (mesh, notes) = (&self.part.mesh, self.part.notes.clone());
        let extent = mesh.bounds().map_or(glam::DVec3::ZERO, |(low, high)| high - low);
        let (diagonal, triangles) = (mesh.diagonal(), mesh.triangles.len());
        let placed = self.placed(flags);
        let welds = placed.as_deref().unwrap_or_default();
        json!({
            "sizeMm": (1e3 * extent).to_array(),
            "triangles": triangles,
            "notes": notes,
            "welds": welds.iter().map(of_weld).collect::<Vec<_>>(),
            "difficulty": welds.iter().map(difficulty).max().map(Difficulty::name),
            "warnings": welds.iter().flat_map(Weld::warnings).collect::<Vec<_>>(),
            "reasons": welds.first().map(|weld| &weld.reasons),
            "failure": placed.as_ref().err(),
            "dials": ranges(&request, diagonal),
        })
    }
}

fn of_weld(weld: &Weld) -> Value {
    json!({
        "lengthMm": 1e3 * weld.curve.length(),
        "widthMm": 1e3 * weld.profile.width,
        "heightMm": 1e3 * weld.profile.height,
        "curvatureRms": weld.curvature_rms,
        "curvatureMax": sharpest(weld),
        "exposure": weld.min_exposure,
        "access": weld.mean_access,
        "joint": weld.joint,
        "volumeMm3": 1e9 * weld.bead_volume,
        "defects": weld.defects.len(),
    })
}

/// Greatest geodesic curvature [1/m].
fn sharpest(weld: &Weld) -> f64 {
    weld.curve.points.iter().map(|point| point.geodesic_curvature.abs()).fold(0.0, f64::max)
}

fn difficulty(weld: &Weld) -> Difficulty {
    Difficulty::measured(weld.min_exposure, sharpest(weld) * weld.profile.width)
}

/// Range of each dial's slider on this part, and the value that is chosen where the user sets none, in the units of the
/// flags.
fn ranges(request: &WeldRequest, diagonal: f64) -> Value {
    let of = |dial: &Dial| {
        let [least, most] = slider(dial, request, diagonal);
        let unit = if dial.unit == Unit::Length { 1e3 } else { 1.0 };
        let chosen = chosen(dial, request).map(|range| range.map(|value| unit * value));
        (dial.key.to_owned(), json!({ "least": unit * least, "most": unit * most, "chosen": chosen }))
    };
    dials().map(|row| of(row.dial)).collect::<serde_json::Map<String, Value>>().into()
}

/// Ends of a slider [SI]: the range of the dial, or sizes that a part of this diagonal [m] may have.
fn slider(dial: &Dial, request: &WeldRequest, diagonal: f64) -> [f64; 2] {
    match dial.key {
        "length-mm" | "correlation-mm" | "exposure-reach-mm" => [0.02 * diagonal, diagonal],
        "curvature-per-m" => [0.0, 16.0 / diagonal],
        "curvature-max-per-m" => [0.0, 48.0 / diagonal],
        "width-mm" => [0.01 * diagonal, 0.15 * diagonal],
        "height-mm" => [0.002 * diagonal, 0.08 * diagonal],
        "access-radius-mm" | "access-width-mm" => [1e-3, 0.15],
        _ if dial.unit == Unit::Length => [0.25 * request.width, 10.0 * request.width],
        _ => dial.range,
    }
}

/// Value of a request for a dial of the curve or the bead [SI].
fn chosen(dial: &Dial, request: &WeldRequest) -> Option<[f64; 2]> {
    match dial.key {
        "length-mm" => Some(request.length),
        "curvature-per-m" => Some(request.curvature_rms),
        "curvature-max-per-m" => Some([request.curvature_max; 2]),
        "exposure" => Some(request.exposure),
        "exposure-reach-mm" => Some([request.exposure_reach; 2]),
        "width-mm" => Some([request.width; 2]),
        "height-mm" => Some([request.height; 2]),
        "access-radius-mm" => Some([request.tool.radius; 2]),
        "access-width-mm" => Some([request.tool.width; 2]),
        "min-access" => Some([request.min_access; 2]),
        // Form and imperfections are not there unless they are asked for.
        _ if dial.unit != Unit::Length && dial.accepts(0.0) => Some([0.0; 2]),
        _ => None,
    }
}
