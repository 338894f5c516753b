//! Annotations in COCO's format (Lin et al. 2014): a mask for each class of each image, empty ones included.

use anyhow::Result;
use export::rle::{Extent, Rle};
use serde::Serialize;

use super::IMAGES_FOLDER;
use super::record::{ImageRecord, file_path};
use render::label::{SANDED, UNSANDED};

/// Numbers and names of the classes.
pub const CATEGORIES: [(u8, &str); 2] = [(SANDED, "sanded"), (UNSANDED, "unsanded")];

#[derive(Serialize)]
struct File<'a> {
    info: Info<'a>,
    images: Vec<Image>,
    annotations: &'a [Annotation],
    categories: Vec<Category>,
}

#[derive(Serialize)]
struct Info<'a> {
    description: &'a str,
    version: &'a str,
}

#[derive(Serialize)]
struct Image {
    id: u64,
    file_name: String,
    width: usize,
    height: usize,
}

#[derive(Serialize)]
struct Category {
    id: u8,
    name: &'static str,
    supercategory: &'static str,
}

/// Mask of one class in one image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Annotation {
    id: u64,
    image_id: u64,
    category_id: u8,
    segmentation: Rle,
    area: u64,
    bbox: [usize; 4],
    iscrowd: u8,
}

/// Makes the annotations of an image from its labels; their numbers follow from the image's.
pub fn annotations(image: u64, (width, height): (usize, usize), labels: &[u8]) -> Vec<Annotation> {
    let of = |(place, (class, _)): (usize, (u8, &str))| {
        let mask = |pixel: usize| labels[pixel] == class;
        let extent = Extent::of(width, height, mask);
        Annotation {
            id: (image - 1) * CATEGORIES.len() as u64 + place as u64 + 1,
            image_id: image,
            category_id: class,
            segmentation: Rle::of(width, height, mask),
            area: extent.area,
            bbox: extent.bounds,
            iscrowd: 0,
        }
    };
    CATEGORIES.into_iter().enumerate().map(of).collect()
}

/// Writes a file of images and their annotations.
///
/// # Errors
/// Never: the annotations are plain data.
pub fn write(
    description: &str,
    (width, height): (usize, usize),
    records: &[&ImageRecord],
    annotations: &[Annotation],
) -> Result<Vec<u8>> {
    let image = |record: &&ImageRecord| Image {
        id: record.number,
        file_name: file_path(IMAGES_FOLDER, &record.id),
        width,
        height,
    };
    let category = |(id, name): (u8, &'static str)| Category { id, name, supercategory: "coating" };
    let file = File {
        info: Info { description, version: env!("CARGO_PKG_VERSION") },
        images: records.iter().map(image).collect(),
        annotations,
        categories: CATEGORIES.map(category).into(),
    };
    Ok((serde_json::to_string(&file)? + "\n").into_bytes())
}
