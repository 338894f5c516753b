//! README of a set of images: contents, method and failures.

use std::collections::BTreeSet;
use std::fmt::Write;

use super::ImageRecipe;
use super::plan::{Split, Treatment};
use super::record::ImageRecord;
use super::workpiece::{Coated, Origin};
use crate::store::Failure;
use render::label::{LEAST_CONTRAST, SANDED_FROM, UNSANDED_TO};

/// Writes the README in Markdown.
pub(super) fn write(recipe: &ImageRecipe, records: &[ImageRecord], failures: &[Failure]) -> String {
    let planned = recipe.images().len();
    let names: Vec<&str> = recipe.workpieces.iter().map(|coated| coated.name.as_str()).collect();
    let mut text = front_matter(recipe, records);
    let _ = write!(
        text,
        "# Coated workpieces in the course of sanding\n\n{} of {planned} images of {}, {} failures. Made by RoboFin {} with seed {}.\n\n\
         Each image is {} x {} pixels, rendered from a distance field whose coating was sanded in simulation, with two index \
         labels of the same size.\n\n![some images](contact-sheet.png)\n",
        records.len(),
        names.join(" and "),
        failures.len(),
        recipe.version,
        recipe.seed,
        recipe.size.0,
        recipe.size.1
    );
    text += "\n## Files\n\n| file | holds |\n|---|---|\n";
    for (file, holds) in [
        ("`train/`, `validation/`, `test/`", "the splits"),
        ("`train/images/ID.png`", "the image, eight-bit sRGB"),
        ("`train/metadata.jsonl`", "one line for each image: state, scene, and where its labels are"),
        ("`train/appearance.json`, `dose.json`", "COCO: masks of sanded and unsanded coating, workpiece, welds, tool"),
        ("`train/labels/ID.txt`", "YOLO segmentation, by appearance: 0 sanded, 1 unsanded"),
        ("`appearance/ID.png`", "labels by what is seen: 0 background, 1 sanded, 2 unsanded, 255 ignore"),
        ("`dose/ID.png`", "labels by the dose, the same values"),
        ("`views/VIEW.json`", "of a placement: camera matrix, distortion, pose, boxes in 2D and 3D, welds, tool"),
        ("`views/VIEW-instances.png`", "0 background, 1 base metal, 1 + i weld i, 255 tool"),
        ("`views/VIEW-amodal.png`", "1 where the workpiece is, as if nothing hid it"),
        ("`views/VIEW-depth.png`", "depth along the camera's axis in steps of 0.1 mm, 0 background"),
        ("`views/VIEW.exr`", "float buffers: depth, normal, position, weld id"),
        ("`records/ID.json`", "an image: how it was made, hashes of its files"),
        ("`fields/`", "the workpieces, and the dose after each stage, as NanoVDB"),
        ("`failures.jsonl`", "what could not be made: reason, and the command line that shows it again"),
        ("`dataset.json`", "what decides every image"),
    ] {
        let _ = writeln!(text, "| {file} | {holds} |");
    }
    text += &contents(recipe, records);
    text += &labels();
    let _ = writeln!(
        text,
        "\n## Making\n\n`robofin dataset images {}`. The same flags give the same bytes. `robofin validate DIR` rehashes and rechecks \
         everything, with `--repair` it makes what is broken again.\n\n## Licence\n\n{}. Cite as: RoboFin {}, labelled images of \
         sanding, seed {}.",
        recipe.flags().join(" "),
        licence(recipe).0,
        recipe.version,
        recipe.seed
    );
    for failure in failures {
        let _ = writeln!(text, "\nNot made: `{}`, {}: {}", failure.id, failure.stage.name(), failure.reason);
    }
    text
}

/// SPDX expression of the licence, and its address.
pub(super) fn licence(recipe: &ImageRecipe) -> (&'static str, &'static str) {
    let is_asset = |coated: &Coated| matches!(coated.origin, Origin::Asset { .. });
    if recipe.workpieces.iter().any(is_asset) {
        ("LicenseRef-Of-The-Parts", "https://spdx.org/licenses/")
    } else {
        ("MIT OR Apache-2.0", "https://spdx.org/licenses/")
    }
}

/// Metadata that Hugging Face reads, in YAML: the licence, the task, and the folders of the splits with images.
fn front_matter(recipe: &ImageRecipe, records: &[ImageRecord]) -> String {
    let licence = if licence(recipe).0 == "MIT OR Apache-2.0" { "\n- mit\n- apache-2.0" } else { " other" };
    let mut text = format!(
        "---\nlicense:{licence}\npretty_name: Coated workpieces in the course of sanding\ntask_categories:\n\
         - image-segmentation\ntags:\n- robotics\n- synthetic\nconfigs:\n- config_name: default\n  data_files:\n"
    );
    for split in Split::ALL.into_iter().filter(|&split| records.iter().any(|record| record.split == split)) {
        let _ = writeln!(text, "  - split: {0}\n    path:\n    - {0}/metadata.jsonl\n    - {0}/images/*", split.name());
    }
    text + "---\n\n"
}

fn contents(recipe: &ImageRecipe, records: &[ImageRecord]) -> String {
    let mut text = "\n## Contents\n\n| split | workpieces | images |\n|---|---|---|\n".to_owned();
    for split in Split::ALL {
        let images: Vec<&ImageRecord> = records.iter().filter(|record| record.split == split).collect();
        let workpieces: BTreeSet<&str> = images.iter().map(|record| record.workpiece.as_str()).collect();
        let names = workpieces.into_iter().collect::<Vec<_>>().join(", ");
        let _ = writeln!(text, "| {} | {names} | {} |", split.name(), images.len());
    }
    let _ = writeln!(
        text,
        "\nNo two splits share a {}. All images of a placement have one camera; light, material, sensor and looks are drawn \
         for each.",
        recipe.split_by.name()
    );
    text += "\n| state | images | exposed share, mean | labels agree, least |\n|---|---|---|---|\n";
    let states = [("unsanded".to_owned(), Treatment::Unsanded)].into_iter();
    let stages = recipe.patterns.iter().flat_map(|&pattern| {
        (1..=recipe.stages)
            .map(move |stage| (format!("{}, stage {stage}", pattern.name()), Treatment::Stage { pattern, stage }))
    });
    for (name, treatment) in states.chain(stages).chain([("bare".to_owned(), Treatment::Bare)]) {
        let of = || records.iter().filter(|record| record.treatment == treatment);
        let count = of().count();
        if count > 0 {
            let exposed = of().map(|record| record.exposed_share).sum::<f64>() / count as f64;
            let agreement = of().filter_map(|record| record.agreement).fold(1.0, f64::min);
            let _ = writeln!(text, "| {name} | {count} | {exposed:.3} | {agreement:.4} |");
        }
    }
    text
}

fn labels() -> String {
    format!(
        "\n## Labels\n\nOf the coating at a pixel a share is gone. By the dose D it is min(D, 1). By appearance it is the pixel's distance \
         from the unsanded reference over the sum of its distances from both references: same camera, light and material, no \
         noise, Euclidean in code of gamma 2.2. From {SANDED_FROM} on a pixel is sanded, up to {UNSANDED_TO} unsanded. Ignored are pixels between, pixels whose neighbour above, below, \
         left or right has another class, and, by appearance, pixels where bare and unsanded differ by less than {LEAST_CONTRAST}.\n"
    )
}
