//! A drawing coloured by a map: the shading is kept, the colour comes from the value at the position.

use std::collections::BTreeMap;

use glam::{DVec2, Vec3};
use lab::TileGrid;
use render::{BASE_STEEL, Frame, Picture, VisibleObject, colour_map, from_srgb8, to_srgb8};
use report::study::ColourScale;
use serde_json::{Value, json};
use study::PassTiles;

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
pub(crate) fn painted(frame: &Frame, colour: impl Fn(usize) -> [u8; 3]) -> Picture {
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

/// A covariate of a pass, drawn tile by tile.
pub(super) struct Condition<'a> {
    tiles: &'a PassTiles,
    covariate: usize,
    /// Tile of each cell of the grid.
    of_cell: BTreeMap<usize, usize>,
    /// Least and greatest value [SI].
    range: [f64; 2],
}

impl<'a> Condition<'a> {
    /// Prepares a covariate of some tiles.
    pub(super) fn of(tiles: &'a PassTiles, covariate: usize) -> Self {
        let of_cell = tiles.cells.iter().enumerate().map(|(tile, cell)| (*cell, tile)).collect();
        let values = tiles.values[covariate].iter().copied();
        let range = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        Self { tiles, covariate, of_cell, range }
    }

    /// Value at a place in the plane of the scan [SI]; `None` where the pass did not work.
    fn at(&self, place: DVec2) -> Option<f64> {
        let TileGrid { pixels, side } = self.tiles.grid;
        let pixel = pixels.nearest(place)?;
        let (columns, column) = (self.tiles.grid.shape().0, pixel % pixels.nx / side);
        let cell = (column < columns).then_some(pixel / pixels.nx / side * columns + column)?;
        Some(self.tiles.values[self.covariate][*self.of_cell.get(&cell)?])
    }

    /// Colour at each pixel of a frame.
    pub(super) fn colours(&self, frame: &'a Frame) -> impl Fn(usize) -> [u8; 3] + '_ {
        let [least, most] = self.range;
        let share = move |value: f64| ((value - least) / (most - least).max(f64::MIN_POSITIVE)) as f32;
        move |at| self.at(place(frame, at)).map_or(MISSING, |value| to_srgb8(colour_map(share(value))))
    }

    /// Legend from the least to the greatest value.
    pub(super) fn legend(&self) -> Value {
        let (name, unit) = study::tile_covariate(self.covariate);
        let [least, most] = self.range.map(|value| unit.of(value));
        json!({ "least": least, "title": name, "unit": unit.unit, "ramp": ramp(), "most": most })
    }
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
    json!({ "least": 0.0, "title": title, "unit": unit, "ramp": ramp(), "most": most })
}

/// Colours of the colour map, in nine steps.
fn ramp() -> Vec<String> {
    (0..=8).map(|k| css(to_srgb8(colour_map(k as f32 / 8.0)))).collect()
}

fn css([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Returns the position of a pixel in the plane of the scan [m].
pub(super) fn place(frame: &Frame, at: usize) -> DVec2 {
    frame.position[at].as_dvec3().truncate()
}
