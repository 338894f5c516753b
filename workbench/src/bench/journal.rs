//! State of a bench on disk, so that nothing is lost when the server ends: `workbench.json`, and one folder for each
//! model with the files that `robofin calibrate` would write.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use effects::Library;
use files::file_lock::{FileLock, LockWait};
use files::folder::write_file;
use files::input::{self, MOST_MESH_BYTES, MOST_TEXT_BYTES};
use files::json_file::{parse_json, read_json};
use files::{FileError, WrongUse};
use lab::{LabError, Result};
use report::study::Sections;
use serde::{Deserialize, Serialize};
use study::CALIBRATION_FILE;

use super::shared::State;
use super::stage::{Record, Stage};
use super::suspects::Suspects;
use super::trail::Trail;

/// File of the journal and its format.
const FILE: &str = "workbench.json";
const FORMAT: &str = "robofin-workbench/1";
/// Files of a model: start values, fitted values, report page, and the sections of the report that the workbench shows.
pub(super) const START_FILE: &str = "start.toml";
const MODEL_FILE: &str = "model.toml";
pub(crate) const PAGE_FILE: &str = "report.html";
const SECTIONS_FILE: &str = "sections.json";
/// Folder of effect files made from typed formulas.
const EFFECTS: &str = "effects";

/// Folder of a bench, locked against other processes.
pub(super) struct Journal {
    folder: PathBuf,
    measured: String,
    _lock: FileLock,
}

/// Content of `workbench.json`.
#[derive(Serialize, Deserialize)]
struct Kept {
    format: String,
    measurements_sha256: String,
    stages: Vec<Record>,
    trail: Trail,
    suspects: Option<Suspects>,
}

/// Content that an earlier run has left.
#[derive(Default)]
pub(super) struct Earlier {
    pub(super) stages: Vec<Arc<Stage>>,
    pub(super) trail: Trail,
    pub(super) suspects: Option<Suspects>,
}

/// Texts of the files of one model.
pub(super) struct Texts<'a> {
    pub(super) start: &'a str,
    pub(super) model: &'a str,
    pub(super) calibration: &'a str,
    pub(super) page: &'a str,
    /// Name and text of the effect file made from a typed formula.
    pub(super) effect: Option<(&'a str, &'a str)>,
}

impl Journal {
    /// Opens the folder of a bench, or creates it.
    ///
    /// # Errors
    /// If the folder is in use, holds unreadable files, or belongs to other measurements.
    pub(super) fn open(folder: &Path, measured: String) -> Result<(Self, Earlier)> {
        fs::create_dir_all(folder).map_err(FileError::at(folder, "cannot be made"))?;
        let Some(lock) = FileLock::take(&folder.join(".workbench.lock"), LockWait::None)? else {
            return Err(refused(format!(
                "{}: another workbench is open on these measurements; close it, or give this one another --out",
                folder.display()
            )));
        };
        let journal = Self { folder: folder.to_owned(), measured, _lock: lock };
        let earlier = if folder.join(FILE).is_file() { journal.earlier()? } else { Earlier::default() };
        Ok((journal, earlier))
    }

    fn earlier(&self) -> Result<Earlier> {
        let file = self.folder.join(FILE);
        let kept: Kept = read_json(&file, "what a workbench keeps")?;
        let shown = file.display();
        if kept.format != FORMAT {
            return Err(refused(format!("{shown}: format {}, and {FORMAT} is accepted", input::quoted(&kept.format))));
        }
        if kept.measurements_sha256 != self.measured {
            return Err(refused(format!(
                "{shown}: was begun with other measurements than the folder holds now; move it away, or give another --out"
            )));
        }
        let in_order = kept.stages.iter().enumerate().all(|(at, record)| record.number == at + 1);
        if !in_order || !kept.trail.is_within(kept.stages.len()) {
            return Err(refused(format!("{shown}: its models are not numbered from 1; move it away")));
        }
        let stage = |record: Record| {
            let file = self.of(record.number).join(SECTIONS_FILE);
            let text = input::read_text(&file, MOST_MESH_BYTES)?;
            let sections: Sections = parse_json(&file, &text, "sections of a report")?;
            Ok(Arc::new(Stage::new(record, sections, None)))
        };
        let stages = kept.stages.into_iter().map(stage).collect::<Result<_>>()?;
        Ok(Earlier { stages, trail: kept.trail, suspects: kept.suspects })
    }

    /// Writes the list of models and the position in the undo history.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn keep(&self, state: &State) -> Result<()> {
        let kept = Kept {
            format: FORMAT.to_owned(),
            measurements_sha256: self.measured.clone(),
            stages: state.stages.iter().map(|stage| stage.record.clone()).collect(),
            trail: state.trail.clone(),
            suspects: state.suspects.clone(),
        };
        let file = self.folder.join(FILE);
        let text = serde_json::to_string_pretty(&kept).map_err(FileError::encoding(&file))?;
        Ok(write_file(&file, text.as_bytes())?)
    }

    /// Writes the files of one model.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub(super) fn write(&self, number: usize, sections: &Sections, texts: &Texts) -> Result<()> {
        let own = self.of(number);
        if let Some((name, text)) = texts.effect {
            write_file(&self.effects_folder().join(format!("{name}.toml")), text.as_bytes())?;
        }
        let files = [
            (START_FILE, texts.start),
            (MODEL_FILE, texts.model),
            (CALIBRATION_FILE, texts.calibration),
            (PAGE_FILE, texts.page),
        ];
        for (name, text) in files {
            write_file(&own.join(name), text.as_bytes())?;
        }
        let file = own.join(SECTIONS_FILE);
        let text = serde_json::to_string(sections).map_err(FileError::encoding(&file))?;
        Ok(write_file(&file, text.as_bytes())?)
    }

    /// Reads the path and text of one model's file: its start values, or its fitted values.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(super) fn model(&self, number: usize, is_fitted: bool) -> Result<(String, String)> {
        let file = self.of(number).join(if is_fitted { MODEL_FILE } else { START_FILE });
        Ok((file.display().to_string(), input::read_text(&file, MOST_TEXT_BYTES).map_err(FileError::from)?))
    }

    /// Returns the library with the effects made from typed formulas added.
    ///
    /// # Errors
    /// If a file is not a valid effect.
    pub(super) fn library(&self, library: &Library) -> Result<Library> {
        let mut files: Vec<(String, String)> = Vec::new();
        for entry in fs::read_dir(self.effects_folder()).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.extension().is_some_and(|end| end == "toml") {
                let text = input::read_text(&path, MOST_TEXT_BYTES).map_err(FileError::from)?;
                files.push((path.display().to_string(), text));
            }
        }
        files.sort();
        Ok(library.with(&files)?)
    }

    /// Returns the folder of effect files made from typed formulas.
    pub(super) fn effects_folder(&self) -> PathBuf {
        self.folder.join(EFFECTS)
    }

    fn of(&self, number: usize) -> PathBuf {
        self.folder.join(number.to_string())
    }
}

fn refused(words: String) -> LabError {
    LabError::File(FileError::from(WrongUse(words)))
}
