//! Measurements of Keyence's VR series (`.zon`): a preview, then a zip whose members may also be compressed with zstd.
//!
//! Layout as in the public readers surfalize 0.19 and SurfaceTopography 1.27; names of members are fixed.

use std::io::Read;

use roxmltree::Document;
use ruzstd::decoding::StreamingDecoder;

use super::archive::{Archive, MOST_XML};
use super::bytes::Bytes;
use super::element::{Element, Order};
use super::{Format, MOST_PIXELS, Source, Surface, shape};
use crate::misread::{Misread, Place};

/// Zip members with the heights, with a byte for each pixel, and with the sizes of a pixel and a step.
const HEIGHTS: &str = "4cdb0c75-5706-48cc-a9a1-adf395d609ae";
const STATES: &str = "9e7ca6dd-0e6a-4d7b-8986-f0a7b773c916";
const SIZES: &str = "686613b8-27b5-4a29-8ffc-438c2780873e";
/// First bytes of a member that is compressed with zstd.
const ZSTD: &[u8] = &[0x28, 0xb5, 0x2f, 0xfd];
/// Bits of a pixel's state: not measured, and excluded by the operator.
const UNMEASURED: u8 = 1;
const EXCLUDED: u8 = 2;
/// Bytes before the numbers of a member.
const HEAD: usize = 16;
const ACCEPTED: &str = "a measurement of Keyence's VR series (.zon) with heights is expected";

/// Measurements of Keyence's VR series.
pub(super) struct KeyenceZon;

impl Format for KeyenceZon {
    fn name(&self) -> &'static str {
        "Keyence ZON"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["zon"]
    }

    fn recognises(&self, source: &Source) -> bool {
        source.bytes.starts_with(b"KPK0") || source.bytes.starts_with(b"KPK1")
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        read(source.bytes).map_err(|found| Place::file(source.file).bad(found, ACCEPTED))
    }
}

fn read(bytes: &[u8]) -> Result<Surface, String> {
    let mut archive = Archive::open(bytes, &[HEIGHTS, STATES, SIZES])?;
    let (pixel, step) = sizes(&unpacked(&mut archive, SIZES, MOST_XML)?)?;
    let heights = unpacked(&mut archive, HEIGHTS, most(Element::I32))?;
    let (nx, ny, mut heights) = matrix(&heights, Element::I32)?;
    heights.iter_mut().for_each(|height| *height *= step);
    let mut notes = vec![format!("Keyence ZON file: {nx} x {ny} pixels, pitch {} µm", pixel * 1e6)];
    if archive.has(STATES) {
        let states = unpacked(&mut archive, STATES, most(Element::U8))?;
        let (columns, rows, states) = matrix(&states, Element::U8)?;
        if (columns, rows) != (nx, ny) {
            return Err(format!("states of {columns} x {rows} pixels for {nx} x {ny}"));
        }
        notes.extend(mark_missing(&mut heights, &states));
    }
    let heights = shape::turned(heights, nx);
    let pitch = Some(shape::pitch(pixel, pixel)?);
    Ok(Surface { format: KeyenceZon.name(), nx, ny, pitch, origin: None, heights, notes })
}

/// Marks pixels as missing by their states; returns the reasons.
fn mark_missing(heights: &mut [f64], states: &[f64]) -> Vec<String> {
    let reasons = [(UNMEASURED, "were not measured"), (EXCLUDED, "were left out by the operator")];
    let mut notes = Vec::new();
    for (bit, reason) in reasons {
        let is_marked = |state: f64| state as u8 & bit != 0;
        let marked = heights.iter_mut().zip(states).filter(|(_, state)| is_marked(**state));
        let count = marked.map(|(height, _)| *height = f64::NAN).count();
        if count > 0 {
            notes.push(format!("{count} pixels {reason}: read as missing"));
        }
    }
    notes
}

/// Bytes of the largest member of numbers.
fn most(element: Element) -> u64 {
    (MOST_PIXELS * element.size() * 2 + HEAD) as u64
}

/// A member, decompressed if it is compressed with zstd.
fn unpacked(archive: &mut Archive, name: &str, most: u64) -> Result<Vec<u8>, String> {
    let bytes = archive.member(name, most)?;
    if !bytes.starts_with(ZSTD) {
        return Ok(bytes);
    }
    let bad = |error: String| format!("member {}: {error}", archive.shown(name));
    let decoder = StreamingDecoder::new(&bytes[..]).map_err(|error| bad(error.to_string()))?;
    let mut unpacked = Vec::new();
    decoder.take(most + 1).read_to_end(&mut unpacked).map_err(|error| bad(error.to_string()))?;
    Ok(unpacked)
}

/// Columns, rows and numbers of a member.
fn matrix(bytes: &[u8], element: Element) -> Result<(usize, usize, Vec<f64>), String> {
    let mut bytes = Bytes::new(bytes);
    let [columns, rows, size, stride] = [bytes.u32()?, bytes.u32()?, bytes.u32()?, bytes.u32()?];
    let (nx, ny) = shape::checked(columns.into(), rows.into())?;
    let (size, stride) = (size as usize, stride as usize);
    if size != element.size() || stride < nx * size {
        return Err(format!("numbers of {size} bytes in rows of {stride}"));
    }
    let rows = bytes.take(stride.checked_mul(ny).ok_or("rows without end")?)?;
    let numbers = rows.chunks_exact(stride).flat_map(|row| element.values(&row[..nx * size], Order::Little));
    Ok((nx, ny, numbers.collect()))
}

/// SI values of a pixel and of a height step [m].
fn sizes(xml: &[u8]) -> Result<(f64, f64), String> {
    let text = std::str::from_utf8(xml).map_err(|_| "sizes that are not UTF-8".to_owned())?;
    let document = Document::parse(text.trim_start_matches('\u{feff}'))
        .map_err(|error| format!("member {SIZES}, line {}: not XML", error.pos().row))?;
    let number = |name: &str| {
        let node = document.descendants().find(|node| node.tag_name().name() == name);
        let number = node.and_then(|node| node.text()?.trim().parse::<f64>().ok());
        number
            .filter(|number| number.is_finite() && *number > 0.0)
            .ok_or_else(|| format!("member {SIZES} without {name}"))
    };
    Ok((number("MeterPerPixel")?, number("MeterPerUnit")?))
}
