//! Surface data files of ISO 25178-71 (`.sdf`), as text and binary, versions 1.0 and 2.0, and their predecessor BCR.

use files::input::quoted;

use super::bytes::Bytes;
use super::element::{Element, Order};
use super::numbers::{Numbers, Words};
use super::{Format, Source, Surface, missing, shape};
use crate::misread::{Misread, Place};

const ACCEPTED: &str = "an SDF file (ISO 25178-71) without compression is expected";
/// Bytes of the signature at the start.
const MARK: usize = 8;
/// Maximum number of keys of a text header, more than the standard has.
const MOST_KEYS: usize = 64;

/// Surface data files.
pub(super) struct SurfaceData;

impl Format for SurfaceData {
    fn name(&self) -> &'static str {
        "SDF"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["sdf", "bcr"]
    }

    fn recognises(&self, source: &Source) -> bool {
        mark(source.bytes).is_some()
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let place = Place::file(source.file);
        match mark(source.bytes) {
            Some((true, _)) => {
                let mut words = Words::new(source.bytes, 0, 1);
                read_text(&mut words).map_err(|found| place.at_line(words.line).bad(found, ACCEPTED))
            }
            found => {
                let is_long = found.is_some_and(|(_, is_long)| is_long);
                read_binary(source.bytes, is_long).map_err(|found| place.bad(found, ACCEPTED))
            }
        }
    }
}

/// True for a text file, and true for 32-bit counts; `None` for another format.
fn mark(bytes: &[u8]) -> Option<(bool, bool)> {
    let text = match bytes.first()? {
        b'a' => true,
        b'b' => false,
        _ => return None,
    };
    match bytes.get(1..MARK)? {
        b"ISO-1.0" | b"BCR-1.0" | b"BCR-0.0" => Some((text, false)),
        b"ISO-2.0" => Some((text, true)),
        _ => None,
    }
}

/// Contents of a header.
struct Header {
    nx: usize,
    ny: usize,
    pitch: glam::DVec2,
    /// SI value of a height step [m].
    step: f64,
    element: Element,
}

impl Header {
    fn checked((nx, ny): (u64, u64), [x, y, z]: [f64; 3], compression: u8, kind: u8) -> Result<Self, String> {
        let (nx, ny) = shape::checked(nx, ny)?;
        if compression != 0 {
            return Err(format!("heights with compression {compression}"));
        }
        if !(z.is_finite() && z != 0.0) {
            return Err(format!("a Zscale of {z}"));
        }
        let kinds = [
            Element::U8,
            Element::U16,
            Element::U32,
            Element::F32,
            Element::I8,
            Element::I16,
            Element::I32,
            Element::F64,
        ];
        let element = *kinds.get(usize::from(kind)).ok_or_else(|| format!("heights of type {kind}"))?;
        Ok(Self { nx, ny, pitch: shape::pitch(x, y)?, step: z, element })
    }

    /// The map from the stored numbers.
    fn surface(self, mut heights: Vec<f64>, mut notes: Vec<String>) -> Surface {
        let Self { nx, ny, pitch, step, element } = self;
        let code = missing_code(element);
        let is_missing = |height: f64| Some(height) == code || height.is_infinite();
        let cells = heights.iter_mut().filter(|height| is_missing(**height));
        let count = cells.map(|height| *height = f64::NAN).count();
        if count > 0 {
            notes.push(missing::said(count, &format!("{:?}", code.unwrap_or(f64::INFINITY))));
        }
        heights.iter_mut().for_each(|height| *height *= step);
        notes.insert(0, format!("SDF file: {nx} x {ny} pixels, pitch {} µm", pitch.x * 1e6));
        let heights = shape::turned(heights, nx);
        Surface { format: SurfaceData.name(), nx, ny, pitch: Some(pitch), origin: None, heights, notes }
    }
}

