//! Flags for the model of a run, and for the user's own effects.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use effects::{CompiledModel, Library, Model, Process, RowCounts};

use crate::wrong_use;
use files::input::{self, MOST_TEXT_BYTES};

/// Laws and effects of a run.
#[derive(Clone, Debug, Args)]
pub(super) struct ModelFlags {
    /// Model file: base law, effects and their parameters [default: the base law of the process].
    #[arg(long, value_name = "FILE")]
    pub(super) model: Option<PathBuf>,
    #[command(flatten)]
    pub(super) own: OwnFlags,
}

/// Where a user's own effects are.
#[derive(Clone, Debug, Args)]
pub(super) struct OwnFlags {
    /// Folder with effect files of your own (*.toml); they act after the built-in ones.
    #[arg(long, value_name = "DIR")]
    pub(super) effects: Option<PathBuf>,
}

impl OwnFlags {
    /// Returns the built-in library with the user's own effects.
    pub(super) fn library(&self) -> Result<Library> {
        self.library_with(None)
    }

    /// Returns [`OwnFlags::library`] with one more file, which may lie in the folder.
    pub(super) fn library_with(&self, more: Option<&Path>) -> Result<Library> {
        let mut files: Vec<PathBuf> = self.files()?;
        if let Some(more) = more {
            files.retain(|file| !same_file::is_same_file(file, more).unwrap_or(false));
            files.push(more.to_owned());
        }
        files.sort();
        let read = |file: PathBuf| Ok((file.display().to_string(), read_text(&file)?));
        Ok(Library::builtin().with(&files.into_iter().map(read).collect::<Result<Vec<_>>>()?)?)
    }

    fn files(&self) -> Result<Vec<PathBuf>> {
        let Some(folder) = &self.effects else { return Ok(Vec::new()) };
        if !folder.is_dir() {
            return Err(wrong_use(format!("--effects {}: no such folder", folder.display())));
        }
        let context = || folder.display().to_string();
        let mut files = Vec::new();
        for entry in fs::read_dir(folder).with_context(context)? {
            let path = entry.with_context(context)?.path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                files.push(path);
            }
        }
        Ok(files)
    }
}

impl ModelFlags {
    /// Returns the input paths: `first`, the model's file and the folder of effects.
    pub(super) fn inputs<'a>(&'a self, first: &'a Path) -> Vec<&'a Path> {
        let own = [&self.model, &self.own.effects].into_iter().flatten().map(PathBuf::as_path);
        std::iter::once(first).chain(own).collect()
    }

    /// Reads the model file, or the text of the base law with the values of the flags.
    fn read(&self, process: Process, law: &str, library: &Library) -> Result<Model> {
        let Some(path) = &self.model else {
            let text = format!("process = \"{}\"\n{law}", process.name());
            return Ok(Model::parse_beyond_ranges("the base law", &text, library)?);
        };
        let model = Model::parse(&path.display().to_string(), &read_text(path)?, library)?;
        if model.process != process {
            return Err(wrong_use(format!(
                "--model {}: it is for {}, and this is {}",
                path.display(),
                model.process.name(),
                process.name()
            )));
        }
        Ok(model)
    }

    /// Reads the model file, or makes the base law of the process with its defaults.
    pub(super) fn model(&self, process: Process, library: &Library) -> Result<Model> {
        self.read(process, "", library)
    }

    /// Compiles the model for the process of its file; without a file, for grinding.
    pub(super) fn compile_any(&self, law: &str, rows: RowCounts) -> Result<CompiledModel> {
        let library = self.own.library()?;
        let model = match &self.model {
            Some(path) => Model::parse(&path.display().to_string(), &read_text(path)?, &library)?,
            None => self.read(Process::Grinding, law, &library)?,
        };
        Ok(CompiledModel::new(&model, &library, rows)?)
    }

    /// Compiles the model. Without a file, `law` states values of the base law in the format of a model file.
    pub(super) fn compile(&self, process: Process, law: &str, rows: RowCounts) -> Result<CompiledModel> {
        let library = self.own.library()?;
        Ok(CompiledModel::new(&self.read(process, law, &library)?, &library, rows)?)
    }
}

/// Reads the text of a file.
pub(super) fn read_text(path: &Path) -> Result<String> {
    if !path.exists() {
        return Err(wrong_use(format!("{}: no such file", path.display())));
    }
    Ok(input::read_text(path, MOST_TEXT_BYTES)?)
}
