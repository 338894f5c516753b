//! A small trial in a temporary folder, to be read and damaged.

use std::fs;
use std::path::{Path, PathBuf};

use effects::Process;
use glam::{DVec2, DVec3};
use robot::{Controller, LogRow};
use sdf_bake::{HeightMap, PixelGrid};
use tempfile::TempDir;
use trials::trial::{
    Covariate, ExposureMask, ForceInput, FrameErrors, FrameOffset, HeldTool, LabelMap, Log, Pass, PassScan, RPM, Role,
    Scans, Trial, TrialError, write_trial,
};

const RADIUS: f64 = 0.05;

pub(crate) fn pixels() -> PixelGrid {
    PixelGrid { origin: DVec2::new(0.0, -0.004), pitch: 0.25e-3, nx: 61, ny: 33 }
}

/// Returns the height of a bead along x, 6 mm wide and 1.5 mm high.
pub(crate) fn bead(place: DVec2) -> f64 {
    (1.5e-3 * (1.0 - (place.y / 3e-3).powi(2))).max(0.0)
}

/// Makes heights rounded to a micrometre with a few holes, as an instrument does.
fn scan(lowered: f64) -> HeightMap {
    let mut map = HeightMap::from_function(pixels(), |p| ((bead(p) - lowered).max(0.0) * 1e6).round() * 1e-6);
    for hole in [0, 5, 700, 701] {
        map.heights[hole] = f64::NAN;
    }
    map
}

/// Makes a log: down to the crown, 10 mm along it at 5 mm/s, up again.
fn log() -> Log {
    let row = |k: i32| {
        let time = 0.02 * f64::from(k);
        let along = (time - 0.2).clamp(0.0, 2.0);
        let lift = 1e-3 * ((0.2 - time).max(0.0) + (time - 2.2).max(0.0));
        let touching = lift == 0.0;
        LogRow {
            time,
            position: DVec3::new(0.002 + 0.005 * along, 0.0, RADIUS + 1.5e-3 + lift),
            force: if touching { 15.0 + 0.01 * f64::from(k % 7) } else { 0.01 * f64::from(k % 3) },
            spindle_speed: 6000.0 * RPM,
            approach: DVec3::Z,
        }
    };
    let rows: Vec<LogRow> = (0..121).map(row).collect();
    let covariates = vec![Covariate {
        name: "current_a".into(),
        values: (0..121).map(|k| f64::from(k) * 0.5).collect(),
        hole: None,
    }];
    Log { temperature: vec![f64::NAN; rows.len()], rows, has_approach: true, covariates }
}

pub(crate) fn grinding() -> Trial {
    let pass = Pass {
        log: log(),
        scan: PassScan::Heights(scan(50e-6)),
        role: Role::Evaluation,
        force_setpoint: 15.0,
        feed: 0.005,
        spindle_speed: 6000.0 * RPM,
        direction: DVec3::X,
    };
    let labels = (0..pixels().len()).map(|k| u16::from(k / 61 > 10 && k / 61 < 22)).collect();
    Trial {
        folder: PathBuf::new(),
        name: "plate-01".into(),
        process: Process::Grinding,
        tool: HeldTool::wheel(RADIUS, 0.02, DVec3::Y),
        fresh: true,
        scans: Scans {
            is_nominal: false,
            before: scan(0.0),
            repeats: vec![scan(1e-6)],
            material: Some(LabelMap { pixels: pixels(), labels }),
        },
        controller: Controller::Admittance { mass: 2.0, damping: 1500.0, period: 5e-4 },
        force_input: ForceInput::Setpoint,
        frame_errors: FrameErrors::default(),
        frame_offset: FrameOffset::default(),
        coating: None,
        passes: vec![pass],
        columns: Vec::new(),
        notes: Vec::new(),
        findings: Vec::new(),
    }
}

pub(crate) fn sanding() -> Trial {
    let exposed = (0..pixels().len()).map(|k| (k % 17 != 0).then_some(k % 3 == 0)).collect();
    let mut trial = grinding();
    trial.process = Process::Sanding;
    trial.tool = HeldTool::pad(0.004);
    trial.controller = Controller::Ideal;
    trial.coating = Some(60e-6);
    for row in &mut trial.passes[0].log.rows {
        row.position.z -= RADIUS;
    }
    trial.passes[0].scan = PassScan::Exposure(ExposureMask { pixels: pixels(), exposed });
    trial
}

/// Writes a folder with the grinding trial.
pub(crate) fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a temporary folder");
    write_trial(&grinding(), folder.path()).expect("the trial is written");
    folder
}

/// Changes a file of a folder.
pub(crate) fn edit(folder: &Path, name: &str, change: impl FnOnce(String) -> String) {
    let place = folder.join(name);
    let text = fs::read_to_string(&place).expect("a text file");
    fs::write(place, change(text)).expect("the changed file");
}

/// Asserts that the trial of a folder is refused with all of these words; returns the message.
#[track_caller]
pub(crate) fn refused(folder: &Path, words: &[&str]) -> String {
    let error: TrialError = Trial::read(folder).expect_err("the trial must be refused");
    let message = error.to_string();
    for word in words {
        assert!(message.contains(word), "{word:?} is missing in: {message}");
    }
    message
}

/// Asserts that the trial of a folder is read, and that one of its notes contains all of these words.
#[track_caller]
pub(crate) fn noted(folder: &Path, words: &[&str]) -> Trial {
    let trial = Trial::read(folder).expect("the trial can be read");
    let holds = |note: &String| words.iter().all(|word| note.contains(word));
    assert!(trial.notes.iter().any(holds), "{words:?} is missing in {:?}", trial.notes);
    trial
}
