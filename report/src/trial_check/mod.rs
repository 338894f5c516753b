//! Page of a trial's checks: findings, and maps, logs and tool in one frame, before any fit.

mod drawings;

use serde::Serialize;
use trials::measure::{NoiseSource, ScanNoise};
use trials::trial::{Checked, Finding, ForceInput, Pass, PassScan, RPM, Role, Severity, ToolPath, Trial};

use crate::Page;
use robot::Controller;

/// A checked trial.
pub struct TrialCheck<'a> {
    /// The trial.
    pub trial: &'a Trial,
    /// Every check with its findings.
    pub checks: &'a [Checked],
    /// Noise of the trial's scans.
    pub noise: &'a ScanNoise,
}

/// Summary of a checked trial for programs.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the trial.
    trial: String,
    /// Number of findings that make the trial unusable.
    refused: usize,
    /// Noise of one scan [µm].
    noise_um: f64,
    /// Source of the noise estimate.
    noise_source: NoiseSource,
    /// Notes of the reader, one sentence each.
    notes: Vec<String>,
    /// Every check with its findings.
    checks: Vec<Checked>,
}

impl TrialCheck<'_> {
    /// Returns the summary for programs.
    pub fn summary(&self) -> Summary {
        Summary {
            trial: self.trial.name.clone(),
            refused: self.refused(),
            noise_um: self.noise.floor.sigma * 1e6,
            noise_source: self.noise.source.clone(),
            notes: self.trial.notes.clone(),
            checks: self.checks.to_vec(),
        }
    }

    /// Returns the number of findings that make the trial unusable.
    pub fn refused(&self) -> usize {
        let findings = self.checks.iter().flat_map(|check| &check.findings);
        findings.filter(|finding| finding.severity == Severity::Refused).count()
    }

    /// Returns the reasons why the trial is refused, one sentence each.
    pub fn refusals(&self) -> impl Iterator<Item = String> {
        let findings = self.checks.iter().flat_map(|check| &check.findings);
        findings.filter(|finding| finding.severity == Severity::Refused).map(|finding| {
            let parts = [finding.expected.as_deref(), finding.guess.as_deref()].into_iter().flatten();
            let expected: Vec<&str> = parts.collect();
            format!("{}: {}; {}", finding.check, finding.found, expected.join(": "))
        })
    }

    /// Returns the verdict on the trial in one sentence.
    pub fn verdict(&self) -> String {
        let noted = self.checks.iter().map(|check| check.findings.len()).sum::<usize>() - self.refused();
        match (self.refused(), noted) {
            (0, 0) => "All checks pass: the trial can be used.".to_owned(),
            (0, noted) => format!("The trial can be used; {noted} things are odd."),
            (refused, noted) => {
                format!("The trial cannot be used: {refused} checks refuse it, and {noted} things are odd.")
            }
        }
    }
}

/// Builds the page of checked trials.
pub fn page(name: &str, checks: &[TrialCheck]) -> String {
    let verdicts: Vec<String> = match checks {
        [only] => vec![only.verdict()],
        several => several.iter().map(|check| format!("{}: {}", check.trial.name, check.verdict())).collect(),
    };
    let mut page = Page::new(&format!("{name}: what the files say"), &verdicts.join(" "));
    page.style(include_str!("../study/style.css"));
    checks.iter().for_each(|check| add_trial(&mut page, check));
    page.block(&format!(
        "<div id=\"tip\" aria-hidden=\"true\"></div>\n<script>\n{}</script>\n",
        include_str!("../study/hover.js")
    ));
    page.finish()
}

fn add_trial(page: &mut Page, check: &TrialCheck) {
    let trial = check.trial;
    page.section(&trial.name);
    page.subsection("Checks");
    add_checks(page, check.checks);
    page.subsection("What will be used");
    page.facts(&used(check));
    page.table(
        &["pass", "role", "rows", "contact [s]", "force [N]", "feed [mm/s]", "spindle [rpm]", "direction"],
        &trial.passes.iter().enumerate().map(|(k, pass)| pass_row(trial, k, pass)).collect::<Vec<_>>(),
    );
    for note in &trial.notes {
        page.paragraph(note);
    }
    page.subsection("Scans and paths");
    drawings::add_maps(page, check);
    page.subsection("Tool on the surface");
    drawings::add_section(page, trial);
    page.subsection("Logs");
    drawings::add_logs(page, trial);
}

