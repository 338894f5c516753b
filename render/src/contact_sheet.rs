//! Contact sheet: a title, panels side by side with captions, and legends below, in one picture.

use super::frame::Picture;
use super::legend::Legend;
use super::text::{draw_text, text_size};

const PAPER: [u8; 3] = [255, 255, 255];
const INK: [u8; 3] = [38, 44, 52];
const FAINT: [u8; 3] = [104, 112, 122];
const RULE: [u8; 3] = [208, 213, 219];
/// Border and gap between panels, times the scale of the text [pixels].
const GAP: usize = 7;
/// Panel height per scale of the text [pixels].
const PANEL_ROWS_PER_SCALE: usize = 320;

/// One picture of a contact sheet.
#[derive(Clone, Debug)]
pub struct Panel {
    /// A few words above the picture.
    pub caption: String,
    /// The picture.
    pub picture: Picture,
    /// A colour bar below the picture.
    pub legend: Option<Legend>,
}

/// Arranges panels side by side under a title, at their own size; text grows with the panels.
///
/// `title`: one line at the top left, clipped at the right border; empty for none.
pub fn contact_sheet(title: &str, panels: &[Panel]) -> Picture {
    let tallest = panels.iter().map(|panel| panel.picture.height).max().unwrap_or(0);
    let scale = (tallest as f64 / PANEL_ROWS_PER_SCALE as f64).round().max(1.0) as usize;
    let gap = GAP * scale;
    let line = text_size("", scale).1;
    let legends: Vec<Option<Picture>> = panels
        .iter()
        .map(|panel| panel.legend.as_ref().map(|legend| legend.draw(panel.picture.width, scale, PAPER)))
        .collect();
    let legend_height = legends.iter().flatten().map(|legend| legend.height + gap).max().unwrap_or(0);
    let title_height = if title.is_empty() { 0 } else { text_size("", 2 * scale).1 + gap };
    let captions_top = gap + title_height;
    let panels_top = captions_top + line + gap / 2;
    let width = panels.iter().map(|panel| panel.picture.width + gap).sum::<usize>() + gap;
    let mut sheet = Picture::filled(width, panels_top + tallest + gap + legend_height, PAPER);
    draw_text(&mut sheet, title, (gap, gap), 2 * scale, INK);
    let mut left = gap;
    for (panel, legend) in panels.iter().zip(&legends) {
        draw_text(&mut sheet, &panel.caption, (left, captions_top), scale, FAINT);
        let size = (panel.picture.width + 2, panel.picture.height + 2);
        sheet.fill((left - 1, panels_top - 1), size, RULE);
        sheet.paste((left, panels_top), &panel.picture);
        if let Some(legend) = legend {
            sheet.paste((left, panels_top + tallest + gap), legend);
        }
        left += panel.picture.width + gap;
    }
    sheet
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sheet_holds_its_panels_unchanged_and_its_legend_below() {
        let panel = |colour: [u8; 3], legend: Option<Legend>| Panel {
            caption: "before".into(),
            picture: Picture::filled(160, 120, colour),
            legend,
        };
        let plain = contact_sheet("Part", &[panel([9, 8, 7], None), panel([1, 2, 3], None)]);
        for colour in [[9, 8, 7], [1, 2, 3]] {
            assert_eq!(plain.rgb.chunks(3).filter(|pixel| *pixel == colour).count(), 160 * 120);
        }
        assert_eq!(plain.rgb.len(), 3 * plain.width * plain.height);
        let with_legend = contact_sheet("Part", &[panel([9, 8, 7], Some(Legend::removed_depth(0.001)))]);
        assert!(with_legend.height > plain.height + 20);
        assert_eq!(contact_sheet("", &[]).rgb.len() % 3, 0);
    }
}
