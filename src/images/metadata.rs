//! `metadata.jsonl` of a split: one line for each image, as the image folders of Hugging Face take it.

use serde::Serialize;

use super::plan::{Split, Treatment};
use super::record::{ImageRecord, file_name, label_path};
use super::view::view_paths;
use super::{APPEARANCE_FOLDER, DOSE_FOLDER};

/// A line. Paths other than `file_name` are relative to the set.
#[derive(Serialize)]
pub(super) struct MetadataLine<'a> {
    /// Path of the image relative to the file.
    file_name: String,
    id: &'a str,
    number: u64,
    split: Split,
    workpiece: &'a str,
    placement: u32,
    treatment: Treatment,
    exposed_share: f64,
    agreement: Option<f64>,
    appearance_pixels: [u64; 4],
    dose_pixels: [u64; 4],
    /// Index labels by appearance and by dose.
    appearance: String,
    dose: String,
    /// Camera, pose and boxes; instance labels; depth; the whole workpiece as if nothing hid it.
    view: String,
    instances: String,
    depth: String,
    amodal: String,
    /// The scene in JSON, as a text: its parts differ from image to image, and readers want equal columns.
    scene: String,
}

impl<'a> MetadataLine<'a> {
    /// The line of an image in a view. Errors: never, a scene is plain data.
    pub(super) fn of(record: &'a ImageRecord, view: &str) -> serde_json::Result<Self> {
        let [view, instances, depth, amodal] = view_paths(view);
        Ok(Self {
            file_name: file_name(&record.id),
            id: &record.id,
            number: record.number,
            split: record.split,
            workpiece: &record.workpiece,
            placement: record.placement,
            treatment: record.treatment,
            exposed_share: record.exposed_share,
            agreement: record.agreement,
            appearance_pixels: record.appearance_pixels,
            dose_pixels: record.dose_pixels,
            appearance: label_path(APPEARANCE_FOLDER, &record.id),
            dose: label_path(DOSE_FOLDER, &record.id),
            view,
            instances,
            depth,
            amodal,
            scene: serde_json::to_string(&record.scene)?,
        })
    }
}
