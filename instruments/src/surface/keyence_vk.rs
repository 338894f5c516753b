//! Measurements of Keyence's VK series: VK3 and VK4, and VK6 and VK7, which wrap a VK4 in a zip.
//!
//! Layout as in the public readers of Gwyddion 2.62 (`keyence.c`), surfalize 0.19 and SurfaceTopography 1.27.

use super::archive::Archive;
use super::bytes::Bytes;
use super::element::{Element, Order};
use super::{Format, MOST_PIXELS, Source, Surface, shape};
use crate::misread::{Misread, Place};

/// Zip member of VK6 and VK7 with the measurement.
const MEMBER: &str = "Vk4File";
const ACCEPTED: &str = "a measurement of Keyence's VK series with heights is expected";
/// Bytes before the table of offsets.
const HEAD: usize = 12;
/// Entries of the table of offsets: conditions, and the first height image.
const CONDITIONS: usize = 0;
const HEIGHTS: usize = 6;
/// Index of numbers among the conditions: pixel size along x and y, and height step.
const SIZES: usize = 42;
/// Bytes of a palette, before the heights.
const PALETTE: usize = 768;
/// SI value of the unit of sizes, the picometre [m].
const UNIT: f64 = 1e-12;
/// Upper bound of the bytes per pixel in all images of a measurement together.
const BYTES_PER_PIXEL: usize = 64;

/// Measurements of Keyence's VK series.
pub(super) struct KeyenceVk;

impl Format for KeyenceVk {
    fn name(&self) -> &'static str {
        "Keyence VK"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["vk3", "vk4", "vk6", "vk7"]
    }

    fn recognises(&self, source: &Source) -> bool {
        is_plain(source.bytes) || source.bytes.starts_with(b"VK6") || source.bytes.starts_with(b"VK7")
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let bad = |found: String| Place::file(source.file).bad::<Misread>(found, ACCEPTED);
        if is_plain(source.bytes) {
            return read(source.bytes).map_err(bad);
        }
        let unpacked = Archive::open(source.bytes, &[MEMBER])
            .and_then(|mut archive| archive.member(MEMBER, (MOST_PIXELS * BYTES_PER_PIXEL) as u64));
        read(&unpacked.map_err(bad)?).map_err(bad)
    }
}

fn is_plain(bytes: &[u8]) -> bool {
    bytes.starts_with(b"VK4_") || bytes.starts_with(b"VK3_")
}

fn read(all: &[u8]) -> Result<Surface, String> {
    let mut bytes = Bytes::new(all);
    if !is_plain(all) {
        return Err("no VK4 inside".to_owned());
    }
    let mut number = |byte: usize| -> Result<u32, String> {
        bytes.seek(byte)?;
        bytes.u32()
    };
    let conditions = number(HEAD + 4 * CONDITIONS)? as usize;
    let image = number(HEAD + 4 * HEIGHTS)? as usize;
    let mut size = |at: usize| number(conditions.saturating_add(4 * (SIZES + at))).map(|size| f64::from(size) * UNIT);
    let pitch = shape::pitch(size(0)?, size(1)?)?;
    let step = size(2)?;
    if image == 0 || step <= 0.0 {
        return Err(format!("no heights, or steps of {step} m"));
    }
    bytes.seek(image)?;
    let (nx, ny) = shape::checked(bytes.u32()?.into(), bytes.u32()?.into())?;
    let element = element_of(bytes.u32()?, bytes.u32()?)?;
    let length = nx * ny * element.size();
    let stated = bytes.u32()? as usize;
    if stated != length {
        return Err(format!("{stated} bytes of heights for {nx} x {ny} pixels of {} bytes", element.size()));
    }
    // Lowest and highest height of the palette, and the palette.
    bytes.take(8 + PALETTE)?;
    let mut heights = element.values(bytes.take(length)?, Order::Little);
    heights.iter_mut().for_each(|height| *height *= step);
    let notes = vec![format!(
        "Keyence VK measurement: {nx} x {ny} pixels, pitch {} µm; the format marks no missing pixels",
        pitch.x * 1e6
    )];
    let heights = shape::turned(heights, nx);
    Ok(Surface { format: KeyenceVk.name(), nx, ny, pitch: Some(pitch), origin: None, heights, notes })
}

fn element_of(bits: u32, compression: u32) -> Result<Element, String> {
    match (bits, compression) {
        (16, 0) => Ok(Element::U16),
        (32, 0) => Ok(Element::U32),
        _ => Err(format!("heights of {bits} bits with compression {compression}")),
    }
}
