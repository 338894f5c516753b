//! What a study keeps of its work until it ends: the simulations that it made, and its record, in a folder beside its own.

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

/// The simulations.
const SIMULATIONS_FILE: &str = "simulations.bin";
/// The folder beside that of the study.
const KEPT: FolderKind =
    FolderKind { marker: STUDY_FILE, key: "measurements_sha256", names: &[("", &[SIMULATIONS_FILE])] };

/// The work of a study that has not ended.
pub struct Progress {
    folder: PathBuf,
    /// Simulations that an interrupted run had made.
    pub known: usize,
}

impl Progress {
    /// Takes up the work of an interrupted run for the same place, or begins; only for who has claimed the place. Rows
    /// are quick to predict, so that nothing is kept of them. The folder is made for the first simulation.
    ///
    /// # Errors
    /// Wrong use when the place beside holds something else; otherwise when what is there cannot be read or written.
    pub fn take_up(out: &Path, data: &mut Data, measurements_sha256: &str) -> Result<Option<Self>> {
        let Data::Scans(_, evidence) = data else { return Ok(None) };
        let mut name = OsString::from(out.file_name().unwrap_or_default());
        name.push(output::UNFINISHED);
        let folder = out.with_file_name(name);
        KEPT.check_continued(&folder)?;
        // Another build of the program may simulate otherwise.
        let program = Program::of_this_process().map_err(FileError::at(Path::new("the program"), "cannot be found"))?;
        let program = sha256(&input::read(&program.file, MOST_MESH_BYTES)?);
        let journal = Journal::open(&folder.join(SIMULATIONS_FILE), &format!("{measurements_sha256} {program}"))?;
        let known = journal.len();
        evidence.journal = Some(journal);
        Ok(Some(Self { folder, known }))
    }

    /// Where it is kept.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Keeps how far the study is.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn note(&self, record: &StudyRecord) -> Result<()> {
        let file = self.folder.join(STUDY_FILE);
        let text = serde_json::to_string_pretty(record).map_err(FileError::encoding(&file))?;
        Ok(write_file(&file, text.as_bytes())?)
    }

    /// Removes the folder of a study that has ended, if it kept anything.
    ///
    /// # Errors
    /// When the file system refuses.
    pub fn end(self) -> Result<()> {
        match fs::remove_dir_all(&self.folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
            removed => Ok(removed.map_err(FileError::at(&self.folder, "cannot be removed"))?),
        }
    }
}
