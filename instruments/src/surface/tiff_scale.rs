//! Scales stated in a TIFF image.
//!
//! A description contains pairs of a key and a value, as lines `key=value` (ImageJ) or as JSON (tifffile).

use std::io::{Read, Seek};

use files::input::quoted;
use glam::DVec2;
use tiff::decoder::Decoder;
use tiff::decoder::ifd::Value;
use tiff::tags::Tag;

use super::unit;

/// Keys of the unit of heights, of the size of a step in that unit, and of the height of step zero.
const UNIT: [&str; 6] = ["z_unit", "zunit", "height_unit", "value_unit", "value_units", "vunit"];
const STEP: [&str; 4] = ["z_scale", "zscale", "height_scale", "c1"];
const OFFSET: [&str; 4] = ["z_offset", "zoffset", "height_offset", "c0"];
/// Keys of the distance between pixels along both axes, along x and along y, and of its unit.
const PITCH: [&str; 2] = ["pitch", "pixel_size"];
const PITCH_X: [&str; 2] = ["pitch_x", "pixel_size_x"];
const PITCH_Y: [&str; 2] = ["pitch_y", "pixel_size_y"];
const LATERAL: [&str; 4] = ["xy_unit", "pitch_unit", "pixel_unit", "unit"];

/// Scales of an image.
pub(super) struct Statement {
    /// SI value of a step, and height of step zero [m].
    pub(super) step: f64,
    pub(super) offset: f64,
    /// Distance between pixels [m], if stated.
    pub(super) pitch: Option<DVec2>,
    unit: String,
}

impl Statement {
    /// Reads the scales in the tags of an image.
    ///
    /// # Errors
    /// A description of the fault: heights without a unit.
    pub(super) fn of<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, String> {
        let description = decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default();
        let pairs = pairs(&description);
        let text =
            |keys: &[&str]| pairs.iter().find(|pair| keys.contains(&pair.0.as_str())).map(|pair| pair.1.as_str());
        let number = |keys: &[&str]| -> Result<Option<f64>, String> {
            let Some(found) = text(keys) else { return Ok(None) };
            let number = found.parse::<f64>().ok().filter(|number| number.is_finite());
            number.map(Some).ok_or_else(|| format!("{} is {}", keys[0], quoted(found)))
        };
        let unit = text(&UNIT).ok_or("no unit of heights in the ImageDescription")?;
        let metres = unit::metres(unit).ok_or_else(|| format!("heights in {}", quoted(unit)))?;
        let step = number(&STEP)?.unwrap_or(1.0) * metres;
        let lateral = text(&LATERAL).and_then(unit::metres);
        let both = number(&PITCH)?;
        let sides = number(&PITCH_X)?.or(both).zip(number(&PITCH_Y)?.or(both));
        let pitch = match (sides, lateral) {
            (Some((x, y)), Some(unit)) => Some(DVec2::new(x, y) * unit),
            (Some(_), None) => return Err("a pitch without xy_unit".to_owned()),
            (None, lateral) => resolution(decoder, lateral),
        };
        let pitch = pitch.map(|pitch| super::shape::pitch(pitch.x, pitch.y)).transpose()?;
        let offset = number(&OFFSET)?.unwrap_or(0.0) * metres;
        Ok(Self { step, offset, pitch, unit: unit::name(metres).to_owned() })
    }

    /// A sentence on the scales.
    pub(super) fn said(&self) -> String {
        let pitch = match self.pitch {
            Some(pitch) => format!("pitch {} µm", pitch.x * 1e6),
            None => "no pitch is stated".to_owned(),
        };
        format!("heights in {}, {pitch}", self.unit)
    }
}

/// Distance between pixels [m] from the resolution tags, in their unit or that of the description.
fn resolution<R: Read + Seek>(decoder: &mut Decoder<R>, lateral: Option<f64>) -> Option<DVec2> {
    let unit = match decoder.find_tag_unsigned::<u16>(Tag::ResolutionUnit).ok()? {
        Some(3) => 0.01,
        Some(1) => lateral?,
        // Dots per inch are the default of programs that do not know sizes.
        _ => return None,
    };
    let mut per_unit = |tag: Tag| match decoder.find_tag(tag).ok()?? {
        Value::Rational(above, below) if above > 0 && below > 0 => Some(f64::from(above) / f64::from(below)),
        _ => None,
    };
    let resolution = DVec2::new(per_unit(Tag::XResolution)?, per_unit(Tag::YResolution)?);
    Some(unit / resolution)
}

/// Lower-case keys and values of a description.
fn pairs(description: &str) -> Vec<(String, String)> {
    let bare = |text: &str| text.trim().trim_matches('"').trim().replace("\\u00B5", "µ").replace("\\u00b5", "µ");
    let parts = description.split(['\n', '\r', ',', ';', '{', '}']);
    let pairs = parts.filter_map(|part| part.split_once(['=', ':']));
    pairs.map(|(key, value)| (bare(key).to_lowercase(), bare(value))).collect()
}
