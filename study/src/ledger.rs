//! The ledger of a campaign: every effect that was tried on it, and the current model.
//!
//! The ledger is a folder. `ledger.jsonl` has one line for each attempt and each return to an earlier model, and is
//! append-only; `effects/` holds the formulas that were tried; a folder for each number holds its model and page.
//! Number 0 is the initial model.

use std::fs;
use std::path::{Path, PathBuf};

use effects::{Library, Model};
use files::FileError;
use files::WrongUse;
use files::file_lock::{FileLock, LockWait};
use files::folder::write_file;
use files::input::{self, MOST_TEXT_BYTES, quoted};
use files::json_file::parse_json;
use files::sha256;
use lab::{Attempt, Better, ErrorUnit, LabError, Paired, ParameterSummary, Result, parameter_summary};
use serde::{Deserialize, Serialize};

/// File of the ledger's lines.
pub const LEDGER_FILE: &str = "ledger.jsonl";
/// Folder of the tried formulas.
pub const TRIED_EFFECTS: &str = "effects";
/// Model file in the folder of a number.
const MODEL_FILE: &str = "model.toml";
/// Page in the folder of a number.
const PAGE_FILE: &str = "report.html";

/// A line of the ledger.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum LedgerLine {
    /// An effect was tried.
    Try(Box<Entry>),
    /// An earlier model was made the current one.
    Return {
        /// Number of that model.
        to: usize,
    },
}

/// An effect that was tried.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Entry {
    /// Number of the attempt, from 1.
    pub number: usize,
    /// The hypothesis as it was entered.
    pub tried: String,
    /// Name of the effect.
    pub effect: String,
    /// Number of the model beside which it was tried.
    pub beside: usize,
    /// True if the model with the effect became the current one.
    pub kept: bool,
    /// The better model, by held-out data where there are any.
    pub better: Better,
    /// Cross-validated log density of whole passes with the effect, minus that without it [nats].
    pub predicts_better_by: f64,
    /// Robust χ² of the calibration data without the effect, minus that with it.
    pub delta_chi2: f64,
    /// Number of parameters that the effect adds.
    pub added_parameters: usize,
    /// Unit of the errors.
    pub error_unit: ErrorUnit,
    /// Comparison of both models on the same data.
    #[serde(flatten)]
    pub paired: Paired,
    /// Fitted parameters of the model with the effect.
    pub parameters: Vec<ParameterSummary>,
    /// SHA-256 of the model file with the effect.
    pub model_sha256: String,
    /// SHA-256 over the files of the campaign.
    pub measurements_sha256: String,
}

/// A model of a ledger.
#[derive(Clone, Debug, Serialize)]
pub struct Standing {
    /// Number of the model.
    pub number: usize,
    /// Path of the model file.
    pub model: PathBuf,
}

/// An open ledger, locked against other writers.
pub struct Ledger {
    folder: PathBuf,
    lines: Vec<LedgerLine>,
    _lock: FileLock,
}

impl Ledger {
    /// Opens the ledger in a folder, or creates one there.
    ///
    /// # Errors
    /// Wrong use if the folder holds something else or is locked; otherwise if a file cannot be read.
    pub fn open(folder: &Path) -> Result<Self> {
        let file = folder.join(LEDGER_FILE);
        let is_new = !folder.exists() || fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
        if !is_new && !file.is_file() {
            return Err(refused(format!("{}: holds no {LEDGER_FILE}; another --ledger is needed", folder.display())));
        }
        fs::create_dir_all(folder).map_err(FileError::at(folder, "cannot be made"))?;
        let Some(lock) = FileLock::take(&folder.join(".ledger.lock"), LockWait::None)? else {
            return Err(refused(format!("{}: another robofin is writing this ledger", folder.display())));
        };
        let lines = if file.is_file() { read_lines(&file)? } else { Vec::new() };
        Ok(Self { folder: folder.to_owned(), lines, _lock: lock })
    }

    /// Path of the ledger's folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// All attempts, in order.
    pub fn entries(&self) -> impl Iterator<Item = &Entry> {
        self.lines.iter().filter_map(|line| match line {
            LedgerLine::Try(entry) => Some(entry.as_ref()),
            LedgerLine::Return { .. } => None,
        })
    }

    /// Number of the next attempt.
    pub fn next_number(&self) -> usize {
        self.entries().map(|entry| entry.number).max().unwrap_or(0) + 1
    }

    /// The current model; `None` if the ledger has none yet.
    pub fn current(&self) -> Option<Standing> {
        let number = self.lines.iter().rev().find_map(|line| match line {
            LedgerLine::Try(entry) => entry.kept.then_some(entry.number),
            LedgerLine::Return { to } => Some(*to),
        });
        let number = number.or_else(|| self.entries().next().map(|_| 0))?;
        Some(Standing { number, model: self.model_file(number) })
    }

