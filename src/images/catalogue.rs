//! Files that describe a set of images; all follow from the marker, the records, the labels and the failures.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use rayon::prelude::*;

use super::plan::{Planned, Split};
use super::record::{ImageRecord, file_path};
use super::{APPEARANCE_FOLDER, DOSE_FOLDER, IMAGES_FOLDER, ImageRecipe, ImageSet, card, check, contact_sheet};
use crate::store::catalogue::{CARD_FILE, CONTACT_FILE, Catalogue, Described, FAILURES_FILE, lines};
use export::coco::{self, Annotation, Category, Image};
use render::label::{SANDED, UNSANDED};

/// Name of the file with one line of JSON for each image.
pub const METADATA_FILE: &str = "metadata.jsonl";

/// Classes of the labels.
const CATEGORIES: [Category; 2] = [
    Category { id: SANDED, name: "sanded", supercategory: "coating" },
    Category { id: UNSANDED, name: "unsanded", supercategory: "coating" },
];

/// COCO files of each kind of label, one for each split in the order of [`Split::ALL`].
const ANNOTATIONS: [(&str, [&str; 3]); 2] = [
    (
        APPEARANCE_FOLDER,
        [
            "annotations/appearance-train.json",
            "annotations/appearance-validation.json",
            "annotations/appearance-test.json",
        ],
    ),
    (DOSE_FOLDER, ["annotations/dose-train.json", "annotations/dose-validation.json", "annotations/dose-test.json"]),
];

impl Described for ImageRecipe {
    const ITEMS: &'static str = "images";

    fn describe(set: &ImageSet) -> Result<Catalogue> {
        let there: Vec<Planned> = set.recipe.images().into_iter().filter(|image| set.holds_image(image)).collect();
        let records = there.iter().map(|image| set.read_record(&image.id)).collect::<Result<Vec<ImageRecord>>>()?;
        let failures = set.failures()?;
        let mut files = BTreeMap::from([
            (METADATA_FILE, lines(records.iter())?),
            (FAILURES_FILE, lines(failures.iter())?),
            (CARD_FILE, card::write(&set.recipe, &records, &failures).into_bytes()),
            (CONTACT_FILE, contact_sheet::draw(set, &records)?),
        ]);
        for (folder, names) in ANNOTATIONS {
            for (split, name) in Split::ALL.into_iter().zip(names) {
                files.insert(name, annotations(set, (folder, split), &records)?);
            }
        }
        Ok(Catalogue { files, items: records.len() })
    }

    fn contradictions(set: &ImageSet) -> Result<Vec<String>> {
        check::contradictions(set)
    }
}

/// Writes the COCO file of one kind of label in one split.
fn annotations(set: &ImageSet, (folder, split): (&str, Split), records: &[ImageRecord]) -> Result<Vec<u8>> {
    let (width, height) = set.recipe.size;
    let of = |record: &&ImageRecord| -> Result<(Image, Vec<Annotation>)> {
        let file_name = file_path(IMAGES_FOLDER, &record.id);
        let image = Image { id: record.number, file_name, width, height };
        let annotations = coco::annotations(&image, &set.read_labels(folder, &record.id)?, &CATEGORIES);
        Ok((image, annotations))
    };
    let records: Vec<&ImageRecord> = records.iter().filter(|record| record.split == split).collect();
    let annotated = records.par_iter().map(of).collect::<Result<Vec<_>>>()?;
    let (images, annotations): (Vec<Image>, Vec<Vec<Annotation>>) = annotated.into_iter().unzip();
    let description = format!("RoboFin, labels by {folder}, {}", split.name());
    Ok(coco::write(&description, &images, &annotations.concat(), &CATEGORIES)?)
}

impl ImageSet {
    /// Reads the labels of an image, row by row from the top left.
    ///
    /// # Errors
    /// If the file is missing, does not have one channel, or has another size.
    pub fn read_labels(&self, folder: &str, id: &str) -> Result<Vec<u8>> {
        let path = self.folder().join(file_path(folder, id));
        let image = image::open(&path).with_context(|| format!("{}: not a picture", path.display()))?;
        let (width, height) = self.recipe.size;
        let found = (image.width() as usize, image.height() as usize);
        ensure!(found == (width, height), "{}: {found:?} pixels, {width} x {height} are expected", path.display());
        let grey =
            image.as_luma8().with_context(|| format!("{}: one channel of eight bits is expected", path.display()))?;
        Ok(grey.as_raw().clone())
    }
}
