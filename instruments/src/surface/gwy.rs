//! Gwyddion files (`.gwy`): the first channel of heights, with its mask.
//!
//! Layout as in the Gwyddion user guide, "Gwyddion file format".

use super::element::{Element, Order};
use super::gwy_object::{Object, Value};
use super::{Format, Source, Surface, shape, unit};
use crate::misread::{Misread, Place};

/// First bytes.
const MAGIC: &[u8] = b"GWYP";
const ACCEPTED: &str = "a Gwyddion file with a channel of heights in a unit of length is expected";

/// Gwyddion files.
pub(super) struct Gwyddion;

impl Format for Gwyddion {
    fn name(&self) -> &'static str {
        "Gwyddion"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["gwy"]
    }

    fn recognises(&self, source: &Source) -> bool {
        source.bytes.starts_with(MAGIC)
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        read(source.bytes).map_err(|found| Place::file(source.file).bad(found, ACCEPTED))
    }
}

fn read(bytes: &[u8]) -> Result<Surface, String> {
    let root = Object::read(bytes.get(MAGIC.len()..).unwrap_or_default())?;
    let channels: Vec<u32> = {
        let number = |name: &&str| name.strip_prefix('/')?.strip_suffix("/data")?.parse().ok();
        let mut numbers: Vec<u32> = root.items.keys().filter_map(number).collect();
        numbers.sort_unstable();
        numbers
    };
    let field = |number: u32, what: &str| root.object(&format!("/{number}/{what}"));
    let is_height = |number: &&u32| field(**number, "data").and_then(|field| field.unit("si_unit_z")).is_some();
    let Some(&number) = channels.iter().find(is_height) else {
        return Err(format!("{} channels, none with heights in a unit of length", channels.len()));
    };
    let data = field(number, "data").ok_or("no channel")?;
    let title = root.text(&format!("/{number}/data/title")).unwrap_or_default();
    let mut surface = data.surface()?;
    let others = match channels.len() {
        1 => String::new(),
        count => format!(", the first with heights of {count}"),
    };
    surface.notes.push(format!("channel {number} {title:?} is read{others}"));
    if let Some(mask) = field(number, "mask") {
        let count = mark_masked(&mut surface, mask)?;
        surface.notes.push(format!("{count} pixels under the mask: read as missing"));
    }
    surface.heights = shape::turned(surface.heights, surface.nx);
    Ok(surface)
}

/// Marks pixels under a mask as missing, and counts them.
fn mark_masked(surface: &mut Surface, mask: &Object) -> Result<usize, String> {
    let (nx, ny, values) = mask.field()?;
    if (nx, ny) != (surface.nx, surface.ny) {
        return Err(format!("a mask of {nx} x {ny} pixels for {} x {}", surface.nx, surface.ny));
    }
    let masked = surface.heights.iter_mut().zip(values).filter(|(_, masked)| *masked > 0.0);
    Ok(masked.map(|(height, _)| *height = f64::NAN).count())
}

impl Object<'_> {
    /// SI value [m] of the unit of a data field; `None` if it is not a unit of length.
    fn unit(&self, name: &str) -> Option<f64> {
        unit::metres(self.object(name)?.text("unitstr")?)
    }

    /// Shape and values of a data field, rows from the top.
    fn field(&self) -> Result<(usize, usize, Vec<f64>), String> {
        let side = |name: &str| match self.get(name) {
            Some(Value::Integer(side)) => Ok(u64::try_from(*side).unwrap_or(0)),
            _ => Err(format!("a data field without {name}")),
        };
        let (nx, ny) = shape::checked(side("xres")?, side("yres")?)?;
        match self.get("data") {
            Some(Value::Numbers(bytes)) if bytes.len() == nx * ny * Element::F64.size() => {
                Ok((nx, ny, Element::F64.values(bytes, Order::Little)))
            }
            Some(Value::Numbers(bytes)) => Err(format!("{} numbers for {nx} x {ny} pixels", bytes.len() / 8)),
            _ => Err("a data field without data".to_owned()),
        }
    }

    /// The map of a data field, rows from the top.
    fn surface(&self) -> Result<Surface, String> {
        let (nx, ny, mut heights) = self.field()?;
        let size = |name: &str| match self.get(name) {
            Some(Value::Number(size)) => Ok(*size),
            _ => Err(format!("a data field without {name}")),
        };
        let lateral = self.unit("si_unit_xy").ok_or("no unit of length for x and y")?;
        let step = self.unit("si_unit_z").ok_or("no unit of length for heights")?;
        let pitch = shape::pitch(size("xreal")? / nx as f64 * lateral, size("yreal")? / ny as f64 * lateral)?;
        heights.iter_mut().for_each(|height| *height = if height.is_finite() { *height * step } else { f64::NAN });
        let notes = vec![format!("Gwyddion file: {nx} x {ny} pixels, pitch {} µm", pitch.x * 1e6)];
        Ok(Surface { format: Gwyddion.name(), nx, ny, pitch: Some(pitch), origin: None, heights, notes })
    }
}