    /// The model file of a number.
    fn model_file(&self, number: usize) -> PathBuf {
        self.folder.join(number.to_string()).join(MODEL_FILE)
    }

    /// Returns a library with the formulas that were tried.
    ///
    /// # Errors
    /// If a file is no effect, or a name is taken.
    pub fn library(&self, library: &Library) -> Result<Library> {
        let folder = self.folder.join(TRIED_EFFECTS);
        let mut files = Vec::new();
        let entries = if folder.is_dir() {
            fs::read_dir(&folder).map_err(FileError::at(&folder, "cannot be read"))?.collect()
        } else {
            Vec::new()
        };
        for entry in entries {
            let path = entry.map_err(FileError::at(&folder, "cannot be read"))?.path();
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            if path.extension().is_some_and(|end| end == "toml") && library.find(&name).is_none() {
                files.push((path.display().to_string(), input::read_text(&path, MOST_TEXT_BYTES)?));
            }
        }
        files.sort();
        Ok(library.with(&files)?)
    }

    /// Checks that a campaign is the one of the ledger.
    ///
    /// # Errors
    /// Wrong use if the measurements differ.
    pub fn check_campaign(&self, measurements_sha256: &str) -> Result<()> {
        match self.entries().find(|entry| entry.measurements_sha256 != measurements_sha256) {
            None => Ok(()),
            Some(_) => Err(refused(format!(
                "{}: was begun with other measurements than the campaign holds now; another --ledger is needed",
                self.folder.display()
            ))),
        }
    }

    /// Stores an attempt: its effect, both models and its page, then its line.
    ///
    /// - `texts`: texts of effect, models and page
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn keep(&mut self, entry: Entry, texts: &AttemptTexts) -> Result<()> {
        if let Some(file) = &texts.effect {
            let path = self.folder.join(TRIED_EFFECTS).join(format!("{}.toml", entry.effect));
            write_file(&path, file.as_bytes())?;
        }
        let own = self.folder.join(entry.number.to_string());
        write_file(&own.join(MODEL_FILE), texts.models[1].as_bytes())?;
        write_file(&own.join(PAGE_FILE), texts.page.as_bytes())?;
        if self.entries().next().is_none() {
            write_file(&self.model_file(0), texts.models[0].as_bytes())?;
        }
        self.add(LedgerLine::Try(Box::new(entry)))
    }

    /// Makes an earlier model the current one.
    ///
    /// # Errors
    /// Wrong use if there is no such number.
    pub fn return_to(&mut self, number: usize) -> Result<Standing> {
        let most = self.next_number() - 1;
        if most == 0 || number > most {
            let known = if most == 0 { "the ledger is empty".to_owned() } else { format!("0 to {most} are known") };
            return Err(refused(format!("--to {number}: no such model; {known}")));
        }
        self.add(LedgerLine::Return { to: number })?;
        Ok(Standing { number, model: self.model_file(number) })
    }

    fn add(&mut self, line: LedgerLine) -> Result<()> {
        self.lines.push(line);
        let file = self.folder.join(LEDGER_FILE);
        let lines = self.lines.iter().map(|line| serde_json::to_string(line).map_err(FileError::encoding(&file)));
        let text = lines.collect::<std::result::Result<Vec<_>, _>>()?.join("\n") + "\n";
        Ok(write_file(&file, text.as_bytes())?)
    }
}

/// Texts of an attempt that its ledger stores.
pub struct AttemptTexts {
    /// The effect file of an entered formula.
    pub effect: Option<String>,
    /// The models without and with the effect.
    pub models: [String; 2],
    /// The page that shows the change.
    pub page: String,
}

impl Entry {
    /// The line of an attempt.
    ///
    /// - `tried`: the hypothesis as it was entered
    pub fn new(attempt: &Attempt, tried: &str, effect: &str, error_unit: ErrorUnit) -> Self {
        let better = attempt.better();
        Self {
            number: 0,
            tried: tried.to_owned(),
            effect: effect.to_owned(),
            beside: 0,
            kept: false,
            better,
            predicts_better_by: attempt.predicts_better_by,
            delta_chi2: attempt.before.chi2 - attempt.with.chi2,
            added_parameters: attempt.with.coordinates.len() - attempt.before.coordinates.len(),
            error_unit,
            paired: attempt.paired.clone(),
            parameters: attempt.with.estimates(attempt.spread()).iter().map(parameter_summary).collect(),
            model_sha256: String::new(),
            measurements_sha256: String::new(),
        }
    }

