//! Sensofar PLUX files: `index.xml` and layers of 32-bit heights in micrometres in a zip.
//!
//! Layout as in the public readers surfalize 0.19 and SurfaceTopography 1.27.

use files::input::quoted;
use roxmltree::{Document, Node};

use super::archive::{Archive, MAGIC};
use super::element::{Element, Order};
use super::{Format, Source, Surface, missing, shape};
use crate::misread::{Misread, Place};

const INDEX: &str = "index.xml";
const HEIGHTS: &str = "LAYER_0.raw";
const ACCEPTED: &str = "a Sensofar PLUX file with one layer of heights is expected";
/// SI value of the unit of the file [m].
const UNIT: f64 = 1e-6;

/// Sensofar PLUX files.
pub(super) struct Plux;

impl Format for Plux {
    fn name(&self) -> &'static str {
        "Sensofar PLUX"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["plux"]
    }

    fn recognises(&self, source: &Source) -> bool {
        let has_index = |bytes| Archive::open(bytes, &[]).is_ok_and(|archive| archive.has(INDEX));
        source.bytes.starts_with(MAGIC) && has_index(source.bytes)
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        read(source.bytes).map_err(|found| Place::file(source.file).bad(found, ACCEPTED))
    }
}

fn read(bytes: &[u8]) -> Result<Surface, String> {
    let mut archive = Archive::open(bytes, &[INDEX, HEIGHTS])?;
    let text = archive.text(INDEX)?;
    let document = Document::parse(&text).map_err(|error| format!("{INDEX}, line {}: not XML", error.pos().row))?;
    let root = document.root_element();
    let number = |name: &str| -> Result<f64, String> {
        let found = text_of(root, &["GENERAL", name]).ok_or_else(|| format!("{INDEX} has no GENERAL/{name}"))?;
        found.parse().map_err(|_| format!("{INDEX}: GENERAL/{name} is {}", quoted(found)))
    };
    let (nx, ny) = shape::checked(number("IMAGE_SIZE_X")? as u64, number("IMAGE_SIZE_Y")? as u64)?;
    let pitch = shape::pitch(number("FOV_X")? * UNIT, number("FOV_Y")? * UNIT)?;
    let member = text_of(root, &["LAYER_0", "FILENAME_Z"]).unwrap_or(HEIGHTS);
    let length = nx * ny * Element::F32.size();
    let data = archive.member(member, length as u64)?;
    if data.len() != length {
        return Err(format!("{} has {} bytes where {length} are stated", archive.shown(member), data.len()));
    }
    let mut heights = Element::F32.values(&data, Order::Little);
    let strange = heights.iter_mut().filter(|height| !height.is_finite());
    let count = strange.map(|height| *height = f64::NAN).count();
    let mut notes = vec![format!("Sensofar PLUX file: {nx} x {ny} pixels, pitch {} µm", pitch.x * 1e6)];
    if count > 0 {
        notes.push(missing::said(count, "NaN"));
    }
    notes.extend(missing::clear(&mut heights, None));
    if text_of(root, &["LAYER_1", "FILENAME_Z"]).is_some() {
        notes.push("the first of several layers is read".to_owned());
    }
    heights.iter_mut().for_each(|height| *height *= UNIT);
    let heights = shape::turned(heights, nx);
    Ok(Surface { format: Plux.name(), nx, ny, pitch: Some(pitch), origin: None, heights, notes })
}

/// Text of the element at a path of names below `root`.
fn text_of<'a>(root: Node<'a, 'a>, path: &[&str]) -> Option<&'a str> {
    let mut node = root;
    for name in path {
        node = node.children().find(|child| child.has_tag_name(*name))?;
    }
    node.text().map(str::trim).filter(|text| !text.is_empty())
}
