//! README of a data set: contents, method and failures.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use super::Recipe;
use super::row::RowFigures;
use crate::store::Failure;
use weldgen::Difficulty;

/// A row of the table of statistics: its name, and a function that reads its value.
type Figure = (&'static str, fn(&RowFigures) -> f64);

/// Writes the README in Markdown.
pub(super) fn write(recipe: &Recipe, items: &[RowFigures], failures: &[Failure]) -> String {
    let parts: BTreeSet<&str> = items.iter().map(|item| item.row.source_sha256.as_str()).collect();
    let mut text = format!(
        "# Welded workpieces\n\n{} items from {} parts, {} failures. Made by RoboFin {} with seed {}.\n\n\
         Each item is a CAD part with a weld bead: meshes (glTF), signed distance fields and weld labels (NanoVDB), and the \
         exact truth of the weld (centreline, frames, sizes, curvature, exposure).\n\n![some items](contact-sheet.png)\n",
        items.len(),
        parts.len(),
        failures.len(),
        recipe.version,
        recipe.seed
    );
    text += "\n## Files\n\n| file | holds |\n|---|---|\n";
    for (file, holds) in [
        (
            "`manifest.jsonl`",
            "one line for each item: source, licence, split, difficulty, requested and measured, SHA-256 of its files",
        ),
        ("`manifest.csv`", "the same as a table"),
        ("`failures.jsonl`", "items that could not be made: reason, and the command line that shows it again"),
        ("`assets/ID/`", "an item; `asset.json` there says how it was made, `welds.json` is the truth"),
        ("`croissant.json`", "Croissant 1.0 metadata"),
        ("`dataset.json`", "what decides every item"),
    ] {
        let _ = writeln!(text, "| {file} | {holds} |");
    }
    text += &contents(items);
    text += &figures(items);
    text += &making(recipe);
    text += &doubts(items);
    text += &shortcomings(failures);
    text
}

fn counted<T: Ord>(values: impl Iterator<Item = T>) -> BTreeMap<T, usize> {
    let mut counts = BTreeMap::new();
    values.for_each(|value| *counts.entry(value).or_default() += 1);
    counts
}

fn contents(items: &[RowFigures]) -> String {
    let mut text = "\n## Contents\n\n| split | items |\n|---|---|\n".to_owned();
    let splits = counted(items.iter().map(|item| item.row.split.as_str()));
    for split in ["train", "validation", "test"] {
        let _ = writeln!(text, "| {split} | {} |", splits.get(split).unwrap_or(&0));
    }
    text += "\nThe split follows from the part's content, so no part is in two of them.\n\n| difficulty | items |\n|---|---|\n";
    let classes = counted(items.iter().map(|item| item.row.difficulty));
    for class in Difficulty::ALL {
        let _ = writeln!(text, "| {} | {} |", class.name(), classes.get(&class).unwrap_or(&0));
    }
    text + "\nDifficulty is measured: " + &Difficulty::rule() + ".\n"
}

fn figures(items: &[RowFigures]) -> String {
    let mut text = "\n| measured | least | median | most |\n|---|---|---|---|\n".to_owned();
    let figures: [Figure; 3] = [
        ("length of the welds [mm]", |item| item.length_mm),
        ("least exposure", |item| item.exposure),
        ("sharpest turn over a bead width [rad]", |item| item.turn),
    ];
    for (name, figure) in figures {
        let mut values: Vec<f64> = items.iter().map(figure).collect();
        values.sort_by(f64::total_cmp);
        if let (Some(least), Some(most)) = (values.first(), values.last()) {
            let _ = writeln!(text, "| {name} | {least:.3} | {:.3} | {most:.3} |", values[values.len() / 2]);
        }
    }
    text
}

fn making(recipe: &Recipe) -> String {
    format!(
        "\n## Making\n\nFlags that decide the items: `{}`. Seeds follow from the content of a part and the number of the item, so the same \
         parts and flags give the same bytes.\n\n`robofin validate DIR` rehashes and rechecks everything, with `--repair` it makes \
         broken items again.\n\n## Licence\n\nOf the source parts: {}. Cite as: RoboFin {}, welded \
         workpieces, seed {}.\n",
        recipe.flags.join(" "),
        recipe.licence,
        recipe.version,
        recipe.seed
    )
}

/// Names the parts whose unit is doubtful.
fn doubts(items: &[RowFigures]) -> String {
    let doubt =
        |item: &RowFigures| Some((item.row.source.clone(), item.row.measured["unit_doubts"][0].as_str()?.to_owned()));
    let parts: BTreeMap<String, String> = items.iter().filter_map(doubt).collect();
    let line = |(part, doubt): (&String, &String)| format!("- `{part}`: {doubt}\n");
    let heading = if parts.is_empty() { "" } else { "\n## Doubtful units\n\n" };
    heading.to_owned() + &parts.iter().map(line).collect::<String>()
}

fn shortcomings(failures: &[Failure]) -> String {
    let mut text =
        "\n## Limits\n\nWelds are placed at random on CAD parts, not where a welder would put them. ".to_owned();
    if failures.is_empty() {
        return text + "No item failed.\n";
    }
    let _ = writeln!(text, "{} items could not be made:\n\n| stage | items |\n|---|---|", failures.len());
    for (stage, count) in counted(failures.iter().map(|failure| failure.stage)) {
        let _ = writeln!(text, "| {} | {count} |", stage.name());
    }
    text
}
