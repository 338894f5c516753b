//! Writing of planned trials: the passes to run, and the names of the files to measure.

use std::fs;
use std::path::Path;

use files::FileError;

use super::Trial;
use super::manifest::TRIAL_FILE;
use super::write::{log_csv, log_header, manifest_of};

/// Names of a plan's files; `*` stands for the number of a pass. Measured files have other names.
pub const PLAN_NAMES: &[&str] = &[TRIAL_FILE, "pass*_path.csv", "pass*_log_template.csv"];

/// Writes a planned trial into an existing folder: `trial.toml`, and for each pass its path with force and spindle
/// speed in the columns of a log (`pass1_path.csv`) and the header of its log (`pass1_log_template.csv`). Once the
/// scans and logs that `trial.toml` names are in the folder, [`Trial::read`] reads it.
///
/// - `trial`: without heights, masks and labels
/// - `remarks`: comments at the top of `trial.toml`, one line each
///
/// # Errors
/// A file that cannot be written.
pub fn write_plan(trial: &Trial, remarks: &[String], folder: &Path) -> Result<(), FileError> {
    let manifest = manifest_of(trial);
    let put = |name: &str, text: &str| {
        let place = folder.join(name);
        fs::write(&place, text).map_err(FileError::at(&place, "cannot write this file"))
    };
    for (k, pass) in trial.passes.iter().enumerate() {
        put(&format!("pass{}_path.csv", k + 1), &log_csv(&pass.log))?;
        put(&format!("pass{}_log_template.csv", k + 1), &log_header(&pass.log))?;
    }
    let text = toml::to_string(&manifest).map_err(FileError::encoding(&folder.join(TRIAL_FILE)))?;
    let remarks: String = remarks.iter().map(|remark| format!("# {remark}\n")).collect();
    put(TRIAL_FILE, &(remarks + &text))
}

#[cfg(test)]
mod tests {
    use super::super::{ForceInput, Pass, PassScan, Scans, log_csv, write_trial};
    use super::*;
    use crate::trial::{FrameErrors, FrameOffset, HeldTool, Log, Role};
    use effects::Process;
    use glam::{DVec2, DVec3};
    use robot::{Controller, LogRow};
    use sdf_bake::{HeightMap, PixelGrid};

    /// A wheel that descends on a plate of 40 by 20 mm, moves 20 mm and rises.
    fn trial() -> Trial {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 80, ny: 40 };
        // Scans with a micrometre of noise; the pass removes ten.
        let scan = |number: usize, depth: f64| {
            let noise = |at: usize| 1e-6 * ((7919 * at + 104_729 * number) as f64).sin();
            let cut = |at: usize| if (18..=62).contains(&(at % 80)) { depth } else { 0.0 };
            let heights = (0..pixels.len()).map(|at| 1e-3 + noise(at) - cut(at)).collect();
            HeightMap { pixels, heights }
        };
        let row = |k: usize| LogRow {
            time: 0.05 * k as f64,
            position: DVec3::new(
                10e-3 + 0.5e-3 * (k.clamp(10, 50) - 10) as f64,
                10e-3,
                51e-3 + 1e-3 * if (10..50).contains(&k) { 0.0 } else { 1.0 },
            ),
            force: if (10..50).contains(&k) { 15.0 } else { 0.0 },
            spindle_speed: 600.0,
            approach: DVec3::Z,
        };
        let pass = Pass {
            log: Log { rows: (0..60).map(row).collect(), ..Log::default() },
            scan: PassScan::Heights(scan(3, 10e-6)),
            role: Role::Calibration,
            force_setpoint: 15.0,
            feed: 10e-3,
            spindle_speed: 600.0,
            direction: DVec3::X,
        };
        Trial {
            folder: "plate".into(),
            name: "plate".to_owned(),
            process: Process::Grinding,
            tool: HeldTool::wheel(50e-3, 20e-3, DVec3::Y),
            fresh: false,
            scans: Scans { before: scan(1, 0.0), is_nominal: false, repeats: vec![scan(2, 0.0)], material: None },
            controller: Controller::Ideal,
            force_input: ForceInput::Setpoint,
            frame_errors: FrameErrors::default(),
            frame_offset: FrameOffset::default(),
            coating: None,
            columns: Vec::new(),
            passes: vec![pass],
            notes: Vec::new(),
            findings: Vec::new(),
        }
    }

    #[test]
    fn a_plan_names_what_is_to_be_measured_and_is_read_once_it_is_there() {
        let (plan, measured) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let trial = trial();
        write_plan(&trial, &["Measure before.csv first.".to_owned()], plan.path()).unwrap();
        let text = fs::read_to_string(plan.path().join(TRIAL_FILE)).unwrap();
        assert!(text.starts_with("# Measure before.csv first.\n") && text.contains("fresh = false"), "{text}");
        write_trial(&trial, measured.path()).unwrap();
        for name in ["before.csv", "before_repeat.csv", "pass1_log.csv", "pass1_after.csv"] {
            let error = Trial::read(plan.path()).unwrap_err().to_string();
            assert!(error.contains(name) && error.contains("is not there"), "{name}: {error}");
            fs::copy(measured.path().join(name), plan.path().join(name)).unwrap();
        }
        let (read, made) = (Trial::read(plan.path()).unwrap(), Trial::read(measured.path()).unwrap());
        assert_eq!(read.passes, made.passes);
        let header = fs::read_to_string(plan.path().join("pass1_log_template.csv")).unwrap();
        let path = fs::read_to_string(plan.path().join("pass1_path.csv")).unwrap();
        assert!(path.starts_with(&header) && header.starts_with("t_s,x_mm"), "{header}");
        assert_eq!(path, log_csv(&trial.passes[0].log));
    }
}