    /// Sets the numbers of the line in a ledger.
    #[must_use]
    pub fn numbered(self, ledger: &Ledger, beside: usize, kept: bool) -> Self {
        Self { number: ledger.next_number(), beside, kept, ..self }
    }

    /// Sets the hashes of measurements and model.
    #[must_use]
    pub fn of(self, measurements_sha256: &str, model: &str) -> Self {
        Self { measurements_sha256: measurements_sha256.to_owned(), model_sha256: sha256(model.as_bytes()), ..self }
    }

    /// Lines for the console, each with its label.
    pub fn described(&self) -> Vec<(&'static str, String)> {
        let unit = self.error_unit;
        let error = |k: usize| {
            let held_out = self.paired.held_out.as_ref();
            let held_out = held_out.map_or(String::new(), |split| format!(", {} held out", unit.shown(split.rms[k])));
            format!("{}{held_out}", unit.shown(self.paired.calibration.rms[k]))
        };
        let fit = format!(
            "Δχ² {:.0} for {} parameters; whole passes left out: predicted better by {:.0} nats",
            self.delta_chi2, self.added_parameters, self.predicts_better_by
        );
        let kept = if self.kept { "it is the current model now" } else { "the current model stays" };
        let mut lines = vec![("without", error(0)), ("with", error(1))];
        lines.extend(self.parameters.iter().map(|parameter| ("parameter", parameter.shown())));
        let verdict = ("verdict", self.sentence());
        lines.extend([("fit", fit), verdict, ("ledger", format!("attempt {}: {kept}", self.number))]);
        lines
    }

    /// Formats the attempt in one line.
    pub fn line(&self) -> String {
        let split = self.paired.deciding();
        let [before, after] = split.rms.map(|rms| self.error_unit.shown(rms));
        let verdict = match self.better {
            Better::Second => "better",
            Better::First => "worse",
            Better::Neither => "no better",
        };
        let kept = if self.kept { ", kept" } else { "" };
        format!(
            "beside {}: {verdict}{kept}, {before} to {after}, Δχ² {:.0}: {}",
            self.beside, split.delta_chi2, self.tried
        )
    }

    /// Sentence on the verdict.
    pub fn sentence(&self) -> String {
        let errors = errors_in_words(&self.paired, self.error_unit);
        match self.better {
            Better::Second => format!("The model is better with it: {errors}."),
            Better::First => format!("The model is worse with it: {errors}."),
            Better::Neither => format!("The model is no better with it: {errors}."),
        }
    }
}

/// Sentence on the better of two models.
pub fn pair_in_words([first, second]: &[String; 2], paired: &Paired, error_unit: ErrorUnit) -> String {
    let errors = errors_in_words(paired, error_unit);
    match paired.deciding().better() {
        Better::First => format!("{first} is better than {second}: {errors}."),
        Better::Second => format!("{second} is better than {first}: {errors}."),
        Better::Neither => format!("Neither {first} nor {second} is better: {errors}."),
    }
}

/// Errors of two models in the data that decide, in words.
fn errors_in_words(paired: &Paired, error_unit: ErrorUnit) -> String {
    let split = paired.deciding();
    let which = if paired.held_out.is_some() { "held out" } else { "in the data that were fitted" };
    let [before, after, floor] = [split.rms[0], split.rms[1], split.noise_floor].map(|error| error_unit.shown(error));
    let sigma = split.sigma.map_or(String::new(), |sigma| format!(" ± {sigma:.0}"));
    format!(
        "{before}, then {after} {which}, noise {floor}; Δχ² {:.0}{sigma}, better in {} of {} blocks",
        split.delta_chi2, split.blocks[1], split.blocks[0]
    )
}

/// Names of the laws and effects of a model.
pub fn model_in_words(model: &Model) -> String {
    model.laws.iter().chain(&model.effects).map(|part| part.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Returns true if all free parameters of a model file have values, as after a fit.
pub fn is_fitted(model: &Model, library: &Library) -> bool {
    model.laws.iter().chain(&model.effects).all(|part| {
        let parameters = library.find(&part.name).into_iter().flat_map(|own| &own.parameters);
        let free = parameters.filter(|parameter| parameter.free.of(model.process));
        free.into_iter().all(|parameter| part.values.iter().any(|(name, _)| *name == parameter.name))
    })
}

fn read_lines(file: &Path) -> Result<Vec<LedgerLine>> {
    let text = input::read_text(file, MOST_TEXT_BYTES)?;
    let read = |(k, line): (usize, &str)| {
        parse_json(file, line, "a line of a ledger")
            .map_err(|error| refused(format!("{}: line {}: {error}; found {}", file.display(), k + 1, quoted(line))))
    };
    text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).map(read).collect()
}

fn refused(why: String) -> LabError {
    LabError::File(FileError::from(WrongUse(why)))
}
