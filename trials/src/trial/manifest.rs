//! Contents of `trial.toml`, in its units.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use effects::Process;
use files::input::{self, MOST_TEXT_BYTES, quoted_near, without_content};
use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use files::named_file::{self, NamedFileError};

use super::error::{Place, TrialError};
use super::scan::Mirror;

/// Value of the `format` key.
pub const TRIAL_FORMAT: &str = "finishing-trial/1";
/// Name of the file that makes a folder a trial.
pub const TRIAL_FILE: &str = "trial.toml";

/// The table with user-defined keys.
const COLUMNS: &str = "columns";
/// Known keys of each other table.
const KEYS: [(&str, &[&str]); 8] = [
    ("", &["format", "name", "process", "tool", "scan", "log", "robot", "controller", "coating", "columns", "pass"]),
    ("tool", &["kind", "radius_mm", "width_mm", "axis", "fresh"]),
    ("scan", &["pitch_mm", "origin_mm", "mirror", "before", "nominal", "repeat", "material"]),
    ("log", &["columns", "offset_mm", "yaw_deg"]),
    ("robot", &["frame_sigma_mm", "yaw_sigma_mrad", "clock_sigma_s"]),
    ("controller", &["kind", "mass_kg", "damping_ns_m", "period_s"]),
    ("coating", &["thickness_mm"]),
    ("pass", &["log", "time_s", "scan", "role", "force_setpoint_n", "feed_mm_s", "spindle_rpm", "direction"]),
];

/// Split of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Calibration: the pass is fitted.
    #[default]
    Calibration,
    /// Evaluation: the pass is held out.
    Evaluation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum ToolKind {
    Wheel,
    Pad,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ControllerKind {
    Admittance,
    Ideal,
    LoggedForce,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Manifest {
    pub(super) format: Spanned<String>,
    pub(super) name: String,
    pub(super) process: Process,
    pub(super) tool: ToolTable,
    pub(super) scan: ScanTable,
    #[serde(skip_serializing)]
    pub(super) log: Option<LogTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) robot: Option<RobotTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) controller: Option<Spanned<ControllerTable>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) coating: Option<CoatingTable>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) columns: BTreeMap<String, Spanned<ColumnEntry>>,
    #[serde(default)]
    pub(super) pass: Vec<PassTable>,
}

/// An entry of `[columns]`: the unit of a column of the logs, or a value of the whole trial.
#[derive(Debug, Serialize, Deserialize)]
#[serde(untagged, expecting = "a unit, or a value with its unit, in quotes is expected")]
pub(super) enum ColumnEntry {
    Text(String),
    Number(f64),
}

/// Columns and frame of logs in other formats than the project's own.
#[derive(Debug, Deserialize)]
pub(super) struct LogTable {
    /// The channel of each quantity.
    pub(super) columns: BTreeMap<String, Spanned<ChannelEntry>>,
    /// Position of the log's origin in the frame of the scans.
    pub(super) offset_mm: Option<[f64; 3]>,
    /// Rotation of the log's frame about z, before the offset.
    pub(super) yaw_deg: Option<f64>,
}

/// Prior standard deviations of the errors of the robot's frame and clock.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct RobotTable {
    pub(super) frame_sigma_mm: Option<Spanned<f64>>,
    pub(super) yaw_sigma_mrad: Option<Spanned<f64>>,
    pub(super) clock_sigma_s: Option<Spanned<f64>>,
}

/// A channel of a log: its name and, if given, its unit, sign, gain, zero and delay.
#[derive(Clone, Debug, Deserialize)]
#[serde(from = "ChannelText")]
pub(super) struct ChannelEntry {
    pub(super) column: String,
    unit: Option<String>,
    /// −1 inverts the values.
    pub(super) sign: Option<f64>,
    /// True change per change of the reading.
    pub(super) gain: Option<f64>,
    /// Reading at zero load, in the file's unit.
    pub(super) zero: Option<f64>,
    /// Delay of the reading.
    pub(super) lag_s: Option<f64>,
}

#[derive(Deserialize)]
#[serde(untagged, expecting = "the name of a column, or { column = \"NAME\", unit = \"mm\" }, is expected")]
enum ChannelText {
    Name(String),
    #[serde(rename_all = "snake_case")]
    Channel {
        column: String,
        unit: Option<String>,
        sign: Option<f64>,
        gain: Option<f64>,
        zero: Option<f64>,
        lag_s: Option<f64>,
    },
}

impl From<ChannelText> for ChannelEntry {
    fn from(text: ChannelText) -> Self {
        match text {
            ChannelText::Name(column) => Self { column, unit: None, sign: None, gain: None, zero: None, lag_s: None },
            ChannelText::Channel { column, unit, sign, gain, zero, lag_s } => {
                Self { column, unit, sign, gain, zero, lag_s }
            }
        }
    }
}

impl ChannelEntry {
    /// The unit of its values, if given.
    pub(super) fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ToolTable {
    pub(super) kind: Spanned<ToolKind>,
    pub(super) radius_mm: Spanned<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) width_mm: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) axis: Option<Spanned<[f64; 3]>>,
    #[serde(default = "fresh")]
    pub(super) fresh: bool,
}

fn fresh() -> bool {
    true
}