/// Code for a missing height: the lowest number of signed types and the highest of unsigned ones.
fn missing_code(element: Element) -> Option<f64> {
    Some(match element {
        Element::I8 => f64::from(i8::MIN),
        Element::I16 => f64::from(i16::MIN),
        Element::I32 => f64::from(i32::MIN),
        Element::U16 => f64::from(u16::MAX),
        Element::U32 => f64::from(u32::MAX),
        Element::F32 => f64::from(f32::MIN),
        Element::F64 => f64::MIN,
        Element::U8 | Element::U64 | Element::I64 => return None,
    })
}

fn read_binary(bytes: &[u8], is_long: bool) -> Result<Surface, String> {
    let mut bytes = Bytes::new(bytes);
    // The signature is followed by the manufacturer and two dates.
    bytes.take(MARK + 10 + 12 + 12)?;
    let mut count = || if is_long { bytes.u32().map(u64::from) } else { bytes.u16().map(u64::from) };
    let counts = (count()?, count()?);
    let scales = [bytes.f64()?, bytes.f64()?, bytes.f64()?];
    bytes.f64()?;
    let (compression, kind, _check) = (bytes.u8()?, bytes.u8()?, bytes.u8()?);
    let header = Header::checked(counts, scales, compression, kind)?;
    let data = bytes.take(header.nx * header.ny * header.element.size())?;
    let heights = header.element.values(data, Order::Little);
    Ok(header.surface(heights, Vec::new()))
}

fn read_text(words: &mut Words) -> Result<Surface, String> {
    let (counts, scales, compression, kind) = read_keys(words)?;
    let header = Header::checked(counts, scales, compression, kind)?;
    let (count, mut numbers, mut heights) = (header.nx * header.ny, Numbers::default(), Vec::new());
    for word in words.by_ref().take(count) {
        let number = numbers.number(word).filter(|_| word != b"*");
        heights.push(number.ok_or_else(|| format!("{} is not a number", quoted(&String::from_utf8_lossy(word))))?);
    }
    if heights.len() < count {
        return Err(format!("{} heights where {} x {} are stated", heights.len(), header.nx, header.ny));
    }
    match words.next() {
        // Gwyddion writes no * after the heights.
        None if !words.ends_with_a_line() => return Err("a last height that is cut off".to_owned()),
        Some(word) if !word.starts_with(b"*") => {
            return Err(format!("more heights than the {} x {} that are stated", header.nx, header.ny));
        }
        _ => {}
    }
    Ok(header.surface(heights, numbers.notes().collect()))
}

/// Counts, scales, compression and type of a text header.
#[expect(clippy::type_complexity, reason = "the arguments of one check")]
fn read_keys(words: &mut Words) -> Result<((u64, u64), [f64; 3], u8, u8), String> {
    let mut keys: [(&str, Option<f64>); 7] =
        ["numpoints", "numprofiles", "xscale", "yscale", "zscale", "compression", "datatype"].map(|key| (key, None));
    words.rest_of_line();
    for _ in 0..MOST_KEYS {
        let line = String::from_utf8_lossy(words.rest_of_line()).to_lowercase();
        if line.starts_with('*') || words.is_done() {
            let value = |at: usize| keys[at].1.ok_or_else(|| format!("no {} in the header", keys[at].0));
            let optional = |at: usize| keys[at].1.unwrap_or(0.0) as u8;
            let counts = (value(0)? as u64, value(1)? as u64);
            // Heights in text form need no type; an old file has none.
            let kind = keys[6].1.map_or(7, |kind| kind as u8);
            return Ok((counts, [value(2)?, value(3)?, value(4)?], optional(5), kind));
        }
        let Some((key, value)) = line.split_once('=') else { continue };
        if let Some(slot) = keys.iter_mut().find(|slot| slot.0 == key.trim()) {
            let number = value.trim().parse().map_err(|_| format!("{} is {}", slot.0, quoted(value.trim())))?;
            slot.1 = Some(number);
        }
    }
    Err(format!("{MOST_KEYS} lines of keys and no *"))
}
