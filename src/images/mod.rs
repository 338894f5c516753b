//! Labelled images of coated workpieces in the course of sanding, for perception.
//!
//! ```text
//! dataset.json                       what decides every image
//! fields/bracket/                    a workpiece: field, and where the pad can go
//! fields/bracket-spiral/             a way of the pad, simulated: the dose after each stage
//! images/bracket-p03-spiral-s2.png   the image
//! appearance/...png, dose/...png     its index labels, from what is seen and from the dose
//! records/...json                    how it was made; written last, so an image with a record is whole
//! failures/...json                   what could not be made, and why
//! annotations/*.json, metadata.jsonl, failures.jsonl, README.md, contact-sheet.png
//! ```
//!
//! The road: [`plan`] names the images of a [`recipe`], `order` says which of them a limit takes; [`workpiece`] gives each workpiece its field, [`patch`] finds
//! where a pad can go and [`pattern`] which ways; [`sanding`] simulates them; [`scene`] draws light, material and
//! camera, [`shot`] renders, [`render::label`] compares; [`record`] keeps; [`make`] makes each thing, in a
//! process of its own that [`crate::store`] starts. `catalogue` describes what is there, and [`check`] holds it against
//! itself.

mod card;
mod catalogue;
pub mod check;
pub mod coco;
pub mod make;
mod order;
pub mod plan;
pub mod recipe;
pub mod record;
pub mod sanding;
pub mod scene;
mod sheet;
pub mod shot;
pub mod workpiece;

use crate::store::{FAILURES_FOLDER, Store};

pub use recipe::{IMAGES_FORMAT, ImageRecipe};

/// The folder of a set of images.
pub type ImageSet = Store<ImageRecipe>;

/// Folder of the records, in which images are claimed.
pub const RECORDS_FOLDER: &str = "records";
/// Folder of the images.
pub const IMAGES_FOLDER: &str = "images";
/// Folder of the labels by what is seen.
pub const APPEARANCE_FOLDER: &str = "appearance";
/// Folder of the labels by the dose.
pub const DOSE_FOLDER: &str = "dose";
/// Folder of workpieces and simulations.
pub const FIELDS_FOLDER: &str = "fields";
/// Folder of the COCO files.
pub const ANNOTATIONS_FOLDER: &str = "annotations";

/// Folders of a set.
const FOLDERS: [&str; 6] =
    [RECORDS_FOLDER, IMAGES_FOLDER, APPEARANCE_FOLDER, DOSE_FOLDER, FIELDS_FOLDER, FAILURES_FOLDER];
