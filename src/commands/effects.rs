//! `robofin effects`: lists, shows and checks laws and effects, and edits the effects of a model.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, Subcommand, ValueEnum};
use effects::{CompiledModel, Edit, Effect, Kind, Library, Model, ModelError, Process, RowCounts, hint};
use serde::Serialize;

use super::model_flags::{OwnFlags, read_text};
use crate::console::Console;
use crate::wrong_use;
use effects::page::{EffectAnswer, describe};
use files::folder::write_file;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin effects list\n  robofin effects show grit-dulling\n  \
                        robofin effects check my-effect.toml\n  robofin effects add model.toml grit-dulling")]
pub(super) struct EffectsArgs {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List laws and effects in the order in which they act.
    #[command(after_help = "Example:\n  robofin effects list --process sanding")]
    List(ListArgs),
    /// Show one law or effect: formulas, parameters, signature, effects it is confused with, source.
    #[command(after_help = "Example:\n  robofin effects show tool-tilt")]
    Show(ShowArgs),
    /// Check an effect's file as a run reads it: names, units, circles, null value, size.
    #[command(after_help = "Example:\n  robofin effects check my-effect.toml")]
    Check(CheckArgs),
    /// Add an effect to a model file; the rest of the file stays as it is.
    #[command(after_help = "Example:\n  robofin effects add model.toml grit-dulling --set \"dulling_volume=350 mm^3\"")]
    Add(AddArgs),
    /// Remove an effect from a model file.
    #[command(after_help = "Example:\n  robofin effects remove model.toml grit-dulling")]
    Remove(RemoveArgs),
}

#[derive(Debug, Args)]
struct ListArgs {
    /// Only what acts in this process.
    #[arg(long, value_enum)]
    process: Option<ProcessFlag>,
    #[command(flatten)]
    own: OwnFlags,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ProcessFlag {
    Grinding,
    Sanding,
}

impl From<ProcessFlag> for Process {
    fn from(flag: ProcessFlag) -> Self {
        match flag {
            ProcessFlag::Grinding => Self::Grinding,
            ProcessFlag::Sanding => Self::Sanding,
        }
    }
}

#[derive(Debug, Args)]
struct ShowArgs {
    /// Name of the law or effect.
    name: String,
    #[command(flatten)]
    own: OwnFlags,
}

#[derive(Debug, Args)]
struct CheckArgs {
    /// The file.
    file: PathBuf,
    #[command(flatten)]
    own: OwnFlags,
}

#[derive(Debug, Args)]
struct AddArgs {
    /// Model file to change.
    model: PathBuf,
    /// Name of the effect.
    name: String,
    /// A parameter's value with its unit; may be given several times [default: typical values].
    #[arg(long, value_name = "PARAMETER=VALUE", value_parser = parse_setting)]
    set: Vec<(String, String)>,
    #[command(flatten)]
    own: OwnFlags,
}

#[derive(Debug, Args)]
struct RemoveArgs {
    /// Model file to change.
    model: PathBuf,
    /// Name of the effect.
    name: String,
    #[command(flatten)]
    own: OwnFlags,
}

/// The answer of `effects list --json`.
#[derive(Serialize)]
struct ListAnswer {
    laws: Vec<EffectAnswer>,
    effects: Vec<EffectAnswer>,
}

/// The answer of `effects add --json` and `effects remove --json`.
#[derive(Serialize)]
struct EditAnswer<'a> {
    model: &'a Path,
    changes: &'a [String],
    effects: Vec<&'a str>,
}

pub(super) fn run(args: &EffectsArgs, console: &Console) -> Result<()> {
    match &args.action {
        Action::List(args) => list(args, console),
        Action::Show(args) => show(args, console),
        Action::Check(args) => check(args, console),
        Action::Add(args) => add(args, console),
        Action::Remove(args) => remove(args, console),
    }
}

fn list(args: &ListArgs, console: &Console) -> Result<()> {
    let library = args.own.library()?;
    let acts = |effect: &&Effect| args.process.is_none_or(|process| effect.acts_in(process.into()));
    for (about, list) in [("laws", library.laws()), ("effects", library.effects())] {
        let rows: Vec<String> = list.iter().filter(acts).map(row).collect();
        console.result(about, rows.join("\n"))?;
    }
    let answers = |list: &[Effect]| list.iter().filter(acts).map(EffectAnswer::new).collect();
    console.answer(&ListAnswer { laws: answers(library.laws()), effects: answers(library.effects()) })
}

