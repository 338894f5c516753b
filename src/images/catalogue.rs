//! Files that describe a set of images; all follow from the marker, the records, the labels and the failures.

use std::collections::BTreeMap;

use anyhow::{Context, Result, ensure};
use rayon::prelude::*;

use perception::coco::{self, Annotation, CocoImage, Heading};

use super::metadata::MetadataLine;
use super::plan::{Planned, Split};
use super::record::{ImageRecord, file_name, label_path};
use super::view::view_paths;
use super::{APPEARANCE_FOLDER, DOSE_FOLDER, ImageRecipe, ImageSet, card, check, contact_sheet};
use crate::store::catalogue::{CARD_FILE, CONTACT_FILE, Catalogue, Described, FAILURES_FILE, lines};

/// Files of each split, in the order of [`Split::ALL`]: lines, COCO by appearance, COCO by dose.
pub(super) const SPLIT_FILES: [[&str; 3]; 3] = [
    ["train/metadata.jsonl", "train/appearance.json", "train/dose.json"],
    ["validation/metadata.jsonl", "validation/appearance.json", "validation/dose.json"],
    ["test/metadata.jsonl", "test/appearance.json", "test/dose.json"],
];

impl Described for ImageRecipe {
    const ITEMS: &'static str = "images";

    fn describe(set: &ImageSet) -> Result<Catalogue> {
        let there: Vec<Planned> = set.recipe.images().into_iter().filter(|image| set.holds_image(image)).collect();
        let records = there.iter().map(|image| set.read_record(&image.id)).collect::<Result<Vec<ImageRecord>>>()?;
        let failures = set.failures()?;
        let mut files = BTreeMap::from([
            (FAILURES_FILE, lines(failures.iter())?),
            (CARD_FILE, card::write(&set.recipe, &records, &failures).into_bytes()),
            (CONTACT_FILE, contact_sheet::draw(set, &records)?),
        ]);
        for (split, [metadata, appearance, dose]) in Split::ALL.into_iter().zip(SPLIT_FILES) {
            let of_split = |(planned, record): &(Planned, ImageRecord)| planned.split == split && record.split == split;
            let pairs: Vec<(Planned, ImageRecord)> =
                there.iter().cloned().zip(records.iter().cloned()).filter(of_split).collect();
            // A split without images has no files: readers refuse empty ones.
            if pairs.is_empty() {
                continue;
            }
            let view = |planned: &Planned| set.recipe.view_of(planned);
            let of: Vec<MetadataLine<'_>> = pairs
                .iter()
                .map(|(planned, record)| MetadataLine::of(record, &view(planned)))
                .collect::<Result<_, _>>()?;
            files.insert(metadata, lines(of.iter())?);
            files.insert(appearance, annotations(set, APPEARANCE_FOLDER, &pairs)?);
            files.insert(dose, annotations(set, DOSE_FOLDER, &pairs)?);
        }
        Ok(Catalogue { files, items: records.len() })
    }

    fn contradictions(set: &ImageSet) -> Result<Vec<String>> {
        check::contradictions(set)
    }
}

/// Writes the COCO file of one kind of label for images of one split.
fn annotations(set: &ImageSet, folder: &str, pairs: &[(Planned, ImageRecord)]) -> Result<Vec<u8>> {
    let size = set.recipe.size;
    let image = |record: &ImageRecord| CocoImage::new(record.number, file_name(&record.id), size);
    let of = |(planned, record): &(Planned, ImageRecord)| -> Result<Vec<Annotation>> {
        let labels = set.read_labels(&label_path(folder, &record.id))?;
        let [_, instances, ..] = view_paths(&set.recipe.view_of(planned));
        Ok(image(record).annotations(&labels, &set.read_labels(&instances)?))
    };
    let annotations = pairs.par_iter().map(of).collect::<Result<Vec<_>>>()?.concat();
    let images: Vec<CocoImage> = pairs.iter().map(|(_, record)| image(record)).collect();
    let heading = Heading {
        description: &format!("RoboFin, labels by {folder}"),
        version: &set.recipe.version,
        licence: card::licence(&set.recipe),
    };
    Ok(coco::write(&heading, &images, &annotations)?)
}

impl ImageSet {
    /// Reads index or instance labels at a path relative to the set, row by row from the top left.
    ///
    /// # Errors
    /// If the file is missing, does not have one channel, or has another size.
    pub fn read_labels(&self, path: &str) -> Result<Vec<u8>> {
        let path = self.folder().join(path);
        let image = image::open(&path).with_context(|| format!("{}: not a picture", path.display()))?;
        let (width, height) = self.recipe.size;
        let found = (image.width() as usize, image.height() as usize);
        ensure!(found == (width, height), "{}: {found:?} pixels, {width} x {height} are expected", path.display());
        let grey =
            image.as_luma8().with_context(|| format!("{}: one channel of eight bits is expected", path.display()))?;
        Ok(grey.as_raw().clone())
    }
}
