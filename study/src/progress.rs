//! Intermediate results of a study until it ends, in a folder beside its own: its simulations and its record.

use std::ffi::OsString;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use files::input::{self, MOST_MESH_BYTES};
use lab::Result;

use super::measurements::Data;
use super::record::{STUDY_FILE, StudyRecord};
use files::FileError;
use files::folder::write_file;
use files::journal::Journal;
use files::output::{self, FolderKind};
use files::program::Program;
use files::sha256;

/// File of the simulations.
const SIMULATIONS_FILE: &str = "simulations.bin";
/// Kind of the folder beside that of the study.
const KEPT: FolderKind =
    FolderKind { marker: STUDY_FILE, key: "measurements_sha256", names: &[("", &[SIMULATIONS_FILE])] };

/// Intermediate results of a study that has not ended.
pub struct Progress {
    folder: PathBuf,
    /// Number of simulations of an interrupted run.
    pub known: usize,
}

impl Progress {
    /// Resumes the work of an interrupted run for the same place, or begins; the caller must have claimed the place.
    /// Predictions of rows are fast, so that none are kept. The folder is created for the first simulation.
    ///
    /// # Errors
    /// Wrong use if the place beside holds something else; otherwise if its contents cannot be read or written.
    pub fn take_up(out: &Path, data: &mut Data, measurements_sha256: &str) -> Result<Option<Self>> {
        let Data::Scans(_, evidence) = data else { return Ok(None) };
        let mut name = OsString::from(out.file_name().unwrap_or_default());
        name.push(output::UNFINISHED);
        let folder = out.with_file_name(name);
        KEPT.check_continued(&folder)?;
        // Another build of the program may give other simulations.
        let program = Program::of_this_process().map_err(FileError::at(Path::new("the program"), "cannot be found"))?;
        let program = sha256(&input::read(&program.file, MOST_MESH_BYTES)?);
        let journal = Journal::open(&folder.join(SIMULATIONS_FILE), &format!("{measurements_sha256} {program}"))?;
        let known = journal.len();
        evidence.journal = Some(journal);
        Ok(Some(Self { folder, known }))
    }

    /// Path of the folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Stores the present record.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn note(&self, record: &StudyRecord) -> Result<()> {
        let file = self.folder.join(STUDY_FILE);
        let text = serde_json::to_string_pretty(record).map_err(FileError::encoding(&file))?;
        Ok(write_file(&file, text.as_bytes())?)
    }

    /// Removes the folder of a study that has ended, if there is one.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn end(self) -> Result<()> {
        match fs::remove_dir_all(&self.folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            removed => Ok(removed.map_err(FileError::at(&self.folder, "cannot be removed"))?),
        }
    }
}
