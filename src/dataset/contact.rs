//! A contact sheet: pieces by chance, and those that are hardest to reach and to follow.

use anyhow::{Context, Result};
use render::{Panel, Picture, contact_sheet};

use super::Dataset;
use super::plan::number_from;
use super::row::Seen;
use crate::asset::PREVIEW_FILE;
use crate::picture::to_png;

/// Pictures in a row.
const COLUMNS: usize = 6;
/// Rows of pieces by chance.
const CHANCE_ROWS: usize = 3;

/// Draws the sheet as PNG from the pieces' own pictures.
///
/// # Errors
/// When a picture cannot be read.
pub(super) fn draw(dataset: &Dataset, pieces: &[Seen]) -> Result<Vec<u8>> {
    let mut by_chance: Vec<&Seen> = pieces.iter().collect();
    by_chance.sort_by_key(|piece| number_from(&format!("contact sheet {}", piece.row.id)));
    let mut strips = Vec::new();
    for (place, chunk) in by_chance.chunks(COLUMNS).take(CHANCE_ROWS).enumerate() {
        let title = if place == 0 { format!("by chance, of {} pieces", pieces.len()) } else { String::new() };
        strips.push(strip(dataset, &title, chunk, |piece| piece.row.difficulty.name().to_owned())?);
    }
    let mut hidden: Vec<&Seen> = pieces.iter().collect();
    hidden.sort_by(|a, b| a.exposure.total_cmp(&b.exposure).then_with(|| a.row.id.cmp(&b.row.id)));
    hidden.truncate(COLUMNS);
    strips.push(strip(dataset, "least exposed", &hidden, |piece| format!("exposure {:.2}", piece.exposure))?);
    let mut bent: Vec<&Seen> = pieces.iter().collect();
    bent.sort_by(|a, b| b.turn.total_cmp(&a.turn).then_with(|| a.row.id.cmp(&b.row.id)));
    bent.truncate(COLUMNS);
    strips.push(strip(dataset, "sharpest turn over a bead width", &bent, |piece| format!("{:.2} rad", piece.turn))?);
    to_png(&stacked(&strips))
}

/// A title above pictures side by side.
fn strip(dataset: &Dataset, title: &str, pieces: &[&Seen], words: impl Fn(&Seen) -> String) -> Result<Picture> {
    let panel = |piece: &&Seen| -> Result<Panel> {
        let path = dataset.asset_folder(&piece.row.id).join(PREVIEW_FILE);
        let image = image::open(&path).with_context(|| format!("{}: not a picture", path.display()))?.into_rgb8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let picture = Picture { width, height, rgb: image.into_raw() };
        Ok(Panel { caption: format!("{}  {}", piece.row.id, words(piece)), picture, legend: None })
    };
    Ok(contact_sheet(title, &pieces.iter().map(panel).collect::<Result<Vec<_>>>()?))
}

/// Pictures one below the other, on white.
pub(crate) fn stacked(strips: &[Picture]) -> Picture {
    let width = strips.iter().map(|strip| strip.width).max().unwrap_or(1);
    let mut sheet = Picture::filled(width, strips.iter().map(|strip| strip.height).sum(), [255; 3]);
    let mut top = 0;
    for strip in strips {
        sheet.paste((0, top), strip);
        top += strip.height;
    }
    sheet
}
