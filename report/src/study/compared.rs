//! Head of the page: verdict, key figures, and the data compared.

use super::number::{fixed_cell, percent, share_cell, significant};
use super::waterfall::VOLUME;
use super::words::{list, role};
use crate::{Cell, Page, Table, escape, exact};
use lab::Verdict;
use study::with_raised_powers;
use study::{Compared, Conclusion, DisplayUnit, StudyReport};
use study::{ComparedPass, PassVolume, Waterfall, WaterfallStep};

/// Angular speed of 1 rpm [rad/s].
const RPM: f64 = std::f64::consts::TAU / 60.0;

/// Appends the verdict and the key figures.
pub(super) fn add_verdict(page: &mut Page, report: &StudyReport) {
    let (word, means) = (report.conclusion.word(), meaning(report.conclusion));
    page.block(&format!(
        "<section class=\"verdict {word}\" id=\"verdict\"><p class=\"word\">{word}</p>\n<p class=\"sentence\">{}</p>\n<p class=\"means\">{means}</p></section>\n",
        escape(&with_raised_powers(&report.sentence))
    ));
    page.block(&glance(&report.waterfall));
}

fn meaning(conclusion: Conclusion) -> &'static str {
    match conclusion {
        Conclusion::Searched(verdict) => meaning_of_search(verdict),
        Conclusion::Calibrated => "A diagnosis shows whether anything is missing, and what.",
        Conclusion::Better => "One of two models is better, by the difference of their errors, block by block.",
        Conclusion::NotBetter => {
            "The difference of the two models' errors, block by block, does not favour the second."
        }
        Conclusion::Agrees => "The model was compared as it is; nothing was fitted.",
        Conclusion::Differs => {
            "The model was compared as it is; see below where it fails, and <code>robofin diagnose</code> for why."
        }
    }
}

fn meaning_of_search(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Identified => "One effect explains what the base law misses, and held-out passes confirm it.",
        Verdict::Ambiguous => "Several effects explain it equally well; these passes cannot distinguish them.",
        Verdict::Partly => "An effect was found, and structure remains beside it.",
        Verdict::Unknown => "Something is missing that no effect of the library explains.",
        Verdict::Hint => "One effect is visible and no other resembles it, but it is too small to be certain.",
        Verdict::NothingMissing => {
            "The model agrees with the measurement within its noise; see below what would have shown."
        }
        Verdict::NotTestable => "These passes cannot show what was asked.",
    }
}

/// Builds the tiles of base model and best model, with the error of each kind of passes beside the noise floor of the
/// same passes.
fn glance(waterfall: &Waterfall) -> String {
    let [.., best, floor] = &waterfall.steps[..] else { return String::new() };
    let base = waterfall.steps.iter().find(|step| step.unexplained.is_some()).filter(|base| base.name != best.name);
    let tile = |step: &WaterfallStep| {
        let kinds = [
            ("evaluation passes", step.evaluation, floor.evaluation),
            ("calibration passes", step.calibration, floor.calibration),
        ];
        let lines: String = kinds.iter().filter_map(|kind| line(&waterfall.misfit.unit, *kind)).collect();
        format!("<div><dt>{}</dt>{lines}</div>\n", escape(&step.name))
    };
    let mut tiles: String = base.into_iter().chain([best]).map(tile).collect();
    if let Some(unexplained) = best.unexplained {
        tiles += &format!(
            "<div><dt>still unexplained</dt><dd data-value=\"{}\">{}</dd><dd class=\"of\">of the base model's excess over the floor, calibration passes</dd></div>\n",
            exact(unexplained),
            percent(unexplained)
        );
    }
    format!("<dl class=\"glance\">\n{tiles}</dl>\n")
}

/// Builds the line of one kind of passes: their error and noise floor; `None` without such passes.
fn line(unit: &DisplayUnit, (passes, error, floor): (&str, Option<f64>, Option<f64>)) -> Option<String> {
    let error = error?;
    let floor = floor.map_or(String::new(), |floor| {
        let shown = significant(unit.of(floor), 3);
        format!("; noise floor <span data-value=\"{}\">{shown} {}</span>", exact(floor), escape(&unit.unit))
    });
    Some(format!(
        "<dd data-value=\"{}\">{} <small>{}</small></dd><dd class=\"of\">{passes}{floor}</dd>",
        exact(error),
        significant(unit.of(error), 3),
        escape(&unit.unit)
    ))
}