fn is_not_mirrored(mirror: &Mirror) -> bool {
    *mirror == Mirror::None
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ScanTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) pitch_mm: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) origin_mm: Option<Spanned<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "is_not_mirrored")]
    pub(super) mirror: Mirror,
    /// Scan before the first pass.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) before: Option<Spanned<PathBuf>>,
    /// Instead of a scan before the first pass: the surface as drawn, a file or the word `plane`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) nominal: Option<Spanned<PathBuf>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(super) repeat: Vec<Spanned<PathBuf>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) material: Option<Spanned<PathBuf>>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct ControllerTable {
    pub(super) kind: ControllerKind,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mass_kg: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) damping_ns_m: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) period_s: Option<Spanned<f64>>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct CoatingTable {
    pub(super) thickness_mm: Spanned<f64>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(super) struct PassTable {
    pub(super) log: Spanned<PathBuf>,
    /// First and last time of the log's rows that belong to the pass; absent if all do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) time_s: Option<Spanned<[f64; 2]>>,
    /// Scan after the pass; absent if there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) scan: Option<Spanned<PathBuf>>,
    #[serde(default)]
    pub(super) role: Role,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) force_setpoint_n: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) feed_mm_s: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) spindle_rpm: Option<Spanned<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) direction: Option<Spanned<[f64; 3]>>,
}

/// The text of a `trial.toml` or `table.toml`, for errors with a place in it.
pub(crate) struct Source {
    pub(crate) file: PathBuf,
    pub(crate) text: String,
}

impl Source {
    /// Reads a file.
    pub(crate) fn read(file: PathBuf) -> Result<Self, TrialError> {
        let bytes = input::read(&file, MOST_TEXT_BYTES)?;
        let text = String::from_utf8(bytes).map_err(|error| {
            Place::file(&file).bad::<TrialError>(
                format!("byte {} is not UTF-8", error.utf8_error().valid_up_to()),
                "UTF-8 text is expected",
            )
        })?;
        let text = text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text);
        Ok(Self { file, text })
    }

    /// Parses the manifest.
    pub(super) fn manifest(&self) -> Result<Manifest, TrialError> {
        self.check_keys()?;
        let manifest: Manifest = toml::from_str(&self.text).map_err(|error| self.toml_error(&error))?;
        if manifest.format.get_ref() != TRIAL_FORMAT {
            let found = format!("format is {}", quoted_near(manifest.format.get_ref(), [TRIAL_FORMAT]));
            return Err(self.bad(manifest.format.span(), found, format!("{TRIAL_FORMAT:?} is expected")));
        }
        Ok(manifest)
    }

    /// An error at a span of the text: the value found and the values accepted.
    pub(crate) fn bad(&self, at: Range<usize>, found: impl Into<String>, accepted: impl Into<String>) -> TrialError {
        Place::of_byte(&self.file, &self.text, at.start).bad(found, accepted)
    }

    /// The path of a file that the text names.
    pub(crate) fn named(&self, folder: &Path, name: &Spanned<PathBuf>) -> Result<PathBuf, TrialError> {
        let shown = || folder.join(name.get_ref()).display().to_string();
        named_file::place(folder, name.get_ref()).map_err(|absent| match absent {
            NamedFileError::Missing => {
                let found = format!("{} is not there", shown());
                self.bad(name.span(), found, "the name of a file in the folder of this file is expected")
            }
            NamedFileError::Outside => {
                let found = format!("{} lies outside the folder of this file", shown());
                self.bad(name.span(), found, "a file in that folder, or --allow-outside, is expected")
            }
        })
    }

    fn toml_error(&self, error: &toml::de::Error) -> TrialError {
        let accepted = format!("a file of format {TRIAL_FORMAT:?} is expected");
        let message = without_content(&error.message().trim().replace('\n', ", "));
        match error.span() {
            Some(span) => self.bad(span, message, accepted),
            None => Place::file(&self.file).bad(message, accepted),
        }
    }

    /// Refuses unknown keys, and names the nearest known one.
    fn check_keys(&self) -> Result<(), TrialError> {
        let table = DeTable::parse(&self.text).map_err(|error| self.toml_error(&error))?;
        self.check_table("", table.get_ref())?;
        for (name, value) in table.get_ref() {
            match value.get_ref() {
                DeValue::Table(inner) => self.check_table(name.get_ref(), inner)?,
                DeValue::Array(list) => {
                    for inner in list.iter().filter_map(|item| item.get_ref().as_table()) {
                        self.check_table(name.get_ref(), inner)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn check_table(&self, name: &str, table: &DeTable) -> Result<(), TrialError> {
        if name == COLUMNS {
            return Ok(());
        }
        let known = KEYS.iter().find(|(table, _)| *table == name).map_or(&[][..], |(_, keys)| keys);
        for (key, _) in table {
            if known.contains(&key.get_ref().as_ref()) {
                continue;
            }
            let place = if name.is_empty() { String::new() } else { format!(" in [{name}]") };
            let accepted = match nearest(key.get_ref(), known.iter().copied()) {
                Some(near) => format!("did you mean {near:?}? Accepted are {}", known.join(", ")),
                None => format!("accepted are {}", known.join(", ")),
            };
            let shown = quoted_near(key.get_ref(), known.iter().copied());
            return Err(self.bad(key.span(), format!("unknown key {shown}{place}"), accepted));
        }
        Ok(())
    }
}

/// The candidate that a mistyped word most likely means, if any is close.
pub(crate) fn nearest<'a>(word: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |candidate: &str| {
        let (a, b) = (word.to_lowercase(), candidate.to_lowercase());
        let contained = !b.is_empty() && (a.starts_with(&b) || b.starts_with(&a));
        strsim::jaro_winkler(&a, &b).max(if contained { 0.9 } else { 0.0 })
    };
    let scored = candidates.map(|candidate| (likeness(candidate), candidate));
    scored.filter(|(score, _)| *score > 0.8).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}
