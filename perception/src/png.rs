//! PNG with one channel.

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError};

/// Encodes numbers of eight bits, row by row from the top left.
///
/// # Errors
/// If a side is too long for PNG.
///
/// # Panics
/// If their number differs from the number of pixels.
pub fn png8((width, height): (usize, usize), values: &[u8]) -> Result<Vec<u8>, ImageError> {
    encoded((width, height), values, ExtendedColorType::L8)
}

/// Encodes numbers of sixteen bits, row by row from the top left.
///
/// # Errors
/// If a side is too long for PNG.
///
/// # Panics
/// If their number differs from the number of pixels.
pub fn png16((width, height): (usize, usize), values: &[u16]) -> Result<Vec<u8>, ImageError> {
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_ne_bytes()).collect();
    encoded((width, height), &bytes, ExtendedColorType::L16)
}

fn encoded((width, height): (usize, usize), bytes: &[u8], channel: ExtendedColorType) -> Result<Vec<u8>, ImageError> {
    let mut png = Vec::new();
    PngEncoder::new(&mut png).write_image(bytes, width as u32, height as u32, channel)?;
    Ok(png)
}
