//! Text in a picture: Noto Sans Mono, as the crate `noto-sans-mono-bitmap` has drawn it in four heights.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, RasterizedChar, get_raster, get_raster_width};

use super::frame::Picture;

/// Shown for a character that the font lacks.
const MISSING: char = '\u{fffd}';

/// Raster height and its enlargement for a scale; beyond the largest height, pixels are repeated.
fn raster(scale: usize) -> (RasterHeight, usize) {
    match scale {
        0 | 1 => (RasterHeight::Size16, 1),
        2 => (RasterHeight::Size24, 1),
        _ => (RasterHeight::Size32, scale / 3),
    }
}

/// Width and height [pixels] of one line of text; a larger `scale` is larger text.
pub fn text_size(text: &str, scale: usize) -> (usize, usize) {
    let (height, times) = raster(scale);
    (text.chars().count() * get_raster_width(FontWeight::Regular, height) * times, height.val() * times)
}

/// Draws one line of text with its top left corner at `at`; what lies outside the picture is left out.
///
/// - `scale`: as for [`text_size`]
/// - `colour`: sRGB
pub fn draw_text(picture: &mut Picture, text: &str, at: (usize, usize), scale: usize, colour: [u8; 3]) {
    let (height, times) = raster(scale);
    let width = get_raster_width(FontWeight::Regular, height) * times;
    for (place, character) in text.chars().enumerate() {
        let Some(glyph) = glyph(character, height) else { continue };
        let left = at.0 + place * width;
        for (row, line) in glyph.rows().enumerate() {
            for (column, &ink) in line.iter().enumerate().filter(|(_, ink)| **ink > 0) {
                blend(picture, (left + column * times, at.1 + row * times), times, (colour, ink));
            }
        }
    }
}

/// Returns the pixels of a character, or of the sign for missing ones.
fn glyph(character: char, height: RasterHeight) -> Option<RasterizedChar> {
    let of = |character| get_raster(character, FontWeight::Regular, height);
    of(character).or_else(|| of(MISSING))
}

/// Mixes a colour into a square of pixels.
///
/// - `ink`: share of the colour, 255 covers
fn blend(picture: &mut Picture, (left, top): (usize, usize), side: usize, (colour, ink): ([u8; 3], u8)) {
    for y in top..(top + side).min(picture.height) {
        for x in left..(left + side).min(picture.width) {
            let pixel = 3 * (y * picture.width + x);
            for (below, own) in picture.rgb[pixel..pixel + 3].iter_mut().zip(colour) {
                let mixed = u32::from(own) * u32::from(ink) + u32::from(*below) * u32::from(255 - ink);
                *below = ((mixed + 127) / 255) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_digit_and_sign_has_a_glyph_of_its_own() {
        let letters = ('a'..='z').chain('A'..='Z').chain('0'..='9').chain(".,-+[]/%µ²³°×".chars());
        for height in [RasterHeight::Size16, RasterHeight::Size24, RasterHeight::Size32] {
            let glyphs: Vec<&[u8]> = letters.clone().map(|letter| glyph(letter, height).unwrap().pixels()).collect();
            let missing = glyph('\u{2603}', height).unwrap().pixels();
            for (i, pixels) in glyphs.iter().enumerate() {
                assert!(*pixels != missing && pixels.iter().any(|value| *value > 127), "glyph {i}");
                assert!(!glyphs[..i].contains(pixels), "glyph {i} is drawn twice");
            }
        }
    }

    #[test]
    fn text_stays_in_the_picture_and_grows_with_its_scale() {
        let mut last = (0, 0);
        for scale in 1..9 {
            let (width, height) = text_size("mm", scale);
            assert!(width >= last.0 && height >= last.1, "scale {scale}");
            last = (width, height);
            let mut whole = Picture::filled(width, height, [255; 3]);
            draw_text(&mut whole, "mm", (0, 0), scale, [0; 3]);
            let mut half = Picture::filled(width / 2, height, [255; 3]);
            draw_text(&mut half, "mm", (0, 0), scale, [0; 3]);
            let dark = |picture: &Picture| picture.rgb.iter().filter(|value| **value < 128).count();
            assert!(dark(&half) > 0 && dark(&whole) == 2 * dark(&half), "scale {scale}");
        }
    }

    #[test]
    fn edges_are_mixed_with_what_lies_below() {
        let mut picture = Picture::filled(20, 20, [100; 3]);
        draw_text(&mut picture, "o", (2, 2), 1, [200, 100, 0]);
        let pixels: Vec<&[u8]> = picture.rgb.chunks(3).collect();
        assert!(pixels.contains(&&[100, 100, 100][..]) && pixels.iter().all(|pixel| pixel[1] == 100));
        assert!(pixels.iter().any(|pixel| (110..190).contains(&pixel[0])), "no smooth edge");
    }
}
