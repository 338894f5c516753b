//! The page of a ground asset.

mod section;

use std::path::Path;

use anyhow::Result;

use crate::asset::{FileRecord, MANIFEST_FILE, Manifest, PREVIEW_FILE, WeldTruth, record_files};
use crate::finishing::{Grinding, Ground, WeldPass, model_facts};
use crate::picture::{GrindPictures, to_png};
use files::input::{self, MOST_MESH_BYTES};
use report::{Chart, Page, Series, WIDE};

/// Builds the page of a ground asset: workpiece, links to files beside the page, grinding, results, files.
///
/// - `links`: addresses and words
///
/// # Errors
/// If the manifest, the picture or a file of the asset cannot be read.
pub fn grinding_page(
    asset: &Path,
    ground: &Ground,
    pictures: &GrindPictures,
    links: &[(String, String)],
) -> Result<String> {
    let manifest = Manifest::read(asset)?;
    let mut page = Page::new("RoboFin: from a CAD mesh to a ground weld", &lead(ground));
    let welded = input::read(&asset.join(PREVIEW_FILE), MOST_MESH_BYTES)?;
    page.picture(&welded, "The welded workpiece, drawn from its signed distance field; weld metal is tinted.");
    page.picture(&to_png(&pictures.sheet)?, "The weld before and after grinding, and the depth that was removed.");
    page.links(links);
    add_grinding(&mut page, ground);
    page.section("Weld");
    page.facts(&weld_facts(&ground.weld));
    for choice in &manifest.choices {
        page.paragraph(choice);
    }
    page.section("Part and field");
    page.facts(&part_facts(&manifest));
    page.section("Files of the asset");
    let files: Vec<_> = record_files(asset)?.into_iter().collect();
    page.table(&["file", "bytes", "SHA-256"], &files.iter().map(file_row).collect::<Vec<_>>());
    page.paragraph(&format!(
        "RoboFin {}; the manifest {MANIFEST_FILE} holds every parameter. `robofin validate` checks the folder.",
        env!("CARGO_PKG_VERSION")
    ));
    Ok(page.finish())
}

fn lead(ground: &Ground) -> String {
    let passes = &ground.run.passes;
    let removed: f64 = passes.iter().map(|pass| pass.lost * 1e9).sum();
    let passes = if passes.len() == 1 { "one pass".to_owned() } else { format!("{} passes", passes.len()) };
    format!(
        "A weld of {:.0} mm was laid on {}, and {passes} of a wheel at {:.0} N took {removed:.1} mm³ off it.",
        ground.weld.length_mm, ground.source.file, ground.grinding.plan.force_setpoint
    )
}

fn add_grinding(page: &mut Page, ground: &Ground) {
    page.section("Grinding");
    if let Some(error) = &ground.run.stopped {
        page.paragraph(&format!("The run ended before its last pass: {error:#}."));
    }
    let headings = [
        "pass",
        "removed [mm³]",
        "Eq. (1) over the contact [mm³]",
        "force error [N rms]",
        "peak pressure [MPa]",
        "time [s]",
        "steps",
    ];
    page.table(&headings, &pass_rows(ground));
    page.drawing(&section::middle_section(ground), "Section across the middle of the weld, as welded and as ground.");
    page.drawing(&force_chart(ground), "Force error along each pass, while the wheel touches.");
    page.facts(&process_facts(ground));
}

fn pass_rows(ground: &Ground) -> Vec<Vec<String>> {
    let row = |(i, WeldPass { record: pass, lost }): (usize, &WeldPass)| {
        vec![
            format!("{}", i + 1),
            format!("{:.3}", lost * 1e9),
            format!("{:.3}", pass.removed_volume * 1e9),
            format!("{:.2e}", pass.force_rms_error),
            format!("{:.2}", pass.pressure_max * 1e-6),
            format!("{:.1}", pass.duration),
            format!("{}", pass.steps),
        ]
    };
    ground.run.passes.iter().enumerate().map(row).collect()
}

