//! Labelled images of coated workpieces during sanding, for perception.
//!
//! ```text
//! dataset.json                       recipe of every image
//! fields/bracket/                    a workpiece: its field, and the region that the pad can reach
//! fields/bracket-spiral/             a simulated path of the pad: the dose after each stage
//! images/bracket-p03-spiral-s2.png   the image
//! appearance/...png, dose/...png     its index labels, from appearance and from dose
//! records/...json                    its record; written last, so an image with a record is complete
//! failures/...json                   items that could not be made, with the reason
//! annotations/*.json, metadata.jsonl, failures.jsonl, README.md, contact-sheet.png
//! ```
//!
//! [`plan`] names the images of a [`recipe`], and `order` selects those within a limit. [`workpiece`] makes the field
//! of each workpiece, [`patch`] finds the region that a pad can reach, and [`pattern`] the paths on it. [`sanding`]
//! simulates them. [`scene`] draws light, material and camera at random, [`shot`] renders, [`render::label`] compares,
//! [`record`] stores. [`make`] makes each item, in a process of its own that [`crate::store`] starts. `catalogue`
//! describes the set, and [`check`] compares the set with it.

mod card;
mod catalogue;
pub mod check;
mod contact_sheet;
pub mod make;
mod order;
pub mod plan;
pub mod recipe;
pub mod record;
pub mod sanding;
pub mod scene;
pub mod shot;
pub mod workpiece;

use crate::store::{FAILURES_FOLDER, Store};

pub use recipe::{IMAGES_FORMAT, ImageRecipe};

/// Folder of a set of images.
pub type ImageSet = Store<ImageRecipe>;

/// Folder of the records; claims on images are made here.
pub const RECORDS_FOLDER: &str = "records";
/// Folder of the images.
pub const IMAGES_FOLDER: &str = "images";
/// Folder of the labels from appearance.
pub const APPEARANCE_FOLDER: &str = "appearance";
/// Folder of the labels from dose.
pub const DOSE_FOLDER: &str = "dose";
/// Folder of workpieces and simulations.
pub const FIELDS_FOLDER: &str = "fields";
/// Folder of the COCO files.
pub const ANNOTATIONS_FOLDER: &str = "annotations";

/// Folders of a set.
const FOLDERS: [&str; 6] =
    [RECORDS_FOLDER, IMAGES_FOLDER, APPEARANCE_FOLDER, DOSE_FOLDER, FIELDS_FOLDER, FAILURES_FOLDER];
