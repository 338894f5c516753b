//! Maps of exposed substrate after sanding: agreement of measurement and simulation.

use std::fmt::Write;

use image::Rgb;

use super::colour_scale::{MISSING, css};
use super::maps::{ALONE, BESIDE};
use super::number::{fixed_cell, share_cell};
use super::words::role;
use crate::map_image::{MapImage, Values};
use crate::{Cell, Page, Table, escape};
use study::{ExposureMaps, Maps, ScanComparison};

/// Classes of a pixel, and their colours.
const WORDS: [&str; 5] =
    ["coated in both", "exposed in both", "exposed only as measured", "exposed only in the simulation", "unknown"];
const COLOURS: [Rgb<u8>; 5] =
    [Rgb([0xf3, 0xf4, 0xf6]), Rgb([0x5b, 0x65, 0x77]), Rgb([0x14, 0x5d, 0xa0]), Rgb([0xee, 0x8a, 0x2c]), MISSING];

/// Appends the maps of all exposure scans.
pub(super) fn add(page: &mut Page, scans: &[ScanComparison]) {
    if !scans.iter().any(|scan| matches!(scan.maps, Maps::Exposure(_))) {
        return;
    }
    page.subsection("Exposed substrate");
    page.paragraph(
        "Where sanding went through the coating. Blue: the real tool exposed what the simulation left coated; orange: the reverse.",
    );
    page.block(&legend());
    for scan in scans {
        if let Maps::Exposure(maps) = &scan.maps {
            page.block(&scan_html(scan, maps));
        }
    }
}

fn legend() -> String {
    let key = |(word, colour): (&&str, &Rgb<u8>)| {
        format!("<span class=\"key\"><i style=\"background:{}\"></i>{}</span>", css(*colour), escape(word))
    };
    format!("<p class=\"legend\">{}</p>\n", WORDS.iter().zip(&COLOURS).map(key).collect::<String>())
}

fn scan_html(scan: &ScanComparison, maps: &ExposureMaps) -> String {
    let width = if maps.with_effect.is_some() { BESIDE } else { ALONE };
    let mut table = Table::new(
        &format!("Exposed area of {}", scan.pass),
        &["model", "measured [mm²]", "simulated [mm²]", "intersection over union", "pixels that disagree", "unknown"],
    );
    let mut figures = String::new();
    let after = maps.with_effect.as_ref().map(|map| ("with effect", map));
    for (label, simulated) in [("base model", &maps.base)].into_iter().chain(after) {
        let classes: Vec<usize> = maps.measured.iter().zip(simulated).map(|(m, s)| class(*m, *s)).collect();
        let title = format!("{}: exposed as measured and in the {label}, by place", scan.pass);
        let image = MapImage {
            pixels: maps.pixels,
            colours: classes.iter().map(|&class| COLOURS[class]).collect(),
            values: Values::Words(&WORDS, &classes),
            label,
            title: &title,
            width,
            lines: Vec::new(),
        };
        let _ = write!(figures, "<figure>{}<figcaption>{}</figcaption></figure>", image.to_svg(), escape(label));
        table.rows.push(row(label, &classes, maps.pixels.pitch));
    }
    let heading = format!("{}, {} pass", scan.pass, role(scan.role));
    format!(
        "<section class=\"scan\"><h4>{}</h4>\n<div class=\"pair\">{figures}</div>\n{}</section>\n",
        escape(&heading),
        table.to_html()
    )
}

fn class(measured: Option<bool>, simulated: bool) -> usize {
    match (measured, simulated) {
        (Some(false), false) => 0,
        (Some(true), true) => 1,
        (Some(true), false) => 2,
        (Some(false), true) => 3,
        (None, _) => 4,
    }
}

fn row(label: &str, classes: &[usize], pitch: f64) -> Vec<Cell> {
    let mut counts = [0.0; WORDS.len()];
    classes.iter().for_each(|&class| counts[class] += 1.0);
    let [coated, both, measured, simulated, unknown] = counts;
    let area = |count: f64| fixed_cell(Some(count * pitch * pitch), 1e-6, 1);
    let share = |part: f64, whole: f64| share_cell((whole > 0.0).then(|| part / whole));
    vec![
        Cell::text(label),
        area(both + measured),
        area(both + simulated),
        share(both, both + measured + simulated),
        share(measured + simulated, coated + both + measured + simulated),
        share(unknown, classes.len() as f64),
    ]
}
