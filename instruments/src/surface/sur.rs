//! Digital Surf surfaces (`.sur`) of MountainsMap: a header of 512 bytes, then integers, plain or compressed.
//!
//! Layout as in the public readers of Gwyddion 2.62 (`surffile.c`) and surfalize 0.19.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::bytes::Bytes;
use super::element::{Element, Order};
use super::write::{MapWriteError, pitch_of};
use super::{Format, Source, Surface, missing, shape, unit};
use crate::misread::{Misread, Place};

const PLAIN: &[u8] = b"DIGITAL SURF";
const PACKED: &[u8] = b"DSCOMPRESSED";
/// Bytes of the header.
const HEADER: usize = 512;
/// Bytes of a unit or a name.
const WORD: usize = 16;
/// Difference between the lowest height and the code for a missing height.
const MISSING_BELOW: i32 = 2;
/// Largest height that is written [steps].
const MOST_STEPS: f64 = (1_u32 << 30) as f64;
/// Maximum number of compressed streams of a file; the current version of the format has one.
const MOST_STREAMS: usize = 1024;
const ACCEPTED: &str = "a Digital Surf surface (.sur) with heights of 16 or 32 bits is expected";

/// Digital Surf surfaces.
pub(super) struct DigitalSurf;

impl Format for DigitalSurf {
    fn name(&self) -> &'static str {
        "Digital Surf"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["sur"]
    }

    fn recognises(&self, source: &Source) -> bool {
        source.bytes.starts_with(PLAIN) || source.bytes.starts_with(PACKED)
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        read(source.bytes).map_err(|found| Place::file(source.file).bad(found, ACCEPTED))
    }
}

/// Contents of the header.
struct Header {
    is_packed: bool,
    objects: i16,
    missing: Option<f64>,
    element: Element,
    nx: usize,
    ny: usize,
    pitch: glam::DVec2,
    /// SI value of a step, and height of step zero [m].
    scale: (f64, f64),
    inverted: i16,
    /// Bytes of comments between header and heights.
    comments: usize,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, String> {
        let mut header = Bytes::new(bytes);
        header.take(HEADER)?;
        let mut at = |byte: usize| header.seek(byte).map(|()| header);
        let element = match at(98)?.u16()? {
            16 => Element::I16,
            32 => Element::I32,
            bits => return Err(format!("heights of {bits} bits")),
        };
        let side = |count: i32| u64::try_from(count).unwrap_or(0);
        let (nx, ny) = shape::checked(side(at(108)?.i32()?), side(at(112)?.i32()?))?;
        let mut unit_at = |byte: usize| -> Result<f64, String> {
            let name = at(byte)?.text(WORD)?;
            unit::metres(&name)
                .ok_or_else(|| format!("byte {byte}: {} is not a unit of length", files::input::quoted(&name)))
        };
        let units = [unit_at(180)?, unit_at(180 + WORD)?, unit_at(180 + 2 * WORD)?];
        let mut number = |byte: usize| at(byte)?.f32().map(f64::from);
        let pitch = shape::pitch(number(120)? * units[0], number(124)? * units[1])?;
        let scale = (number(128)? * units[2], number(474)? * units[2]);
        if !(scale.0.is_finite() && scale.1.is_finite()) {
            return Err(format!("steps of {} m from {} m", scale.0, scale.1));
        }
        let lowest = at(100)?.i32()?;
        let has_missing = at(86)?.i16()? == 1;
        let comments = [334, 336].map(|byte| at(byte).and_then(|mut bytes| bytes.u16()));
        let [comment, private] = comments;
        Ok(Self {
            is_packed: bytes.starts_with(PACKED),
            objects: at(14)?.i16()?,
            missing: has_missing.then(|| f64::from(lowest) - f64::from(MISSING_BELOW)),
            element,
            nx,
            ny,
            pitch,
            scale,
            inverted: at(290)?.i16()?,
            comments: usize::from(comment?) + usize::from(private?),
        })
    }
}

fn read(bytes: &[u8]) -> Result<Surface, String> {
    let header = Header::read(bytes)?;
    let mut rest = Bytes::new(bytes);
    rest.seek(HEADER)?;
    rest.take(header.comments)?;
    let length = header.nx * header.ny * header.element.size();
    let unpacked;
    let data = if header.is_packed {
        unpacked = unpack(&mut rest, length)?;
        &unpacked
    } else {
        rest.take(length)?
    };
    let mut heights = header.element.values(data, Order::Little);
    let (nx, ny) = (header.nx, header.ny);
    let mut notes = vec![format!("Digital Surf file: {nx} x {ny} pixels, pitch {} µm", header.pitch.x * 1e6)];
    if header.objects > 1 {
        notes.push(format!("the first of {} objects is read", header.objects));
    }
    notes.extend(mark_missing(&mut heights, header.missing));
    // 1 to 3 mean that heights are inverted; 2 also mirrors x, 3 also y.
    let sign = if (1..=3).contains(&header.inverted) { -1.0 } else { 1.0 };
    heights.iter_mut().for_each(|height| *height = sign * (*height * header.scale.0 + header.scale.1));
    if header.inverted == 2 {
        heights.chunks_exact_mut(nx).for_each(<[f64]>::reverse);
    }
    if header.inverted != 3 {
        heights = shape::turned(heights, nx);
    }
    Ok(Surface { format: DigitalSurf.name(), nx, ny, pitch: Some(header.pitch), origin: None, heights, notes })
}