/// Appends the data compared.
pub(super) fn add(page: &mut Page, compared: &Compared) {
    page.part("compared", "What was compared");
    let mut facts = vec![("model", compared.model.clone()), ("tool", compared.tool.clone())];
    let lengths = [
        ("pitch of the scans", compared.pitch, 1e-3, "mm"),
        ("voxel of the simulation", compared.voxel, 1e-3, "mm"),
        ("blur of the instrument", compared.blur, 1e-6, "µm"),
    ];
    for (name, length, si, unit) in lengths {
        facts.extend(length.map(|length| (name, format!("{} {unit}", significant(length / si, 3)))));
    }
    facts.retain(|(_, value)| !value.is_empty());
    if facts.is_empty() {
        page.paragraph("The study states neither model nor tool.");
    } else {
        page.facts(&facts);
    }
    if !compared.passes.is_empty() {
        page.block(&passes(&compared.passes).to_html());
    }
}

fn passes(passes: &[ComparedPass]) -> Table {
    let mut table = Table::new(
        "Passes in order of time; evaluation passes are never fitted",
        &["pass", "role", "force [N]", "feed [mm/s]", "spindle [rpm]", "scan noise [µm]"],
    );
    for pass in passes {
        table.rows.push(vec![
            Cell::text(&pass.name),
            Cell::text(role(pass.role)),
            fixed_cell(pass.force, 1.0, 1),
            fixed_cell(pass.feed, 1e-3, 1),
            fixed_cell(pass.spindle_speed, RPM, 0),
            fixed_cell(pass.noise_floor, 1e-6, 2),
        ]);
    }
    table
}

/// Appends the removed volumes.
pub(super) fn add_volumes(page: &mut Page, volumes: &[PassVolume]) {
    if volumes.is_empty() {
        return;
    }
    page.subsection("Removed volume");
    let has_effect = volumes.iter().any(|volume| volume.with_effect.is_some());
    let mut headings =
        vec!["pass", "measured [mm³]", "±", if has_effect { "base model [mm³]" } else { "model [mm³]" }, "error"];
    headings.extend(if has_effect { &["with effect [mm³]", "error"][..] } else { &[] });
    let caption = format!(
        "Simulated and measured: {VOLUME} and its error (simulated − measured) / measured; ± is the standard uncertainty that noise and alignment cause"
    );
    let mut table = Table::new(&caption, &headings);
    for volume in volumes {
        let cubic = |value: f64| fixed_cell(Some(value), 1e-9, 2);
        let simulated = |value: Option<f64>| {
            let error = value.map(|simulated| (simulated - volume.measured) / volume.measured);
            [value.map_or(Cell::absent(), cubic), share_cell(error)]
        };
        let mut row = vec![Cell::text(&volume.pass), cubic(volume.measured), cubic(volume.uncertainty)];
        row.extend(simulated(Some(volume.base)));
        row.extend(has_effect.then(|| simulated(volume.with_effect)).into_iter().flatten());
        table.rows.push(row);
    }
    page.block(&table.to_html());
}

/// Appends the registration of the scans and the notes of the reader.
pub(super) fn add_method(page: &mut Page, compared: &Compared) {
    let aligned = compared.passes.iter().any(|pass| pass.alignment.is_some());
    if !aligned && compared.method.is_empty() && compared.notes.is_empty() {
        return;
    }
    page.part("method", "Alignment and reading");
    page.block(&list(&compared.method));
    if aligned {
        page.block(&alignments(&compared.passes).to_html());
    }
    if !compared.notes.is_empty() {
        page.subsection("Notes of the reader");
        page.block(&list(&compared.notes));
    }
}

fn alignments(passes: &[ComparedPass]) -> Table {
    let mut table = Table::new(
        "How each scan lay over the model on the surface that the tool left alone",
        &[
            "pass",
            "offset [µm]",
            "tilt x [mrad]",
            "tilt y [mrad]",
            "shift x [µm]",
            "shift y [µm]",
            "turn [mrad]",
            "left over [µm]",
            "pixels",
        ],
    );
    for pass in passes {
        let Some(found) = &pass.alignment else { continue };
        let value = |value: f64, si: f64| fixed_cell(Some(value), si, 2);
        table.rows.push(vec![
            Cell::text(&pass.name),
            value(found.offset, 1e-6),
            value(found.tilt.x, 1e-3),
            value(found.tilt.y, 1e-3),
            value(found.shift.x, 1e-6),
            value(found.shift.y, 1e-6),
            value(found.turn, 1e-3),
            value(found.sigma, 1e-6),
            Cell::number(found.pixels.to_string(), found.pixels as f64),
        ]);
    }
    table
}
