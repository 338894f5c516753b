//! README of a set of images: contents, method and failures.

use std::fmt::Write;

use super::ImageRecipe;
use super::plan::{Split, Treatment};
use super::record::ImageRecord;
use crate::store::Failure;
use render::label::{LEAST_CONTRAST, SANDED_FROM, UNSANDED_TO};

/// Writes the README in Markdown.
pub(super) fn write(recipe: &ImageRecipe, records: &[ImageRecord], failures: &[Failure]) -> String {
    let planned = recipe.images().len();
    let names: Vec<&str> = recipe.workpieces.iter().map(|coated| coated.name.as_str()).collect();
    let mut text = format!(
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
        ("`images/ID.png`", "the image, eight-bit sRGB"),
        ("`appearance/ID.png`", "labels by what is seen: 0 background, 1 sanded, 2 unsanded, 255 ignore"),
        ("`dose/ID.png`", "labels by the dose, the same values"),
        ("`annotations/*.json`", "COCO files of each kind of label and split, masks as compressed RLE"),
        (
            "`metadata.jsonl`",
            "one line for each image: camera, light, material, placement, pattern, stage, split, exposed share, hashes",
        ),
        ("`records/ID.json`", "the same line alone"),
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
         everything, with `--repair` it makes what is broken again.\n\n## Licence\n\nOf workpieces that are assets: that of \
         their parts. The bracket and the panel come with RoboFin.",
        recipe.flags().join(" ")
    );
    for failure in failures {
        let _ = writeln!(text, "\nNot made: `{}`, {}: {}", failure.id, failure.stage.name(), failure.reason);
    }
    text
}

fn contents(recipe: &ImageRecipe, records: &[ImageRecord]) -> String {
    let mut text = "\n## Contents\n\n| split | placements of each workpiece | images |\n|---|---|---|\n".to_owned();
    let splits = recipe.splits();
    for split in Split::ALL {
        let placements = splits.iter().filter(|&&s| s == split).count();
        let images = records.iter().filter(|record| record.split == split).count();
        let _ = writeln!(text, "| {} | {placements} | {images} |", split.name());
    }
    text +=
        "\nAll images of a placement have one camera and one split; light, material and sensor are drawn for each.\n";
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
        "\n## Labels\n\nOf the coating at a pixel a share is gone. By the dose D it is min(D, 1). By appearance it is the change of the pixel \
         against the unsanded reference over that of the bare reference: same camera, light and material, no noise, Euclidean in \
         code of gamma 2.2. From {SANDED_FROM} on a pixel is sanded, up to {UNSANDED_TO} unsanded. Ignored are pixels between, pixels whose neighbour above, below, \
         left or right has another class, and, by appearance, pixels where bare and unsanded differ by less than {LEAST_CONTRAST}.\n"
    )
}
