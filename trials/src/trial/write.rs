//! Writing of trials: each file in the form that [`Trial::read`](super::Trial::read) accepts.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use files::FileError;
use sdf_bake::HeightMap;
use toml::Spanned;

use super::log::{APPROACH_COLUMNS, Log, REQUIRED_COLUMNS, RPM, TEMPERATURE_COLUMN};
use super::manifest::{
    CoatingTable, ColumnEntry, ControllerKind, ControllerTable, Manifest, PassTable, RobotTable, ScanTable, TRIAL_FILE,
    TRIAL_FORMAT, ToolKind, ToolTable,
};
use super::scan::Mirror;
use super::{ExposureMask, ForceInput, FrameErrors, HeldTool, LabelMap, Pass, QuantitySource, Trial, TrialColumn};
use crate::column_unit::named_unit;
use robot::{Controller, Tool};

/// A number rounded to six decimals.
fn number(value: f64) -> f64 {
    // Adding zero turns -0 into 0.
    (value * 1e6).round() / 1e6 + 0.0
}

fn rows<T>(values: &[T], nx: usize, mut cell: impl FnMut(&mut String, &T)) -> String {
    let mut text = String::with_capacity(8 * values.len());
    for row in values.chunks_exact(nx) {
        for (i, value) in row.iter().enumerate() {
            if i > 0 {
                text.push(',');
            }
            cell(&mut text, value);
        }
        text.push('\n');
    }
    text
}

/// A height map as a plain grid in millimetres, to a nanometre.
pub fn heights_csv(map: &HeightMap) -> String {
    rows(&map.heights, map.pixels.nx, |text, height| {
        if height.is_finite() {
            let _ = write!(text, "{}", number(height * 1e3));
        }
    })
}

/// An exposure mask: 1 exposed, 0 coated, empty unknown.
pub fn exposure_csv(mask: &ExposureMask) -> String {
    rows(&mask.exposed, mask.pixels.nx, |text, exposed| {
        if let Some(exposed) = exposed {
            text.push(if *exposed { '1' } else { '0' });
        }
    })
}

/// A label map.
pub fn labels_csv(map: &LabelMap) -> String {
    rows(&map.labels, map.pixels.nx, |text, label| {
        let _ = write!(text, "{label}");
    })
}

/// Header of a log: the names of all its columns.
pub(super) fn log_header(log: &Log) -> String {
    let mut header: Vec<&str> = REQUIRED_COLUMNS.to_vec();
    if log.has_approach {
        header.extend(APPROACH_COLUMNS);
    }
    if !log.temperature.is_empty() {
        header.push(TEMPERATURE_COLUMN);
    }
    header.extend(log.covariates.iter().map(|covariate| covariate.name.as_str()));
    header.join(",") + "\n"
}

/// A log with all its columns; times and forces to a millionth, lengths to a nanometre.
pub fn log_csv(log: &Log) -> String {
    let mut text = log_header(log);
    for (k, row) in log.rows.iter().enumerate() {
        let p = row.position * 1e3;
        let mut values = vec![row.time, p.x, p.y, p.z, row.force, row.spindle_speed / RPM];
        if log.has_approach {
            values.extend(row.approach.to_array());
        }
        values.extend(log.temperature.get(k));
        values.extend(log.covariates.iter().map(|covariate| covariate.values[k]));
        let cells: Vec<String> = values.into_iter().map(cell).collect();
        text += &cells.join(",");
        text.push('\n');
    }
    text
}

/// A number, or an empty text if it is not finite.
fn cell(value: f64) -> String {
    if value.is_nan() { String::new() } else { number(value).to_string() }
}

/// Writes a trial into an existing folder: `trial.toml` and the files that it names.
///
/// # Errors
/// A file that cannot be written.
pub fn write_trial(trial: &Trial, folder: &Path) -> Result<(), FileError> {
    let manifest = manifest_of(trial);
    let put = |name: &Path, text: String| {
        let place = folder.join(name);
        fs::write(&place, text).map_err(FileError::at(&place, "cannot write this file"))
    };
    put(manifest.scan.first_name(), heights_csv(&trial.scans.before))?;
    for (name, repeat) in manifest.scan.repeat.iter().zip(&trial.scans.repeats) {
        put(name.get_ref(), heights_csv(repeat))?;
    }
    if let (Some(name), Some(material)) = (&manifest.scan.material, &trial.scans.material) {
        put(name.get_ref(), labels_csv(material))?;
    }
    for (table, pass) in manifest.pass.iter().zip(&trial.passes) {
        put(table.log.get_ref(), log_csv(&pass.log))?;
        if let Some(name) = &table.scan {
            put(name.get_ref(), pass.scan.csv())?;
        }
    }
    let text = toml::to_string(&manifest).map_err(FileError::encoding(&folder.join(TRIAL_FILE)))?;
    put(Path::new(TRIAL_FILE), text)
}

