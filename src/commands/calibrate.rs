//! `robofin calibrate`: fits the parameters of a model to a campaign.

use std::cell::Cell;
use std::path::PathBuf;
use std::time::Instant;

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use effects::Library;

use super::flags::OutFlags;
use super::model_flags::ModelFlags;
use crate::console::Console;
use files::folder::StagedFolder;
use files::output::FolderKind;
use lab::{Calibration, Order};
use report::study::page;
use study::{CALIBRATION_FILE, CalibrationAnswer, Data, Measurements};

/// Kind of the result folder.
const CALIBRATION: FolderKind =
    FolderKind { marker: CALIBRATION_FILE, key: "noise_floor", names: &[("", &["model.toml", "report.html"])] };

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin calibrate trials --out out/base\n  \
                        robofin effects add out/base/model.toml grit-dulling\n  \
                        robofin calibrate trials --model out/base/model.toml --out out/dulling --json")]
pub(super) struct CalibrateArgs {
    /// Folder of trial folders, one trial folder, or a folder with a table.toml.
    campaign: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    #[command(flatten)]
    model: ModelFlags,
    /// Fit everything at once, or first the removal rate from what was removed in all.
    #[arg(long, value_enum, default_value_t)]
    order: OrderFlag,
}

/// The order in which parameters are fitted.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum OrderFlag {
    /// All parameters and the scans' poses at once.
    #[default]
    Joint,
    /// First the removal rate from what was removed in all, then the rest from the profiles.
    Staged,
}

impl From<OrderFlag> for Order {
    fn from(flag: OrderFlag) -> Self {
        match flag {
            OrderFlag::Joint => Self::Joint,
            OrderFlag::Staged => Self::Staged,
        }
    }
}

/// Runs the verb.
pub(super) fn run(args: &CalibrateArgs, console: &Console) -> Result<()> {
    let folder = StagedFolder::new(&args.out.beside(&args.model.inputs(&args.campaign)), &CALIBRATION)?;
    let (library, started) = (args.model.own.library()?, Instant::now());
    let measurements = Measurements::read(&args.campaign)?;
    let mut data = measurements.data()?;
    let library = data.library(library)?;
    console.step("read", data.describe());
    data.notes().iter().for_each(|note| console.step("note", note));
    let calibration = calibrated(args, &mut data, &library, console)?;
    let model = args.out.out.join("model.toml");
    let (answer, report) = CalibrationAnswer::new(&mut data, &calibration, &library, model)?;
    answer.described().into_iter().for_each(|(about, text)| console.step(about, text));
    let write = |name: &str, text: String| {
        std::fs::write(folder.path().join(name), text).with_context(|| format!("{name}: cannot be written"))
    };
    write(CALIBRATION_FILE, serde_json::to_string_pretty(&answer)?)?;
    write("model.toml", calibration.model.to_text(&library))?;
    write("report.html", page(&report))?;
    let place = folder.commit()?;
    console.step("written", format!("{} after {:.0} s", place.display(), started.elapsed().as_secs_f64()));
    console.answer(&answer)
}

/// Fits the model after the smaller models that it extends.
fn calibrated(args: &CalibrateArgs, data: &mut Data, library: &Library, console: &Console) -> Result<Calibration> {
    let model = data.fitting(args.model.model(data.evidence().process(), library)?, library)?;
    let start = data.start(&model, library)?;
    let (progress, count) = (console.progress("fits"), 1 + model.effects.len());
    let done = Cell::new(0);
    let fitted = |name: &str| {
        done.set(done.get() + 1);
        progress.report(name, done.get(), count);
    };
    Ok(data.calibrated((&model, &start), library, (args.order.into(), &fitted))?)
}