/// Formats one line of the list.
fn row(effect: &Effect) -> String {
    let processes: Vec<&str> =
        Process::ALL.into_iter().filter(|process| effect.acts_in(*process)).map(Process::name).collect();
    let hooks: Vec<&str> = effect.changes.iter().map(|change| change.value.name()).collect();
    format!("{:22} {:17} {:26} {}", effect.name, processes.join(", "), hooks.join(", "), effect.title)
}

fn show(args: &ShowArgs, console: &Console) -> Result<()> {
    let library = args.own.library()?;
    let Some(effect) = library.find(&args.name) else {
        let known: Vec<&str> = library.all().map(|effect| effect.name.as_str()).collect();
        return Err(wrong_use(format!("no law or effect is called `{}`; {}", args.name, hint(&args.name, &known))));
    };
    for (about, text) in describe(effect) {
        console.result(about, text)?;
    }
    console.answer(&EffectAnswer::new(effect))
}

fn check(args: &CheckArgs, console: &Console) -> Result<()> {
    let file = args.file.display().to_string();
    let library = args.own.library_with(Some(&args.file))?;
    let Some(effect) = library.all().find(|effect| effect.file == file) else {
        unreachable!("the library has what was added to it")
    };
    fits(effect, &library).with_context(|| file.clone())?;
    let what = match effect.kind {
        Kind::Law => "law",
        Kind::Effect => "effect; it vanishes exactly at its null value",
    };
    console.result("good", format!("{file}: {} ({what})", effect.title))?;
    for (about, text) in describe(effect) {
        console.result(about, text)?;
    }
    console.answer(&EffectAnswer::new(effect))
}

/// Refuses formulas too large for the base model of a process in which they act. A law or effect that needs other laws
/// is checked together with them, once a model has both.
fn fits(effect: &Effect, library: &Library) -> Result<(), ModelError> {
    let key = if effect.kind == Kind::Law { "law" } else { "effect" };
    for process in Process::ALL.into_iter().filter(|process| effect.acts_in(*process)) {
        let text = format!("process = \"{}\"\n[{key}.{}]\n", process.name(), effect.name);
        let model = Model::parse("the base model", &text, library)?;
        if let Err(error @ ModelError::TooLarge { .. }) = CompiledModel::new(&model, library, RowCounts::default()) {
            return Err(error);
        }
    }
    Ok(())
}

fn add(args: &AddArgs, console: &Console) -> Result<()> {
    let library = args.own.library()?;
    change(&args.model, console, |source| Model::add_to_text(source, &args.name, &args.set, &library))
}

fn parse_setting(text: &str) -> Result<(String, String), String> {
    let (name, value) = text
        .split_once('=')
        .ok_or_else(|| "PARAMETER=VALUE is expected, such as dulling_volume=350 mm^3".to_owned())?;
    Ok((name.trim().to_owned(), value.trim().to_owned()))
}

fn remove(args: &RemoveArgs, console: &Console) -> Result<()> {
    let library = args.own.library()?;
    change(&args.model, console, |source| Model::remove_from_text(source, &args.name, &library))
}

/// Changes a model file: the new text is written beside it and renamed.
fn change(path: &Path, console: &Console, edit: impl Fn((&str, &str)) -> Result<Edit, ModelError>) -> Result<()> {
    let text = read_text(path)?;
    let file = path.display().to_string();
    let edit = edit((&file, &text)).map_err(|error| match error {
        ModelError::File(error) => error.into(),
        other => anyhow::Error::from(other).context(file.clone()),
    })?;
    // Links are resolved, so that their target is replaced.
    let place = fs::canonicalize(path).with_context(|| path.display().to_string())?;
    write_file(&place, edit.text.as_bytes())?;
    console.step("model", edit.changes.join("\n"));
    let effects: Vec<&str> = edit.model.effects.iter().map(|part| part.name.as_str()).collect();
    console.answer(&EditAnswer { model: path, changes: &edit.changes, effects })
}
