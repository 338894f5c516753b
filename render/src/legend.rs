//! Colour bar that shows the values of a colour-mapped picture.

use super::colour::to_srgb8;
use super::colour_map::colour_map;
use super::frame::Picture;
use super::text::{draw_text, text_size};

/// Number of intervals between ticks.
const INTERVALS: usize = 4;
const INK: [u8; 3] = [38, 44, 52];

/// A horizontal colour bar with ticks from zero to full scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Legend {
    /// Quantity and unit, such as `removed depth [mm]`.
    pub title: String,
    /// Value of the last colour, in the title's unit.
    pub full_scale: f64,
}

impl Legend {
    /// Legend of removed depth in millimetres, for a full scale [m].
    pub fn removed_depth(full_scale: f64) -> Self {
        Self { title: "removed depth [mm]".into(), full_scale: 1e3 * full_scale }
    }

    /// Draws the legend `width` pixels wide, with text of this `scale`.
    pub fn draw(&self, width: usize, scale: usize, paper: [u8; 3]) -> Picture {
        let labels: Vec<String> = (0..=INTERVALS).map(|i| tick_label(self.full_scale, i)).collect();
        let widest = labels.iter().map(|label| text_size(label, scale).0).max().unwrap_or(0);
        let line = text_size("", scale).1;
        let (left, bar_height) = (widest / 2 + scale, 7 * scale);
        let span = width.saturating_sub(2 * left + 1).max(INTERVALS);
        let bar_top = line + 2 * scale;
        let tick_top = bar_top + bar_height;
        let mut picture = Picture::filled(width, tick_top + 5 * scale + line, paper);
        let title_left = width.saturating_sub(text_size(&self.title, scale).0) / 2;
        draw_text(&mut picture, &self.title, (title_left, 0), scale, INK);
        picture.fill((left.saturating_sub(scale), bar_top - scale), (span + 2 * scale, bar_height + 2 * scale), INK);
        for column in 0..span {
            let colour = to_srgb8(colour_map((column as f32 + 0.5) / span as f32));
            picture.fill((left + column, bar_top), (1, bar_height), colour);
        }
        for (i, label) in labels.iter().enumerate() {
            let x = left + span * i / INTERVALS;
            picture.fill((x.saturating_sub(scale / 2), tick_top), (scale.max(1), 3 * scale), INK);
            let label_left = x.saturating_sub(text_size(label, scale).0 / 2);
            draw_text(&mut picture, label, (label_left, tick_top + 4 * scale), scale, INK);
        }
        picture
    }
}

/// Label of a tick, with only the digits that distinguish neighbouring ticks.
fn tick_label(full_scale: f64, tick: usize) -> String {
    let value = full_scale * tick as f64 / INTERVALS as f64;
    if tick == 0 {
        return "0".into();
    }
    let step = full_scale / INTERVALS as f64;
    // One digit for the step, and one more for quarters such as 0.25 and 0.75.
    let decimals = (1.0 - step.log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tick_labels_are_exact_and_short() {
        let labels = |full: f64| (0..=4).map(|i| tick_label(full, i)).collect::<Vec<_>>().join(" ");
        assert_eq!(labels(0.3), "0 0.075 0.15 0.225 0.3");
        assert_eq!(labels(1.0), "0 0.25 0.5 0.75 1");
        assert_eq!(labels(0.02), "0 0.005 0.01 0.015 0.02");
        assert_eq!(labels(8.0), "0 2 4 6 8");
        assert_eq!(labels(200.0), "0 50 100 150 200");
    }

    #[test]
    fn the_bar_runs_from_the_first_to_the_last_colour() {
        let picture = Legend::removed_depth(0.0005).draw(300, 2, [255; 3]);
        let row = 3 * picture.width * (text_size("", 2).1 + 8);
        let pixels: Vec<[u8; 3]> = picture.rgb[row..row + 900]
            .chunks(3)
            .map(|p| [p[0], p[1], p[2]])
            .filter(|p| *p != [255; 3] && *p != INK)
            .collect();
        let near = |a: [u8; 3], b: [u8; 3]| (0..3).all(|i| a[i].abs_diff(b[i]) < 4);
        assert!(near(pixels[0], to_srgb8(colour_map(0.0))));
        assert!(near(pixels[pixels.len() - 1], to_srgb8(colour_map(1.0))));
    }
}
