//! A virtual campaign on disk, with its answer open or sealed.

use std::fs;
use std::path::{Path, PathBuf};

use effects::Process;
use files::input::{self, MOST_MESH_BYTES, MOST_TEXT_BYTES};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use thiserror::Error;

use super::answer::Answer;
use super::seal::{Key, Seal, SealError};
use super::{Experiment, Made};
use files::folder::{StagedFile, StagedFolder};
use files::json_file::write_json;
use files::json_file::{parse_json, read_json};
use files::output::{FileKind, FolderKind, OutputPath};
use files::{FileError, WrongUse, sha256};
use trials::trial::write_trial;

/// File that marks a campaign of the laboratory and states how it was made, without the hidden effects.
pub const LABORATORY_FILE: &str = "laboratory.json";
/// File of the open answer.
pub const ANSWER_FILE: &str = "answers.json";
/// File of the sealed answer.
pub const SEAL_FILE: &str = "sealed.json";

/// Files of a campaign of the laboratory.
pub const CAMPAIGN_NAMES: &[&str] = &[
    LABORATORY_FILE,
    ANSWER_FILE,
    SEAL_FILE,
    "trial-*/trial.toml",
    "trial-*/before.csv",
    "trial-*/before_repeat*.csv",
    "trial-*/material.csv",
    "trial-*/pass*_log.csv",
    "trial-*/pass*_after.csv",
    "trial-*/pass*_exposed.csv",
];
/// Kind of the folder of such a campaign.
const CAMPAIGN: FolderKind = FolderKind { marker: LABORATORY_FILE, key: "plan", names: &[("", CAMPAIGN_NAMES)] };
/// Kind of the key file beside it.
const KEY: FileKind = FileKind { what: "a key", is_own: is_key };

fn is_key(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|file| file.len() <= Key::MOST_BYTES)
        && fs::read_to_string(file).is_ok_and(|text| Key::parse(&text).is_ok())
}

/// Claimed places of a campaign, taken before any work is done.
pub struct Places {
    folder: StagedFolder,
    key: Option<StagedFile>,
}

impl Places {
    /// Claims the folder, and the place of the key beside it if the answer is sealed.
    ///
    /// # Errors
    /// Wrong use if a place holds something that may not be replaced; otherwise if it cannot be written.
    pub fn take(out: &OutputPath, sealed: bool) -> Result<Self, WriteError> {
        let folder = StagedFolder::new(out, &CAMPAIGN)?;
        let key = key_place(out.place);
        let key = sealed.then(|| StagedFile::new(&OutputPath { place: &key, ..*out }, &KEY)).transpose()?;
        Ok(Self { folder, key })
    }
}

/// An answer with the hash of its measurements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KeptAnswer {
    /// SHA-256 of all names and contents of the trials' files in order.
    pub measurements_sha256: String,
    /// The answer.
    #[serde(flatten)]
    pub answer: Answer,
}

/// Public description of a campaign, without the hidden effects.
#[derive(Serialize)]
struct Laboratory<'a> {
    format: &'static str,
    version: &'static str,
    process: Process,
    plan: super::Plan,
    size: super::Size,
    trials: usize,
    answer: &'a str,
}

/// Path of the key file beside a campaign's folder.
pub fn key_place(folder: &Path) -> PathBuf {
    let mut name = folder.file_name().unwrap_or_default().to_owned();
    name.push(".key");
    folder.with_file_name(name)
}

/// Writes a campaign.
///
/// - `key`: seals the answer; the key goes to [`key_place`]
///
/// # Errors
/// Wrong use if a place is taken and `force` is not set; otherwise if a file cannot be written.
pub fn write(
    made: &Made,
    experiment: &Experiment,
    folder: &Path,
    key: Option<Key>,
    force: bool,
) -> Result<(), WriteError> {
    let out = OutputPath { place: folder, force, inputs: &[] };
    write_into(made, experiment, Places::take(&out, key.is_some())?, key)
}