/// Replaces the file's code for missing heights by NaN.
fn mark_missing(heights: &mut [f64], code: Option<f64>) -> Option<String> {
    let code = code?;
    let cells = heights.iter_mut().filter(|height| **height == code);
    let count = cells.map(|height| *height = f64::NAN).count();
    (count > 0).then(|| missing::said(count, &format!("{code}")))
}

/// The heights of a compressed file: a list of stream lengths, then the streams.
fn unpack(bytes: &mut Bytes, length: usize) -> Result<Vec<u8>, String> {
    let streams = bytes.u32()? as usize;
    if streams > MOST_STREAMS {
        return Err(format!("{streams} packed streams"));
    }
    let mut list = Bytes::new(bytes.take(streams.checked_mul(8).ok_or("a list without end")?)?);
    let mut data = Vec::new();
    for stream in 1..=streams {
        let (raw, packed) = (list.u32()? as u64, list.u32()? as usize);
        let place = bytes.position();
        let before = data.len();
        let most = raw.min((length - before.min(length)) as u64 + 1);
        ZlibDecoder::new(bytes.take(packed)?)
            .take(most)
            .read_to_end(&mut data)
            .map_err(|error| format!("byte {place}: packed stream {stream}: {error}"))?;
        if (data.len() - before) as u64 != raw {
            return Err(format!("byte {place}: stream {stream} does not have {raw} bytes"));
        }
    }
    if data.len() != length {
        return Err(format!("{} bytes of heights where {length} are stated", data.len()));
    }
    Ok(data)
}

/// The bytes of a file with 32-bit heights, in steps of a power of two micrometres.
///
/// # Errors
/// [`MapWriteError`] without a pitch or without any height.
pub(super) fn write(surface: &Surface) -> Result<Vec<u8>, MapWriteError> {
    let pitch = pitch_of(surface)? * 1e6;
    let seen = || surface.heights.iter().filter(|height| height.is_finite()).map(|height| height * 1e6);
    let most = seen().fold(0.0, |most: f64, height| most.max(height.abs()));
    if seen().next().is_none() {
        return Err(MapWriteError::NoHeight);
    }
    let step = if most > 0.0 { (most / MOST_STEPS).log2().ceil().exp2() } else { 1.0 };
    let steps = |height: f64| (height * 1e6 / step).round() as i32;
    let (low, high) = seen().fold((i32::MAX, i32::MIN), |(low, high), height| {
        let height = steps(height * 1e-6);
        (low.min(height), high.max(height))
    });
    let missing = low - MISSING_BELOW;
    let mut bytes = header_of(surface, [pitch.x as f32, pitch.y as f32, step as f32], (low, high));
    for row in surface.heights.chunks_exact(surface.nx).rev() {
        for height in row {
            let value = if height.is_finite() { steps(*height) } else { missing };
            bytes.extend(value.to_le_bytes());
        }
    }
    Ok(bytes)
}

/// A header for spacings in micrometres, and the lowest and highest step.
fn header_of(surface: &Surface, spacing: [f32; 3], (low, high): (i32, i32)) -> Vec<u8> {
    let mut header = vec![0; HEADER];
    let mut put = |byte: usize, bytes: &[u8]| header[byte..][..bytes.len()].copy_from_slice(bytes);
    put(0, PLAIN);
    let has_missing = surface.heights.iter().any(|height| !height.is_finite());
    // Objects, version, kind (a surface), missing heights, bits.
    for (byte, value) in [(14, 1_i16), (16, 1), (18, 2), (86, i16::from(has_missing)), (98, 32), (288, 1)] {
        put(byte, &value.to_le_bytes());
    }
    let (nx, ny) = (surface.nx as i32, surface.ny as i32);
    for (byte, value) in [(100, low), (104, high), (108, nx), (112, ny), (116, nx * ny)] {
        put(byte, &value.to_le_bytes());
    }
    for (axis, spacing) in spacing.into_iter().enumerate() {
        put(120 + 4 * axis, &spacing.to_le_bytes());
        put(132 + WORD * axis, &b"XYZ"[axis..=axis]);
        put(180 + WORD * axis, b"\xb5m");
        put(228 + WORD * axis, b"\xb5m");
        put(276 + 4 * axis, &1_f32.to_le_bytes());
    }
    header
}
