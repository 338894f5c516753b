//! Sections: measured and simulated heights, and their difference below.

use super::colour_scale::BAND_FLOORS;
use super::number::fixed;
use super::statistics::Statistics;
use crate::{Chart, Page, Series, Stroke, stacked};
use study::{Direction, ScanSection};

/// Width of the drawing, and heights of profile and difference [px].
const WIDTH: f64 = 900.0;
const PROFILE: f64 = 190.0;
const DIFFERENCE: f64 = 170.0;

const MEASURED: Stroke = Stroke { colour: "#1c2330", dashed: false };
const BASE: Stroke = Stroke { colour: "#d55e00", dashed: true };
const WITH_EFFECT: Stroke = Stroke { colour: "#0072b2", dashed: false };

/// Appends all sections.
///
/// - `noise`: scan noise that sets the tolerance band of the maps [m]
pub(super) fn add(page: &mut Page, sections: &[ScanSection], noise: f64) {
    if sections.is_empty() {
        return;
    }
    page.subsection("Sections");
    page.paragraph(
        "Above, the heights; below, measured minus simulated, where the grey strip is the tolerance band of the maps. The pointer shows the values.",
    );
    for section in sections {
        // Without maps, the section's own noise floor sets the band.
        let band = BAND_FLOORS * if noise > 0.0 { noise } else { section.noise_floor };
        page.drawing(&drawing(section, band), &caption(section, band));
    }
}

fn place(direction: Direction) -> String {
    match direction {
        Direction::Across(x) => format!("across the bead at x = {} mm", fixed(x * 1e3, 1)),
        Direction::Along(y) => format!("along x at y = {} mm", fixed(y * 1e3, 1)),
        Direction::AlongCrest => "along the crest".to_owned(),
    }
}

fn drawing(section: &ScanSection, band: f64) -> String {
    let x_label = match section.direction {
        Direction::Across(_) => "y [mm]",
        Direction::Along(_) | Direction::AlongCrest => "x [mm]",
    };
    let line = |name: &str, heights: Vec<f64>, unit: f64, stroke| Series {
        stroke: Some(stroke),
        ..Series::new(name, section.position.iter().map(|x| x * 1e3).zip(heights.iter().map(|h| h / unit)).collect())
    };
    let mut profiles = vec![
        line("measured", section.measured.clone(), 1e-3, MEASURED),
        line("base model", section.base.clone(), 1e-3, BASE),
    ];
    let mut differences = vec![line("measured − base model", residuals(section, &section.base), 1e-6, BASE)];
    if let Some(heights) = &section.with_effect {
        profiles.push(line("with effect", heights.clone(), 1e-3, WITH_EFFECT));
        differences.push(line("measured − with effect", residuals(section, heights), 1e-6, WITH_EFFECT));
    }
    let band = band * 1e6;
    let title = format!("{}, {}", section.pass, place(section.direction));
    let profile = Chart {
        title: &title,
        x_label,
        y_label: "height [mm]",
        series: &profiles,
        size: (WIDTH, PROFILE),
        from_zero: false,
        band: None,
    };
    let difference = Chart {
        y_label: "difference [µm]",
        series: &differences,
        size: (WIDTH, DIFFERENCE),
        band: Some((-band, band)),
        ..profile
    };
    stacked(&title, &[profile, difference])
}

/// Returns measured minus simulated heights [m].
fn residuals(section: &ScanSection, simulated: &[f64]) -> Vec<f64> {
    section.measured.iter().zip(simulated).map(|(m, s)| m - s).collect()
}

fn caption(section: &ScanSection, band: f64) -> String {
    let rms = |simulated: &[f64]| {
        let found = Statistics::new(residuals(section, simulated).into_iter(), band);
        found.map_or("–".to_owned(), |found| format!("{} µm", fixed(found.rms * 1e6, 2)))
    };
    let after = section.with_effect.as_ref().map_or(String::new(), |heights| format!(", with effect {}", rms(heights)));
    let place = place(section.direction);
    format!(
        "{}, {place}. Root mean square of the difference: base model {}{after}; band ±{} µm.",
        section.pass,
        rms(&section.base),
        fixed(band * 1e6, 1)
    )
}