/// A value without a place in a file, for writing.
fn plain<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

fn millimetres(length: f64) -> Spanned<f64> {
    plain(number(length * 1e3))
}

/// The robot's table; `None` if all values are the defaults.
fn robot_table(trial: &Trial) -> Option<RobotTable> {
    let FrameErrors { shift, yaw, lag } = trial.frame_errors;
    (trial.frame_errors != FrameErrors::default()).then(|| RobotTable {
        frame_sigma_mm: Some(plain(number(shift * 1e3))),
        yaw_sigma_mrad: Some(plain(number(yaw * 1e3))),
        clock_sigma_s: Some(plain(lag)),
    })
}

pub(super) fn manifest_of(trial: &Trial) -> Manifest {
    let pixels = &trial.scans.before.pixels;
    let repeat = |k: usize| match k {
        0 => "before_repeat.csv".into(),
        k => format!("before_repeat{}.csv", k + 1).into(),
    };
    Manifest {
        format: plain(TRIAL_FORMAT.to_owned()),
        name: trial.name.clone(),
        process: trial.process,
        tool: tool_table(trial),
        scan: ScanTable {
            // Over thousands of pixels, a rounding of the pitch to a nanometre would add up to a micrometre.
            pitch_mm: Some(plain((pixels.pitch * 1e12).round() / 1e9)),
            origin_mm: Some(plain([number(pixels.origin.x * 1e3), number(pixels.origin.y * 1e3)])),
            mirror: Mirror::None,
            before: (!trial.scans.is_nominal).then(|| plain("before.csv".into())),
            nominal: trial.scans.is_nominal.then(|| plain("nominal.csv".into())),
            repeat: (0..trial.scans.repeats.len()).map(|k| plain(repeat(k))).collect(),
            material: trial.scans.material.as_ref().map(|_| plain("material.csv".into())),
        },
        log: None,
        robot: robot_table(trial),
        controller: controller_table(trial).map(plain),
        coating: trial.coating.map(|thickness| CoatingTable { thickness_mm: millimetres(thickness) }),
        columns: trial.columns.iter().filter_map(column_entry).collect(),
        pass: trial.passes.iter().enumerate().map(|(k, pass)| pass_table(k + 1, pass)).collect(),
    }
}

/// Entry of a quantity in `[columns]`; `None` if its name in the logs contains everything.
fn column_entry(column: &TrialColumn) -> Option<(String, Spanned<ColumnEntry>)> {
    let (name, text) = match &column.given {
        QuantitySource::Temperature => return None,
        QuantitySource::Logs(header) if named_unit(header).1 == column.unit => return None,
        QuantitySource::Logs(header) => (header, column.unit.clone()),
        QuantitySource::Trial(value) => {
            let (unit, zero) = column.scale;
            (&column.name, format!("{} {}", number((value - zero) / unit), column.unit))
        }
    };
    Some((name.clone(), plain(ColumnEntry::Text(text))))
}

fn tool_table(trial: &Trial) -> ToolTable {
    let HeldTool { shape, axis } = &trial.tool;
    let kind = if matches!(shape, Tool::Wheel(_)) { ToolKind::Wheel } else { ToolKind::Pad };
    ToolTable {
        kind: plain(kind),
        radius_mm: millimetres(shape.rim_radius()),
        width_mm: axis.map(|_| millimetres(shape.width())),
        axis: axis.map(|axis| plain(axis.to_array())),
        fresh: trial.fresh,
    }
}

/// The table of a trial's controller; `None` if the log is replayed.
fn controller_table(trial: &Trial) -> Option<ControllerTable> {
    match trial.controller {
        Controller::Ideal => {
            let kind = match trial.force_input {
                ForceInput::Setpoint => ControllerKind::Ideal,
                ForceInput::Log => ControllerKind::LoggedForce,
            };
            Some(ControllerTable { kind, mass_kg: None, damping_ns_m: None, period_s: None })
        }
        Controller::Admittance { mass, damping, period } => Some(ControllerTable {
            kind: ControllerKind::Admittance,
            mass_kg: Some(plain(mass)),
            damping_ns_m: Some(plain(damping)),
            period_s: Some(plain(period)),
        }),
        Controller::Replay => None,
    }
}

fn pass_table(number_of_pass: usize, pass: &Pass) -> PassTable {
    let name = |rest: &str| -> Spanned<PathBuf> { plain(format!("pass{number_of_pass}_{rest}.csv").into()) };
    PassTable {
        log: name("log"),
        time_s: None,
        scan: (!pass.scan.is_missing()).then(|| name(pass.scan.file_word())),
        role: pass.role,
        force_setpoint_n: Some(plain(pass.force_setpoint)),
        feed_mm_s: Some(plain(number(pass.feed * 1e3))),
        spindle_rpm: Some(plain(number(pass.spindle_speed / RPM))),
        direction: Some(plain(pass.direction.to_array())),
    }
}