fn add_checks(page: &mut Page, checks: &[Checked]) {
    let (passed, odd): (Vec<&Checked>, Vec<&Checked>) = checks.iter().partition(|check| check.findings.is_empty());
    let passed: Vec<&str> = passed.into_iter().map(|check| check.check).collect();
    page.paragraph(&format!("Passed: {}.", passed.join(", ")));
    let rows: Vec<Vec<String>> = odd
        .into_iter()
        .flat_map(|check| check.findings.iter().map(|finding| finding_row(check.check, finding)))
        .collect();
    if !rows.is_empty() {
        page.words(&["check", "result", "file", "found", "expected"], &rows);
    }
}

fn finding_row(check: &str, finding: &Finding) -> Vec<String> {
    let became = match finding.severity {
        Severity::Refused => "refused",
        Severity::Noted => "noted",
    };
    let file = finding.file.as_deref().map(|file| file.rsplit('/').next().unwrap_or(file));
    let expected: Vec<&str> = [&finding.expected, &finding.guess].into_iter().flatten().map(String::as_str).collect();
    [check, became, file.unwrap_or_default(), &finding.found, &expected.join(": ")].map(str::to_owned).to_vec()
}

fn used(check: &TrialCheck) -> Vec<(&'static str, String)> {
    let TrialCheck { trial, noise, .. } = check;
    let pixels = trial.scans.before.pixels;
    let [x, y] = pixels.origin.to_array().map(|place| place * 1e3);
    let far = pixels.position(pixels.nx - 1, pixels.ny - 1) * 1e3;
    let controller = match (trial.controller, trial.force_input) {
        (Controller::Replay, _) => "none: the logged heights are replayed".to_owned(),
        (Controller::Ideal, ForceInput::Log) => "the logged force presses the tool on".to_owned(),
        (Controller::Ideal, ForceInput::Setpoint) => "ideal: the force is the setpoint".to_owned(),
        (Controller::Admittance { mass, damping, period }, _) => {
            format!("admittance: {mass} kg, {damping} N s/m, every {:.2} ms", period * 1e3)
        }
    };
    let tool = match trial.tool.axis {
        Some(axis) => format!(
            "wheel, radius {:.2} mm, width {:.2} mm, axis [{:.3}, {:.3}, {:.3}]",
            trial.tool.shape.rim_radius() * 1e3,
            trial.tool.shape.width() * 1e3,
            axis.x,
            axis.y,
            axis.z
        ),
        None => format!("pad, radius {:.2} mm", trial.tool.shape.rim_radius() * 1e3),
    };
    let source = noise.source.words().unwrap_or_else(|| "from the repeated scan".to_owned());
    vec![
        ("tool", format!("{tool}; {}", if trial.fresh { "fresh" } else { "worn by the trial before" })),
        ("controller", controller),
        (
            "pixels",
            format!(
                "{} x {}, {:.4} mm apart, from x {x:.2} mm, y {y:.2} mm to x {:.2} mm, y {:.2} mm",
                pixels.nx,
                pixels.ny,
                pixels.pitch * 1e3,
                far.x,
                far.y
            ),
        ),
        (
            "noise of one scan",
            format!(
                "{:.2} µm a pixel, {:.2} µm of it shared by neighbours; {source}",
                noise.floor.sigma * 1e6,
                noise.floor.correlated * 1e6
            ),
        ),
    ]
}

fn pass_row(trial: &Trial, number: usize, pass: &Pass) -> Vec<String> {
    let path = ToolPath::of(&pass.log, &trial.tool, pass.force_setpoint);
    let contact = path.contact.map_or("none".to_owned(), |contact| format!("{:.2}", contact.end - contact.start));
    let role = match pass.role {
        Role::Calibration => "calibration",
        Role::Evaluation => "evaluation",
    };
    let kind = match &pass.scan {
        scan if scan.is_missing() => ", no scan",
        PassScan::Heights(_) => "",
        PassScan::Exposure(_) => ", mask",
    };
    vec![
        format!("{}{kind}", number + 1),
        role.to_owned(),
        pass.log.rows.len().to_string(),
        contact,
        format!("{:.2}", pass.force_setpoint),
        format!("{:.2}", pass.feed * 1e3),
        format!("{:.0}", pass.spindle_speed / RPM),
        format!("[{:.2}, {:.2}, {:.2}]", pass.direction.x, pass.direction.y, pass.direction.z),
    ]
}
