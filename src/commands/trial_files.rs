//! `robofin trial init` and `trial check`: make a trial from a folder of scans and logs.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use serde::Serialize;

use super::flags::OutFlags;
use crate::console::Console;
use files::folder::{StagedFolder, write_file};
use files::output::FolderKind;
use report::trial_check::{Summary, TrialCheck, page};
use trials::init::guess;
use trials::measure::ScanNoise;
use trials::trial::{Campaign, Checked, TRIAL_FILE, Trial};

/// File that marks a result folder.
const CHECK_FILE: &str = "check.json";
/// Kind of the result folder.
const CHECK: FolderKind = FolderKind { marker: CHECK_FILE, key: "usable", names: &[("", &["report.html"])] };

#[derive(Debug, Args)]
pub(super) struct InitArgs {
    /// Folder with the scans and the logs of one trial.
    folder: PathBuf,
    /// Print the text instead of writing it.
    #[arg(long)]
    print: bool,
}

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    /// A trial folder, or a folder of trial folders.
    folder: PathBuf,
    #[command(flatten)]
    out: OutFlags,
}

/// The answer of `trial init --json`.
#[derive(Serialize)]
struct InitAnswer<'a> {
    file: &'a Path,
    seen: &'a [String],
    open: &'a [String],
    text: &'a str,
}

/// The answer of `trial check --json`, which is also `check.json`.
#[derive(Serialize)]
struct CheckAnswer {
    usable: bool,
    trials: Vec<Summary>,
}

/// Inspects a folder and writes its `trial.toml`.
pub(super) fn init(args: &InitArgs, console: &Console) -> Result<()> {
    let file = args.folder.join(TRIAL_FILE);
    if !args.print && file.exists() {
        bail!("{}: this file exists; --print shows what would be written, or move it away", file.display());
    }
    let guess = guess(&args.folder)?;
    guess.seen.iter().for_each(|seen| console.step("seen", seen));
    if args.print {
        console.document(&guess.text)?;
    } else {
        write_file(&file, guess.text.as_bytes())?;
        console.step("written", file.display().to_string());
    }
    guess.open.iter().for_each(|open| console.step("fill in", open));
    console.step(
        "next",
        format!("check every line of it, then robofin trial check {} --out check", args.folder.display()),
    );
    console.answer(&InitAnswer { file: &file, seen: &guess.seen, open: &guess.open, text: &guess.text })
}

/// Checks trials and draws their data.
pub(super) fn check(args: &CheckArgs, console: &Console) -> Result<()> {
    let folder = StagedFolder::new(&args.out.beside(&[&args.folder]), &CHECK)?;
    let checked =
        Campaign::places(&args.folder)?.iter().map(|place| Trial::checked(place)).collect::<Result<Vec<_>, _>>()?;
    let (trials, checks): (Vec<Trial>, Vec<Vec<Checked>>) = checked.into_iter().unzip();
    let noises = ScanNoise::of_campaign(&trials)?;
    let all: Vec<TrialCheck> = trials
        .iter()
        .zip(&checks)
        .zip(&noises)
        .map(|((trial, checks), noise)| TrialCheck { trial, checks, noise })
        .collect();
    for check in &all {
        check.trial.notes.iter().for_each(|note| console.step("note", format!("{}: {note}", check.trial.name)));
        check.refusals().for_each(|refusal| console.step("refused", refusal));
        console.step("checked", format!("{}: {}", check.trial.name, check.verdict()));
    }
    let answer = CheckAnswer {
        usable: all.iter().all(|check| check.refused() == 0),
        trials: all.iter().map(TrialCheck::summary).collect(),
    };
    let name = args.folder.file_name().map_or("trial".to_owned(), |name| name.to_string_lossy().into_owned());
    write_file(&folder.path().join("report.html"), page(&name, &all).as_bytes())?;
    write_file(&folder.path().join(CHECK_FILE), serde_json::to_string_pretty(&answer)?.as_bytes())?;
    console.step("written", folder.commit()?.display().to_string());
    console.answer(&answer)
}
