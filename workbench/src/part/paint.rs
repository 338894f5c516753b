//! A drawing coloured by a map: the shading is kept, the colour comes from the value at the position.

use glam::{DVec2, Vec3};
use render::{BASE_STEEL, Frame, Picture, VisibleObject, colour_map, from_srgb8, to_srgb8};
use report::study::ColourScale;
use serde_json::{Value, json};

use crate::bench::{Residuals, ScanMap};

/// Range of the brightness of a drawn surface relative to plain steel; within it, colours match the legend.
const LIGHT: [f32; 2] = [0.35, 1.25];
/// Colours of positions without a value, and of sanded positions: exposed in both, measured only, simulated only,
/// neither.
const MISSING: [u8; 3] = [0xa9, 0xad, 0xb3];
const BOTH: [u8; 3] = [0x8f, 0xa8, 0xbd];
const MEASURED: [u8; 3] = [0xee, 0x8a, 0x2c];
const SIMULATED: [u8; 3] = [0x4c, 0x94, 0xcb];
const NEITHER: [u8; 3] = [0xee, 0xee, 0xea];

/// Colours the visible part of a frame; `colour` maps a pixel's index to its colour.
pub(super) fn painted(frame: &Frame, colour: impl Fn(usize) -> [u8; 3]) -> Picture {
    let mut picture = frame.to_srgb8();
    let steel = luminance(BASE_STEEL.diffuse);
    for at in (0..frame.seen.len()).filter(|&at| frame.seen[at] == VisibleObject::Part) {
        let light = (luminance(frame.colour[at]) / steel).clamp(LIGHT[0], LIGHT[1]);
        let lit = from_srgb8(colour(at)) * light;
        picture.rgb[3 * at..3 * at + 3].copy_from_slice(&to_srgb8(lit.min(Vec3::ONE)));
    }
    picture
}

fn luminance(colour: Vec3) -> f32 {
    colour.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Returns the map's colour at each pixel of a frame.
pub(super) fn of_map<'a>(map: &'a ScanMap, frame: &'a Frame) -> impl Fn(usize) -> [u8; 3] + 'a {
    move |at| {
        let place = frame.position[at].as_dvec3().truncate();
        match &map.residuals {
            Residuals::Heights { scale, .. } => scale.colour(map.left_at(place).unwrap_or(f64::NAN)).0,
            Residuals::Exposure { measured, simulated } => {
                map.pixels.nearest(place).map_or(MISSING, |pixel| match (measured[pixel], simulated[pixel]) {
                    (None, _) => MISSING,
                    (Some(true), true) => BOTH,
                    (Some(true), false) => MEASURED,
                    (Some(false), true) => SIMULATED,
                    (Some(false), false) => NEITHER,
                })
            }
        }
    }
}

/// Returns the dose's colour at each pixel of a frame.
pub(super) fn of_dose(frame: &Frame) -> impl Fn(usize) -> [u8; 3] + '_ {
    |at| to_srgb8(colour_map(frame.dose[at].clamp(0.0, 1.0)))
}

/// Builds the legend of a map: steps with their colours, in micrometres or noise floors.
pub(super) fn legend_of(map: &ScanMap, in_floors: bool) -> Value {
    let key = |colour: [u8; 3], words: &str| json!({ "colour": css(colour), "words": words });
    match &map.residuals {
        Residuals::Heights { scale, floor, .. } if in_floors => steps(scale, *floor, "noise floors", "in noise floors"),
        Residuals::Heights { scale, .. } => steps(scale, 1e-6, "µm", "positive is material left over"),
        Residuals::Exposure { .. } => json!({ "title": "substrate", "keys": [
            key(BOTH, "measured and simulated"), key(MEASURED, "measured only"), key(SIMULATED, "simulated only"),
            key(NEITHER, "coating"), key(MISSING, "missing"),
        ] }),
    }
}

fn steps(scale: &ColourScale, unit: f64, name: &str, words: &str) -> Value {
    let steps = scale.steps() as i64;
    let colour = |k: i64| css(scale.step_colour(k.unsigned_abs() as usize - 1, k < 0).0);
    let colours: Vec<String> = (-steps..=steps).filter(|k| *k != 0).map(colour).collect();
    let bounds: Vec<f64> = scale.bounds.iter().map(|bound| bound / unit).collect();
    json!({ "title": format!("measured \u{2212} simulated; {words}"), "unit": name, "colours": colours, "bounds": bounds })
}

/// Builds the legend of the colour map from zero to a value.
pub(super) fn legend_to(title: &str, most: f64, unit: &str) -> Value {
    let colours: Vec<String> = (0..=8).map(|k| css(to_srgb8(colour_map(k as f32 / 8.0)))).collect();
    json!({ "title": title, "unit": unit, "ramp": colours, "most": most })
}

fn css([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Returns the position of a pixel in the plane of the scan [m].
pub(super) fn place(frame: &Frame, at: usize) -> DVec2 {
    frame.position[at].as_dvec3().truncate()
}