/// Draws force minus setpoint while the wheel touches, in the unit in which its greatest value has one to three digits.
fn force_chart(ground: &Ground) -> String {
    let setpoint = ground.grinding.plan.force_setpoint;
    let errors = |pass: &WeldPass| -> Vec<(f64, f64)> {
        let touching = pass.record.log.iter().filter(|row| row.force > 0.0);
        touching.map(|row| (row.time, row.force - setpoint)).collect()
    };
    let lines: Vec<Vec<(f64, f64)>> = ground.run.passes.iter().map(errors).collect();
    let most = lines.iter().flatten().map(|point| point.1.abs()).fold(0.0, f64::max);
    let units = [(1.0, "N"), (1e-3, "mN"), (1e-6, "µN")];
    let (unit, name) = units.into_iter().find(|(unit, _)| most >= *unit).unwrap_or((1e-6, "µN"));
    let scaled = |line: &[(f64, f64)]| line.iter().map(|&(time, error)| (time, error / unit)).collect();
    let series: Vec<Series> =
        lines.iter().enumerate().map(|(i, line)| Series::new(format!("pass {}", i + 1), scaled(line))).collect();
    Chart {
        title: "Force error along each pass",
        x_label: "time in the pass [s]",
        y_label: &format!("force − setpoint [{name}]"),
        series: &series,
        size: WIDE,
        from_zero: false,
        band: None,
    }
    .to_svg()
}

fn process_facts(ground: &Ground) -> Vec<(String, String)> {
    let Grinding { wheel, plan, model } = &ground.grinding;
    let mut facts = vec![
        ("wheel".into(), format!("radius {:.0} mm, width {:.0} mm", wheel.radius * 1e3, wheel.width * 1e3)),
        ("force setpoint, feed".into(), format!("{:.1} N, {:.1} mm/s", plan.force_setpoint, plan.feed * 1e3)),
    ];
    facts.extend(model_facts(model));
    facts.extend([
        (
            "weld metal left above the part".into(),
            format!("{:.2} of {:.2} mm³", ground.weld_left * 1e9, ground.weld.volume_mm3),
        ),
        ("base metal ground away".into(), format!("{:.3} mm³", ground.base_removed * 1e9)),
    ]);
    facts
}

fn weld_facts(weld: &WeldTruth) -> Vec<(&'static str, String)> {
    vec![
        ("length, width, height", format!("{:.2} x {:.2} x {:.2} mm", weld.length_mm, weld.width_mm, weld.height_mm)),
        ("volume added to the part", format!("{:.2} mm³", weld.volume_mm3)),
        (
            "geodesic curvature",
            format!(
                "{:.2} 1/m rms, {:.2} 1/m at most",
                weld.geodesic_curvature_rms_per_m, weld.geodesic_curvature_max_per_m
            ),
        ),
        ("exposure", format!("{:.3} mean, {:.3} at least", weld.exposure_mean, weld.exposure_min)),
    ]
}

fn part_facts(manifest: &Manifest) -> Vec<(&'static str, String)> {
    let (source, baking) = (&manifest.source, &manifest.baking);
    let repairs =
        if manifest.repairs.is_empty() { "nothing to repair".to_owned() } else { manifest.repairs.join("; ") };
    vec![
        ("part", source.file.clone()),
        ("unit", source.unit_reason.clone()),
        ("cleaning", repairs),
        ("voxel, band", format!("{:.4} mm, {} voxels", baking.voxel_m * 1e3, baking.band_voxels)),
        ("bricks, active voxels", format!("{}, {}", baking.bricks, baking.active_voxels)),
        ("SHA-256 of the source", source.sha256.clone()),
    ]
}

fn file_row((name, record): &(String, FileRecord)) -> Vec<String> {
    vec![name.clone(), record.bytes.to_string(), record.sha256[..16].to_owned() + "…"]
}
