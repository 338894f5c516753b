//! `robofin try`: fits one hypothesis beside the current model of a campaign, from a formula, a file or the library.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use clap::Args;
use effects::{Library, Model};
use serde::Serialize;

use super::ledger::LedgerFlag;
use super::model_flags::{ModelFlags, read_text};
use crate::console::Console;
use crate::wrong_use;
use lab::Attempt;
use report::study::page;
use study::{
    AttemptTexts, Data, Entry, Hypothesis, Ledger, Measurements, attempt_report, inputs_sha256, is_fitted,
    model_in_words,
};

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin try trials \"rate * exp(-ground_volume / a)\"\n  \
                        robofin try trials \"gap + c * tool_y^2\" --set \"c=2 1/m\" --keep\n  \
                        robofin try trials my-effect.toml\n  robofin try trials --effect grit-dulling --json")]
pub(super) struct TryArgs {
    /// Folder of trial folders, one trial folder, or a folder with a table.toml.
    campaign: PathBuf,
    /// A formula of a value that an effect may change, whose unknown names are fitted; or an effect file (*.toml).
    #[arg(value_name = "FORMULA|FILE", required_unless_present = "effect", conflicts_with = "effect")]
    tried: Option<String>,
    /// An effect of the library instead.
    #[arg(long, value_name = "NAME")]
    effect: Option<String>,
    /// Value with which a parameter of the formula begins, with its unit; may be given several times.
    #[arg(long, value_name = "PARAMETER=VALUE", value_parser = Hypothesis::setting)]
    set: Vec<(String, f64)>,
    /// Make the model with it the current one, beside which the next is tried.
    #[arg(long)]
    keep: bool,
    #[command(flatten)]
    ledger: LedgerFlag,
    #[command(flatten)]
    model: ModelFlags,
}

/// The answer of `try --json`.
#[derive(Serialize)]
struct TryAnswer<'a> {
    #[serde(flatten)]
    entry: &'a Entry,
    ledger: &'a Path,
    model: PathBuf,
    report: PathBuf,
}

/// Runs the verb.
pub(super) fn run(args: &TryArgs, console: &Console) -> Result<()> {
    let started = Instant::now();
    let measurements = Measurements::read(&args.campaign)?;
    let mut data = measurements.data()?;
    console.step("read", data.describe());
    let mut ledger = Ledger::open(&args.ledger.of(&args.campaign))?;
    let measured = inputs_sha256(&args.campaign)?;
    ledger.check_campaign(&measured)?;
    let library = ledger.library(&data.library(args.model.own.library()?)?)?;
    let (beside, model, is_known) = current(args, &ledger, &data, &library)?;
    let hypothesis = match (&args.effect, args.tried.as_deref()) {
        (Some(name), _) => Hypothesis::listed(library, name)?,
        (None, Some(file)) if file.ends_with(".toml") => {
            Hypothesis::of_file(library, file, read_text(Path::new(file))?)?
        }
        (None, line) => {
            let line = (line.unwrap_or_default(), ledger.next_number());
            Hypothesis::typed((&data, &model), library, line, &args.set)?
        }
    };
    let words = if is_known { "its values are known from a fit" } else { "it is fitted first" };
    console.step("beside", format!("model {beside}: {}; {words}", model_in_words(&model)));
    let attempt = Attempt::new(data.tried(), (&model, is_known), &hypothesis.library, &hypothesis.name)?;
    let unit = data.evidence().unit();
    let entry = Entry::new(&attempt, &hypothesis.shown, &hypothesis.name, unit).numbered(&ledger, beside, args.keep);
    let models = attempt.models.each_ref().map(|model| model.to_text(&hypothesis.library));
    let entry = entry.of(&measured, &models[1]);
    let page = page(&attempt_report(&data, &attempt, &entry)?);
    entry.described().into_iter().for_each(|(about, text)| console.step(about, text));
    ledger.keep(entry.clone(), &AttemptTexts { effect: hypothesis.file, models, page })?;
    let own = ledger.folder().join(entry.number.to_string());
    let seconds = started.elapsed().as_secs_f64();
    console.step("written", format!("{}; open report.html there, after {seconds:.0} s", own.display()));
    console.answer(&TryAnswer {
        entry: &entry,
        ledger: ledger.folder(),
        model: own.join("model.toml"),
        report: own.join("report.html"),
    })
}

/// The ledger's current model, else that of the flags; with its number, and true if its values come from a fit.
fn current(args: &TryArgs, ledger: &Ledger, data: &Data, library: &Library) -> Result<(usize, Model, bool)> {
    let process = data.evidence().process();
    let Some(standing) = ledger.current() else {
        let model = data.fitting(args.model.model(process, library)?, library)?;
        let is_known = args.model.model.is_some() && is_fitted(&model, library);
        return Ok((0, model, is_known));
    };
    if args.model.model.is_some() {
        return Err(wrong_use(format!(
            "--model: this ledger has a current model, {}; go to another with `robofin ledger {} --to N`, or begin another \
             with --ledger",
            standing.model.display(),
            ledger.folder().display()
        )));
    }
    let model = Model::parse(&standing.model.display().to_string(), &read_text(&standing.model)?, library)?;
    Ok((standing.number, model, true))
}
