//! Output that is either complete or absent: it is written beside its final path under a temporary name, then renamed.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{FileError, wrong_use};
use crate::output::{FileKind, FolderKind, OutputPath, is_occupied};
use crate::staging::Staging;

const WRITE: &str = "cannot write this file";

/// An output folder in progress. Dropped without [`StagedFolder::commit`], it leaves nothing behind.
pub struct StagedFolder {
    staging: Staging,
    replace: Option<&'static FolderKind>,
}

/// An output file in progress. Dropped without [`StagedFile::commit`], it leaves nothing behind.
pub struct StagedFile {
    staging: Staging,
    replace: Option<&'static FileKind>,
}

impl StagedFolder {
    /// Starts a folder of a kind. From then on no other run can write the same path.
    ///
    /// # Errors
    /// Wrong usage if the path holds something that may not be replaced; other errors if another run is writing it, or
    /// the parent folder cannot be written.
    pub fn new(out: &OutputPath, kind: &'static FolderKind) -> Result<Self, FileError> {
        out.check_folder(kind)?;
        let staging = Staging::folder(&absolute(out.place)?)?;
        // A killed run may have left the previous output under another name; it has been restored by now.
        out.check_folder(kind)?;
        Ok(Self { staging, replace: out.force.then_some(kind) })
    }

    /// Starts a folder where none exists.
    ///
    /// # Errors
    /// As for [`StagedFolder::new`].
    pub fn fresh(target: &Path) -> Result<Self, FileError> {
        refuse_occupied(target)?;
        Ok(Self { staging: Staging::folder(&absolute(target)?)?, replace: None })
    }

    /// Temporary path of the folder.
    pub fn path(&self) -> &Path {
        self.staging.path()
    }

    /// Moves the finished folder to its final path; a replaced one is removed only afterwards.
    ///
    /// # Errors
    /// If something else was put there in the meantime, or the file system refuses a rename; the old folder is kept
    /// then.
    pub fn commit(self) -> Result<PathBuf, FileError> {
        let target = self.staging.target().to_owned();
        if let Some(kind) = self.replace {
            OutputPath { place: &target, force: true, inputs: &[] }.check_folder(kind)?;
        }
        self.staging.commit(self.replace.is_some())?;
        Ok(target)
    }
}

impl StagedFile {
    /// Starts a file of a kind. From then on no other run can write the same path.
    ///
    /// # Errors
    /// As for [`StagedFolder::new`].
    pub fn new(out: &OutputPath, kind: &'static FileKind) -> Result<Self, FileError> {
        out.check_file(kind)?;
        let staging = Staging::file(&absolute(out.place)?)?;
        Ok(Self { staging, replace: out.force.then_some(kind) })
    }

    /// Writes the file and moves it to its final path.
    ///
    /// # Errors
    /// As for [`StagedFolder::commit`].
    pub fn commit(self, bytes: &[u8]) -> Result<(), FileError> {
        let target = self.staging.target().to_owned();
        fs::write(self.staging.path(), bytes).map_err(FileError::at(&target, WRITE))?;
        match self.replace {
            Some(kind) => OutputPath { place: &target, force: true, inputs: &[] }.check_file(kind)?,
            None => refuse_occupied(&target)?,
        }
        self.staging.commit(false)
    }
}

fn absolute(place: &Path) -> Result<PathBuf, FileError> {
    let place = std::path::absolute(place).map_err(FileError::at(place, "no such place"))?;
    match place.file_name() {
        Some(_) => Ok(place),
        None => Err(wrong_use(format!("--out {} cannot be a new file or folder", place.display()))),
    }
}

fn refuse_occupied(target: &Path) -> Result<(), FileError> {
    if !is_occupied(target) {
        return Ok(());
    }
    Err(wrong_use(format!("{} already exists and is not overwritten: choose another --out", target.display())))
}

/// Refuses a folder that cannot be written, before any work is done for it.
///
/// # Errors
/// If a file cannot be created there.
pub fn check_writable(folder: &Path) -> Result<(), FileError> {
    drop(Staging::file(&absolute(&folder.join("writable"))?)?);
    Ok(())
}

