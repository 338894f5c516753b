//! Annotations in COCO's format (Lin et al. 2014): a mask for each class of each image, empty ones included.

use serde::Serialize;

use crate::rle::{Extent, Rle};

/// A class of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Category {
    /// Value of its pixels.
    pub id: u8,
    /// Its name.
    pub name: &'static str,
    /// Name of the group of classes to which it belongs.
    pub supercategory: &'static str,
}

/// An image that is annotated.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Image {
    /// Its number, from 1.
    pub id: u64,
    /// Its file, relative to the data set.
    pub file_name: String,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
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

#[derive(Serialize)]
struct File<'a> {
    info: Info<'a>,
    images: &'a [Image],
    annotations: &'a [Annotation],
    categories: &'a [Category],
}

#[derive(Serialize)]
struct Info<'a> {
    description: &'a str,
    version: &'a str,
}

/// Makes the annotations of an image from its labels, row by row from the top left; their numbers follow from the
/// image's.
pub fn annotations(image: &Image, labels: &[u8], categories: &[Category]) -> Vec<Annotation> {
    let of = |(place, category): (usize, &Category)| {
        let mask = |pixel: usize| labels[pixel] == category.id;
        let extent = Extent::of(image.width, image.height, mask);
        Annotation {
            id: (image.id - 1) * categories.len() as u64 + place as u64 + 1,
            image_id: image.id,
            category_id: category.id,
            segmentation: Rle::of(image.width, image.height, mask),
            area: extent.area,
            bbox: extent.bounds,
            iscrowd: 0,
        }
    };
    categories.iter().enumerate().map(of).collect()
}

/// Writes a file of images and their annotations.
///
/// # Errors
/// Never: the annotations are plain data.
pub fn write(
    description: &str,
    images: &[Image],
    annotations: &[Annotation],
    categories: &[Category],
) -> Result<Vec<u8>, serde_json::Error> {
    let info = Info { description, version: env!("CARGO_PKG_VERSION") };
    Ok((serde_json::to_string(&File { info, images, annotations, categories })? + "\n").into_bytes())
}
