//! Annotations in COCO's format (Lin et al. 2014): a mask for each class that an image shows, one for each weld.

use export::rle::{Extent, Rle};
use render::label::{BACKGROUND, SANDED, UNSANDED};
use serde::Serialize;

use crate::view::{TOOL_INSTANCE, WORKPIECE_INSTANCE};

/// Number of the class of the whole workpiece.
const WORKPIECE: u8 = 3;
/// Number of the class of welds.
const WELD: u8 = 4;
/// Number of the class of the tool.
const TOOL: u8 = 5;

/// Numbers, names and broader classes of the classes.
const CATEGORIES: [(u8, &str, &str); 5] = [
    (SANDED, "sanded", "coating"),
    (UNSANDED, "unsanded", "coating"),
    (WORKPIECE, "workpiece", "object"),
    (WELD, "weld", "object"),
    (TOOL, "tool", "object"),
];

/// An image of a file of annotations.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CocoImage {
    /// Number, from 1.
    pub id: u64,
    /// Path relative to the file of annotations.
    pub file_name: String,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Number of the licence.
    license: u8,
}

#[derive(Serialize)]
struct File<'a> {
    info: Info<'a>,
    licenses: [Licence<'a>; 1],
    images: &'a [CocoImage],
    annotations: Vec<Numbered<'a>>,
    categories: Vec<Category>,
}

#[derive(Serialize)]
struct Info<'a> {
    description: &'a str,
    version: &'a str,
}

#[derive(Serialize)]
struct Licence<'a> {
    id: u8,
    name: &'a str,
    url: &'a str,
}

#[derive(Serialize)]
struct Category {
    id: u8,
    name: &'static str,
    supercategory: &'static str,
}

#[derive(Serialize)]
struct Numbered<'a> {
    id: usize,
    #[serde(flatten)]
    annotation: &'a Annotation,
}

/// Mask of one class, or of one weld, in one image.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Annotation {
    image_id: u64,
    category_id: u8,
    segmentation: Rle,
    area: u64,
    bbox: [usize; 4],
    iscrowd: u8,
}

/// The `info` and `licenses` blocks of a COCO file.
pub struct Heading<'a> {
    /// Description of the images.
    pub description: &'a str,
    /// Version of the program.
    pub version: &'a str,
    /// SPDX expression of the licence, and its address.
    pub licence: (&'a str, &'a str),
}

impl CocoImage {
    /// An image of a number, at a path relative to the file of annotations.
    pub fn new(id: u64, file_name: String, (width, height): (usize, usize)) -> Self {
        Self { id, file_name, width, height, license: 1 }
    }

    /// Makes the annotations from the index labels and the instance labels of its pixels. What has no pixel has none.
    pub fn annotations(&self, labels: &[u8], instances: &[u8]) -> Vec<Annotation> {
        let last_weld = instances.iter().copied().filter(|&instance| instance != TOOL_INSTANCE).max().unwrap_or(0);
        let coating = [SANDED, UNSANDED].map(|class| self.annotation(class, |pixel| labels[pixel] == class));
        let workpiece = self.annotation(WORKPIECE, |pixel| labels[pixel] != BACKGROUND);
        let welds =
            (WORKPIECE_INSTANCE + 1..=last_weld).map(|weld| self.annotation(WELD, |pixel| instances[pixel] == weld));
        let tool = self.annotation(TOOL, |pixel| instances[pixel] == TOOL_INSTANCE);
        coating.into_iter().chain([workpiece]).chain(welds).chain([tool]).flatten().collect()
    }

    fn annotation(&self, category_id: u8, mask: impl Fn(usize) -> bool) -> Option<Annotation> {
        let Extent { area, bounds } = Extent::of(self.width, self.height, &mask);
        (area > 0).then(|| Annotation {
            image_id: self.id,
            category_id,
            segmentation: Rle::of(self.width, self.height, &mask),
            area,
            bbox: bounds,
            iscrowd: 0,
        })
    }
}

/// Writes a file of images and their annotations, which are numbered in their order.
///
/// # Errors
/// Never: the annotations are plain data.
pub fn write(
    heading: &Heading<'_>,
    images: &[CocoImage],
    annotations: &[Annotation],
) -> Result<Vec<u8>, serde_json::Error> {
    let category = |(id, name, supercategory): (u8, &'static str, &'static str)| Category { id, name, supercategory };
    let numbered = |(at, annotation): (usize, _)| Numbered { id: at + 1, annotation };
    let (name, url) = heading.licence;
    let file = File {
        info: Info { description: heading.description, version: heading.version },
        licenses: [Licence { id: 1, name, url }],
        images,
        annotations: annotations.iter().enumerate().map(numbered).collect(),
        categories: CATEGORIES.map(category).into(),
    };
    Ok((serde_json::to_string(&file)? + "\n").into_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_and_welds_have_their_pixels_and_nothing_is_empty() {
        let image = CocoImage::new(7, "images/a.png".to_owned(), (4, 2));
        let labels = [0, 2, 2, 255, 0, 2, 2, 0];
        let instances = [0, 1, 3, 1, 255, 1, 3, 255];
        let found = image.annotations(&labels, &instances);
        let areas: Vec<(u8, u64)> = found.iter().map(|a| (a.category_id, a.area)).collect();
        // No sanded pixel and no pixel of the first weld: no annotation of either.
        assert_eq!(areas, [(UNSANDED, 4), (WORKPIECE, 5), (WELD, 2), (TOOL, 2)]);
        assert_eq!(found[2].bbox, [2, 0, 1, 2]);
        let heading = Heading { description: "d", version: "v", licence: ("MIT", "https://spdx.org") };
        let text = String::from_utf8(write(&heading, &[image], &found).unwrap()).unwrap();
        assert!(text.contains("\"annotations\":[{\"id\":1,\"image_id\":7") && text.contains("\"license\":1"), "{text}");
    }
}
