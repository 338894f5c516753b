//! Labelled images of coated workpieces during sanding, for perception.
//!
//! ```text
//! dataset.json                         recipe of every image
//! fields/bracket.nvdb                  a workpiece
//! fields/bracket-spiral/               a simulated path of the pad: the dose after each stage
//! views/bracket-p03.json, ...          a placement: camera, pose, boxes, instance labels, depth, float buffers
//! train/images/bracket-p03-spiral-s2.png, train/labels/...txt   the image; YOLO's polygons
//! appearance/...png, dose/...png       its index labels, from appearance and from dose
//! records/...json                      its record; written last, so an image with a record is complete
//! failures/...json                     items that could not be made, with the reason
//! train/metadata.jsonl, train/appearance.json, train/dose.json  lines and COCO files of a split
//! failures.jsonl, README.md, contact-sheet.png
//! ```
//!
//! [`plan`] names the images of a [`recipe`], and `order` selects those within a limit. [`workpiece`] makes the field
//! of each workpiece, [`patch`](paths::PadPatch) finds the region that a pad can reach, and [`Pattern`](paths::Pattern)
//! the paths on it. [`sanding`] simulates them. [`perception`] draws scenes, photographs and labels; [`view`] and
//! [`record`] store. [`make`] makes each item, in a process of its own that [`crate::store`] starts. `catalogue`
//! describes the set, and [`check`] compares the set with it.

mod card;
mod catalogue;
pub mod check;
mod contact_sheet;
pub mod make;
mod metadata;
mod order;
pub mod plan;
pub mod recipe;
pub mod record;
pub mod sanding;
pub mod scene_files;
pub mod view;
pub mod workpiece;

use crate::store::{FAILURES_FOLDER, Store};

pub use recipe::{IMAGES_FORMAT, ImageRecipe};

/// Folder of a set of images.
pub type ImageSet = Store<ImageRecipe>;

/// Folder of the records; claims on images are made here.
pub const RECORDS_FOLDER: &str = "records";
/// Folder of the images in that of their split.
pub const IMAGES_FOLDER: &str = "images";
/// Folder of the labels of YOLO in that of their split.
pub const YOLO_FOLDER: &str = "labels";
/// Folder of the labels from appearance.
pub const APPEARANCE_FOLDER: &str = "appearance";
/// Folder of the labels from dose.
pub const DOSE_FOLDER: &str = "dose";
/// Folder of workpieces and simulations.
pub const FIELDS_FOLDER: &str = "fields";
/// Folder of views.
pub const VIEWS_FOLDER: &str = "views";

/// Folders of a set.
const FOLDERS: [&str; 12] = [
    RECORDS_FOLDER,
    APPEARANCE_FOLDER,
    DOSE_FOLDER,
    FIELDS_FOLDER,
    VIEWS_FOLDER,
    FAILURES_FOLDER,
    "train/images",
    "train/labels",
    "validation/images",
    "validation/labels",
    "test/images",
    "test/labels",
];
