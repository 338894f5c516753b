//! Text in a picture.

use super::font::{GLYPH_HEIGHT, GLYPH_WIDTH, glyph};
use super::frame::Picture;

/// Empty columns between glyphs [dots].
const SPACING: usize = 1;

/// Width and height [pixels] of one line of text with `scale` pixels per dot.
pub fn text_size(text: &str, scale: usize) -> (usize, usize) {
    let dots = (text.chars().count() * (GLYPH_WIDTH + SPACING)).saturating_sub(SPACING);
    (dots * scale, GLYPH_HEIGHT * scale)
}

/// Draws one line of text with its top left corner at `at`.
///
/// - `scale`: pixels per dot
/// - `colour`: sRGB
pub fn draw_text(picture: &mut Picture, text: &str, at: (usize, usize), scale: usize, colour: [u8; 3]) {
    for (place, character) in text.chars().enumerate() {
        let left = at.0 + place * (GLYPH_WIDTH + SPACING) * scale;
        for (row, dots) in glyph(character).into_iter().enumerate() {
            for column in (0..GLYPH_WIDTH).filter(|column| dots >> (GLYPH_WIDTH - 1 - column) & 1 == 1) {
                picture.fill((left + column * scale, at.1 + row * scale), (scale, scale), colour);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_digit_and_sign_has_a_glyph_of_its_own() {
        let letters = ('a'..='z').chain('A'..='Z').chain('0'..='9').chain(".,-+[]/%µ²³".chars());
        let glyphs: Vec<_> = letters.map(glyph).collect();
        let missing = glyph('\u{0}');
        for (i, rows) in glyphs.iter().enumerate() {
            assert_ne!(*rows, missing);
            assert!(rows.iter().all(|row| *row < 32) && rows.iter().any(|row| *row > 0));
            assert!(!glyphs[..i].contains(rows), "glyph {i} is drawn twice");
        }
    }

    #[test]
    fn a_dash_is_five_dots_wide_and_stays_in_the_picture() {
        let mut picture = Picture::filled(12, 18, [255; 3]);
        draw_text(&mut picture, "-----", (1, 0), 2, [0; 3]);
        let dark = picture.rgb.chunks(3).filter(|pixel| pixel[0] == 0).count();
        assert_eq!(dark, 2 * 10, "one whole dash of 10 × 2 pixels, then the border");
        assert_eq!(text_size("-----", 2), (58, 18));
    }
}
