//! Losses of JPEG: a picture as it is after being stored and read.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageError, ImageFormat, load_from_memory_with_format};
use render::Picture;

/// Encodes a picture at a quality of 0 to 100 and decodes it again.
///
/// # Errors
/// If a side is longer than JPEG can store, 65,535 pixels.
pub(crate) fn through_jpeg(picture: &Picture, quality: u8) -> Result<Picture, ImageError> {
    let mut bytes = Vec::new();
    let (width, height) = (picture.width as u32, picture.height as u32);
    JpegEncoder::new_with_quality(&mut bytes, quality).encode(&picture.rgb, width, height, ExtendedColorType::Rgb8)?;
    let decoded = load_from_memory_with_format(&bytes, ImageFormat::Jpeg)?;
    Ok(Picture { rgb: decoded.into_rgb8().into_raw(), ..*picture })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lower_quality_loses_more_and_keeps_the_size() {
        let rgb = (0..40 * 30 * 3).map(|i| ((i * 7919) % 251) as u8).collect();
        let picture = Picture { width: 40, height: 30, rgb };
        let loss = |quality: u8| {
            let after = through_jpeg(&picture, quality).unwrap();
            assert_eq!((after.width, after.height, after.rgb.len()), (40, 30, picture.rgb.len()));
            after.rgb.iter().zip(&picture.rgb).map(|(a, b)| u64::from(a.abs_diff(*b))).sum::<u64>()
        };
        assert!(loss(40) > loss(95) && loss(95) > 0);
    }
}