/// Writes a campaign to places that were claimed before.
///
/// - `key`: seals the answer; it goes to its place beside the folder
///
/// # Errors
/// If a file cannot be written.
pub fn write_into(made: &Made, experiment: &Experiment, places: Places, key: Option<Key>) -> Result<(), WriteError> {
    let place = places.folder.path();
    for trial in &made.trials {
        let folder = place.join(&trial.name);
        fs::create_dir(&folder).map_err(FileError::at(&folder, "cannot make this folder"))?;
        write_trial(trial, &folder)?;
    }
    let kept = KeptAnswer { measurements_sha256: measurements(place)?, answer: made.answer.clone() };
    let answer_file = if key.is_some() { SEAL_FILE } else { ANSWER_FILE };
    match key {
        Some(key) => write_json(&place.join(SEAL_FILE), &Seal::new(&serde_json::to_string_pretty(&kept)?, key))?,
        None => write_json(&place.join(ANSWER_FILE), &kept)?,
    }
    let laboratory = Laboratory {
        format: "robofin-virtual-laboratory/1",
        version: env!("CARGO_PKG_VERSION"),
        process: experiment.process,
        plan: experiment.plan,
        size: experiment.size,
        trials: made.trials.len(),
        answer: answer_file,
    };
    write_json(&place.join(LABORATORY_FILE), &laboratory)?;
    // The key first: a seal without it could never be opened.
    if let (Some(file), Some(key)) = (places.key, key) {
        file.commit(key.text().as_bytes())?;
    }
    places.folder.commit()?;
    Ok(())
}

/// Reason for which a campaign cannot be written, or its seal cannot be opened.
#[derive(Debug, Error)]
pub enum WriteError {
    /// A file or a place cannot be used.
    #[error(transparent)]
    File(#[from] FileError),
    /// The seal does not open.
    #[error("{}", place.display())]
    Seal {
        /// Path of the sealed answer.
        place: PathBuf,
        /// Cause.
        source: SealError,
    },
    /// An answer cannot be written as JSON.
    #[error("the answer cannot be written as JSON")]
    Json(#[from] serde_json::Error),
}

/// An opened seal.
pub struct Unsealed {
    /// The sealed answer.
    pub answer: Value,
    /// True if the measurements are those with which it was sealed.
    pub measurements_unchanged: bool,
}

/// Opens the sealed answer of a campaign and checks its measurements.
///
/// # Errors
/// Wrong use if the folder or the key file holds something else; otherwise if the key does not open the seal.
pub fn unseal(folder: &Path, key_file: &Path) -> Result<Unsealed, WriteError> {
    let place = folder.join(SEAL_FILE);
    if !place.is_file() {
        let open = folder.join(ANSWER_FILE).is_file();
        let hint = if open { format!("; its answer is in {ANSWER_FILE}, not encrypted") } else { String::new() };
        return Err(wrong_use(format!(
            "{}: no {SEAL_FILE} here{hint}; a folder made by `robofin trial synth --sealed` is expected",
            folder.display()
        )));
    }
    if !key_file.is_file() {
        return Err(wrong_use(format!("--key {}: no such file", key_file.display())));
    }
    let text = input::read_text(key_file, MOST_TEXT_BYTES).map_err(FileError::from)?;
    let key = Key::parse(&text).map_err(|error| wrong_use(format!("--key {}: {error}", key_file.display())))?;
    let seal: Seal = read_json(&place, "a sealed answer")?;
    let answer: Value = parse_json(
        &place,
        &seal.open(key).map_err(|source| WriteError::Seal { place: place.clone(), source })?,
        "an answer",
    )?;
    let measurements_unchanged = answer["measurements_sha256"] == measurements(folder)?.as_str();
    Ok(Unsealed { answer, measurements_unchanged })
}

/// SHA-256 over names and contents of all files in the folders of a campaign, in the order of their names.
fn measurements(folder: &Path) -> Result<String, WriteError> {
    let list = |folder: &Path| -> Result<Vec<PathBuf>, FileError> {
        let failed = || FileError::at(folder, "cannot be listed");
        let entries = fs::read_dir(folder).map_err(failed())?;
        let mut places: Vec<PathBuf> =
            entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>().map_err(failed())?;
        places.sort();
        Ok(places)
    };
    let mut lines = String::new();
    for trial in list(folder)?.into_iter().filter(|place| place.is_dir()) {
        for file in list(&trial)? {
            let name = file.strip_prefix(folder).unwrap_or(&file).display().to_string().replace('\\', "/");
            let bytes = input::read(&file, MOST_MESH_BYTES).map_err(FileError::from)?;
            lines += &format!("{} {name}\n", sha256(&bytes));
        }
    }
    Ok(sha256(lines.as_bytes()))
}

fn wrong_use(message: String) -> WriteError {
    FileError::from(WrongUse(message)).into()
}
