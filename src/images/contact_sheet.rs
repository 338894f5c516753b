//! Contact sheet: random images with their labels, and one pattern stage by stage.

use anyhow::{Context, Result};
use image::imageops::{FilterType, resize};
use render::{Panel, Picture, contact_sheet};

use super::plan::Treatment;
use super::record::{ImageRecord, image_path, label_path};
use super::{APPEARANCE_FOLDER, ImageSet};
use crate::picture::{stacked, to_png};
use crate::store::number_from;
use render::label::{SANDED, UNSANDED};

/// Number of images in a row.
const COLUMNS: usize = 6;
/// Number of rows with random images.
const RANDOM_ROWS: usize = 2;
/// Width of an image on the contact sheet [pixels].
const WIDTH: u32 = 320;
/// Colours of sanded, unsanded and ignored pixels.
const COLOURS: [[u8; 3]; 3] = [[230, 120, 20], [30, 110, 200], [250, 230, 60]];

/// Draws the contact sheet as PNG.
///
/// # Errors
/// If an image or a label cannot be read.
pub(super) fn draw(set: &ImageSet, records: &[ImageRecord]) -> Result<Vec<u8>> {
    let mut drawn: Vec<&ImageRecord> = records.iter().collect();
    drawn.sort_by_key(|record| number_from(&format!("contact sheet {}", record.id)));
    let mut strips = Vec::new();
    for (place, chunk) in drawn.chunks(COLUMNS).take(RANDOM_ROWS).enumerate() {
        let title = if place == 0 { format!("at random, of {} images", records.len()) } else { String::new() };
        strips.push(strip(&title, chunk, |record| picture(set, record))?);
        strips.push(strip("", chunk, |record| labelled(set, record))?);
    }
    let course = course(records, drawn.first().copied());
    strips.push(strip("stage by stage", &course, |record| picture(set, record))?);
    strips.push(strip("", &course, |record| labelled(set, record))?);
    to_png(&stacked(&strips))
}

/// Returns the unsanded image and the existing stages of one pattern, in the view of a record.
fn course<'a>(records: &'a [ImageRecord], of: Option<&ImageRecord>) -> Vec<&'a ImageRecord> {
    let Some(of) = of else { return Vec::new() };
    let view = || records.iter().filter(|r| r.workpiece == of.workpiece && r.placement == of.placement);
    let pattern = view().find_map(|record| match (record.treatment, of.treatment) {
        (_, Treatment::Stage { pattern, .. }) | (Treatment::Stage { pattern, .. }, _) => Some(pattern),
        _ => None,
    });
    let belongs = |record: &&ImageRecord| match record.treatment {
        Treatment::Unsanded => true,
        Treatment::Stage { pattern: own, .. } => Some(own) == pattern,
        Treatment::Bare => false,
    };
    view().filter(belongs).take(COLUMNS).collect()
}

fn strip(title: &str, records: &[&ImageRecord], draw: impl Fn(&ImageRecord) -> Result<Picture>) -> Result<Picture> {
    let panel = |record: &&ImageRecord| -> Result<Panel> {
        let caption = format!("{}  {:.0} %", record.id, 100.0 * record.exposed_share);
        Ok(Panel { caption, picture: draw(record)?, legend: None })
    };
    Ok(contact_sheet(title, &records.iter().map(panel).collect::<Result<Vec<_>>>()?))
}

fn picture(set: &ImageSet, record: &ImageRecord) -> Result<Picture> {
    let path = set.folder().join(image_path(record.split, &record.id));
    let image = image::open(&path).with_context(|| format!("{}: not a picture", path.display()))?.into_rgb8();
    let height = (image.height() * WIDTH).div_ceil(image.width().max(1)).max(1);
    let small = resize(&image, WIDTH, height, FilterType::Triangle);
    Ok(Picture { width: WIDTH as usize, height: height as usize, rgb: small.into_raw() })
}

/// Draws the image in grey, tinted with the colours of its labels.
fn labelled(set: &ImageSet, record: &ImageRecord) -> Result<Picture> {
    let mut picture = picture(set, record)?;
    let labels = set.read_labels(&label_path(APPEARANCE_FOLDER, &record.id))?;
    let (width, height) = set.recipe.size;
    for (pixel, rgb) in picture.rgb.chunks_exact_mut(3).enumerate() {
        let (x, y) = (pixel % picture.width, pixel / picture.width);
        let at = (y * height / picture.height) * width + x * width / picture.width;
        let grey = rgb.iter().map(|&code| u16::from(code)).sum::<u16>() / 3;
        let colour = match labels[at] {
            render::label::BACKGROUND => [grey as u8; 3],
            SANDED => COLOURS[0],
            UNSANDED => COLOURS[1],
            _ => COLOURS[2],
        };
        for (code, tint) in rgb.iter_mut().zip(colour) {
            *code = ((grey + u16::from(tint)) / 2) as u8;
        }
    }
    Ok(picture)
}
