//! Record of an image: how it was made, and what it shows.

use std::collections::BTreeMap;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use perception::{Scene, Shot, png8, yolo};
use serde::{Deserialize, Serialize};

use super::plan::{Planned, Split, Treatment};
use super::{APPEARANCE_FOLDER, DOSE_FOLDER, IMAGES_FOLDER, ImageSet, RECORDS_FOLDER, YOLO_FOLDER};
use crate::asset::FileRecord;
use crate::picture::to_png;
use crate::store::remove;
use files::folder::write_file;
use files::json_file::read_json;
use render::label::{agreement, counts};

/// `records/ID.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageRecord {
    /// Name.
    pub id: String,
    /// Number in the whole set, from 1.
    pub number: u64,
    /// Split.
    pub split: Split,
    /// Name of the workpiece.
    pub workpiece: String,
    /// Index of the placement, from 0.
    pub placement: u32,
    /// State of the coating.
    pub treatment: Treatment,
    /// Share of the workpiece's pixels with a dose of 1 or more.
    pub exposed_share: f64,
    /// Share of agreement, among the pixels known to both labels.
    pub agreement: Option<f64>,
    /// Number of pixels of each class by appearance: background, sanded, unsanded, ignored.
    pub appearance_pixels: [u64; 4],
    /// The same numbers by dose.
    pub dose_pixels: [u64; 4],
    /// Placement, camera, light, material, sensor, looks.
    pub scene: Scene,
    /// SHA-256 of the workpiece's field and of the dose.
    pub sources: BTreeMap<String, String>,
    /// Files of the image and its labels, by path.
    pub files: BTreeMap<String, FileRecord>,
}

/// Path of an image relative to the folder of its split.
pub fn file_name(id: &str) -> String {
    format!("{IMAGES_FOLDER}/{id}.png")
}

/// Path of an image relative to the set.
pub fn image_path(split: Split, id: &str) -> String {
    format!("{}/{}", split.name(), file_name(id))
}

/// Path of the index labels of an image relative to the set.
pub fn label_path(folder: &str, id: &str) -> String {
    format!("{folder}/{id}.png")
}

/// Paths of the files of an image relative to the set: image, labels by appearance and by dose, polygons.
fn paths(split: Split, id: &str) -> [String; 4] {
    [
        image_path(split, id),
        label_path(APPEARANCE_FOLDER, id),
        label_path(DOSE_FOLDER, id),
        format!("{}/{YOLO_FOLDER}/{id}.txt", split.name()),
    ]
}

impl ImageSet {
    fn record_path(&self, id: &str) -> PathBuf {
        self.folder().join(RECORDS_FOLDER).join(format!("{id}.json"))
    }

    /// Reads the record of an image.
    ///
    /// # Errors
    /// If it is missing or damaged.
    pub fn read_record(&self, id: &str) -> Result<ImageRecord> {
        let path = self.record_path(id);
        Ok(read_json(&path, "the record of an image")?)
    }

    /// Returns true if an image is complete: its record matches the plan, and its files have the listed lengths.
    ///
    /// Hashes are checked by [`super::check`].
    pub fn holds_image(&self, planned: &Planned) -> bool {
        let has_length = |(name, record): (&String, &FileRecord)| {
            std::fs::metadata(self.folder().join(name)).is_ok_and(|file| file.len() == record.bytes)
        };
        self.read_record(&planned.id).is_ok_and(|record| {
            record.fits(planned, &self.recipe.workpieces[planned.workpiece].name).is_ok()
                && record.files.iter().all(has_length)
        })
    }

    /// Writes an image, its labels, and last its record.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn write_image(
        &self,
        planned: &Planned,
        shot: &Shot,
        scene: Scene,
        sources: BTreeMap<String, String>,
    ) -> Result<()> {
        let size = self.recipe.size;
        let contents = [
            to_png(&shot.image)?,
            png8(size, &shot.appearance)?,
            png8(size, &shot.dose)?,
            yolo::regions(&shot.appearance, size).into_bytes(),
        ];
        let mut files = BTreeMap::new();
        for (name, bytes) in paths(planned.split, &planned.id).into_iter().zip(&contents) {
            write_file(&self.folder().join(&name), bytes)?;
            files.insert(name, FileRecord::of_bytes(bytes));
        }
        let record = ImageRecord {
            id: planned.id.clone(),
            number: planned.number,
            split: planned.split,
            workpiece: self.recipe.workpieces[planned.workpiece].name.clone(),
            placement: planned.placement,
            treatment: planned.treatment,
            exposed_share: shot.exposed_share,
            agreement: agreement(&shot.appearance, &shot.dose),
            appearance_pixels: counts(&shot.appearance),
            dose_pixels: counts(&shot.dose),
            scene,
            sources,
            files,
        };
        let text = serde_json::to_string(&record)? + "\n";
        Ok(write_file(&self.record_path(&planned.id), text.as_bytes())?)
    }

    /// Removes an image, its record first, so that an interrupted removal leaves no image that seems complete.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn remove_image(&self, planned: &Planned) -> Result<()> {
        let files = paths(planned.split, &planned.id).map(|path| self.folder().join(path));
        std::iter::once(self.record_path(&planned.id)).chain(files).try_for_each(|path| remove(&path))
    }
}

impl ImageRecord {
    /// Checks that this is the record of a planned image with its files.
    ///
    /// # Errors
    /// The difference, in words.
    pub fn fits(&self, planned: &Planned, workpiece: &str) -> Result<()> {
        let same = self.id == planned.id
            && self.number == planned.number
            && self.split == planned.split
            && self.workpiece == workpiece
            && self.placement == planned.placement
            && self.treatment == planned.treatment;
        ensure!(same, "its record is not that of {}", planned.id);
        let named = paths(planned.split, &planned.id);
        let missing = named.iter().find(|name| !self.files.contains_key(*name));
        ensure!(missing.is_none() && self.files.len() == named.len(), "its record names other files than its own");
        Ok(())
    }
}