/// Writes a file beside its final path and renames it, replacing an existing one. For files inside an output.
///
/// # Errors
/// If the path cannot be written.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let failed = || FileError::at(path, WRITE);
    let name = path.file_name().ok_or_else(|| FileError::refused(path, WRITE))?.to_string_lossy();
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(parent).map_err(failed())?;
    let staging = parent.join(format!(".{name}.part-{}", std::process::id()));
    let written = fs::write(&staging, bytes).and_then(|()| fs::rename(&staging, path));
    if written.is_err() && staging.exists() {
        fs::remove_file(&staging).map_err(failed())?;
    }
    written.map_err(failed())
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASSET: FolderKind = FolderKind { marker: "asset.json", key: "format", names: &[] };
    const FIELD: FileKind = FileKind { what: "a field", is_own: |path| fs::read(path).is_ok_and(|b| b == b"one") };

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_appears_whole_or_not_at_all() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("asset");
        let staged = StagedFolder::new(&OutputPath::fresh(&target), &ASSET).unwrap();
        fs::write(staged.path().join("asset.json"), "{}").unwrap();
        assert!(!target.exists());
        staged.commit().unwrap();
        assert_eq!(names(place.path()), ["asset"]);

        let abandoned = StagedFolder::fresh(&place.path().join("other")).unwrap();
        drop(abandoned);
        assert_eq!(names(place.path()), ["asset"]);
    }

    #[test]
    fn an_existing_folder_is_replaced_only_with_force_and_only_if_it_is_ours() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("asset");
        fs::create_dir(&target).unwrap();
        fs::write(target.join("thesis.txt"), "years of work").unwrap();
        let forced = OutputPath { force: true, ..OutputPath::fresh(&target) };
        assert!(StagedFolder::new(&OutputPath::fresh(&target), &ASSET).is_err());
        let error = StagedFolder::new(&forced, &ASSET).err().unwrap().to_string();
        assert!(error.contains("asset.json"), "{error}");

        fs::write(target.join("asset.json"), "{\"format\": 1}").unwrap();
        let error = StagedFolder::new(&forced, &ASSET).err().unwrap().to_string();
        assert!(error.contains("thesis.txt"), "{error}");
        fs::remove_file(target.join("thesis.txt")).unwrap();
        let staged = StagedFolder::new(&forced, &ASSET).unwrap();
        fs::write(staged.path().join("asset.json"), "new").unwrap();
        staged.commit().unwrap();
        assert_eq!(fs::read(target.join("asset.json")).unwrap(), b"new");
        assert_eq!(names(&target), ["asset.json"]);
        assert_eq!(names(place.path()), ["asset"]);
    }

    #[test]
    fn a_file_that_was_put_there_meanwhile_is_kept() {
        let place = tempfile::tempdir().unwrap();
        let target = place.path().join("asset");
        let staged = StagedFolder::new(&OutputPath { force: true, ..OutputPath::fresh(&target) }, &ASSET).unwrap();
        fs::write(&target, "mine").unwrap();
        assert!(staged.commit().is_err());
        assert_eq!(fs::read(&target).unwrap(), b"mine");
        let other = place.path().join("field");
        let staged = StagedFile::new(&OutputPath::fresh(&other), &FIELD).unwrap();
        fs::write(&other, "mine").unwrap();
        assert!(staged.commit(b"one").is_err());
        assert_eq!(fs::read(&other).unwrap(), b"mine");
        assert_eq!(names(place.path()), ["asset", "field"]);
    }

    #[test]
    fn a_file_is_kept_unless_force_is_given_and_it_is_ours() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("deep/phi.nvdb");
        let forced = OutputPath { force: true, ..OutputPath::fresh(&path) };
        let write = |out: &OutputPath, bytes: &[u8]| StagedFile::new(out, &FIELD).and_then(|file| file.commit(bytes));
        write(&OutputPath::fresh(&path), b"one").unwrap();
        assert!(write(&OutputPath::fresh(&path), b"two").is_err());
        assert_eq!(fs::read(&path).unwrap(), b"one");
        write(&forced, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert!(write(&forced, b"three").is_err(), "what is no field is kept");
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(names(path.parent().unwrap()), ["phi.nvdb"]);
    }
}
