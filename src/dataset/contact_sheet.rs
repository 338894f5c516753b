//! Contact sheet: random items, and those with the least exposure and the sharpest turns.

use anyhow::{Context, Result};
use render::{Panel, Picture, contact_sheet};

use super::Dataset;
use super::row::RowFigures;
use crate::asset::PREVIEW_FILE;
use crate::picture::{stacked, to_png};
use crate::store::number_from;

/// Number of pictures in a row.
const COLUMNS: usize = 6;
/// Number of rows with random items.
const RANDOM_ROWS: usize = 3;

/// Draws the contact sheet as PNG from the items' own pictures.
///
/// # Errors
/// If a picture cannot be read.
pub(super) fn draw(dataset: &Dataset, items: &[RowFigures]) -> Result<Vec<u8>> {
    let mut drawn: Vec<&RowFigures> = items.iter().collect();
    drawn.sort_by_key(|item| number_from(&format!("contact sheet {}", item.row.id)));
    let mut strips = Vec::new();
    for (place, chunk) in drawn.chunks(COLUMNS).take(RANDOM_ROWS).enumerate() {
        let title = if place == 0 { format!("at random, of {} items", items.len()) } else { String::new() };
        strips.push(strip(dataset, &title, chunk, |item| item.row.difficulty.name().to_owned())?);
    }
    let mut hidden: Vec<&RowFigures> = items.iter().collect();
    hidden.sort_by(|a, b| a.exposure.total_cmp(&b.exposure).then_with(|| a.row.id.cmp(&b.row.id)));
    hidden.truncate(COLUMNS);
    strips.push(strip(dataset, "least exposed", &hidden, |item| format!("exposure {:.2}", item.exposure))?);
    let mut bent: Vec<&RowFigures> = items.iter().collect();
    bent.sort_by(|a, b| b.turn.total_cmp(&a.turn).then_with(|| a.row.id.cmp(&b.row.id)));
    bent.truncate(COLUMNS);
    strips.push(strip(dataset, "sharpest turn over a bead width", &bent, |item| format!("{:.2} rad", item.turn))?);
    to_png(&stacked(&strips))
}

/// Draws a title above pictures side by side.
fn strip(
    dataset: &Dataset,
    title: &str,
    items: &[&RowFigures],
    words: impl Fn(&RowFigures) -> String,
) -> Result<Picture> {
    let panel = |item: &&RowFigures| -> Result<Panel> {
        let path = dataset.asset_folder(&item.row.id).join(PREVIEW_FILE);
        let image = image::open(&path).with_context(|| format!("{}: not a picture", path.display()))?.into_rgb8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let picture = Picture { width, height, rgb: image.into_raw() };
        Ok(Panel { caption: format!("{}  {}", item.row.id, words(item)), picture, legend: None })
    };
    Ok(contact_sheet(title, &items.iter().map(panel).collect::<Result<Vec<_>>>()?))
}
