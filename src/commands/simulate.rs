//! `robofin simulate`: grind the weld of an asset.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use serde::Serialize;
use sim::{GrindSettings, Wheel};

use super::flags::{OutFlags, within};
use crate::console::Console;
use crate::finishing::{self, GRIND_FILE, GrindSummary, grind_asset};
use crate::folder::StagedFolder;
use crate::wrong_use;

/// More passes than any weld needs; each takes seconds.
const MOST_PASSES: u32 = 200;

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin weld data/bracket.obj --out out/bracket --seed 7\n  \
                  robofin simulate out/bracket --out out/ground --passes 2 --force-n 15")]
pub(super) struct SimulateArgs {
    /// Asset folder made by `robofin weld`.
    asset: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    #[command(flatten)]
    process: ProcessFlags,
}

/// Wheel and process; the defaults grind a weld on steel.
#[derive(Clone, Debug, Args)]
pub(super) struct ProcessFlags {
    /// Radius of the wheel [mm].
    #[arg(long, value_name = "MM", default_value_t = 50.0, allow_negative_numbers = true)]
    wheel_radius_mm: f64,
    /// Width of the wheel [mm].
    #[arg(long, value_name = "MM", default_value_t = 20.0, allow_negative_numbers = true)]
    wheel_width_mm: f64,
    /// Passes along the weld, to and fro.
    #[arg(long, value_name = "N", default_value_t = 2, allow_negative_numbers = true)]
    passes: u32,
    /// Normal force that the controller holds [N].
    #[arg(long, value_name = "N", default_value_t = 15.0, allow_negative_numbers = true)]
    force_n: f64,
    /// Speed along the weld [mm/s].
    #[arg(long, value_name = "MM_S", default_value_t = 5.0, allow_negative_numbers = true)]
    feed_mm_s: f64,
    /// Contact stiffness K: pressure per depth [Pa/m].
    #[arg(long, value_name = "PA_M", default_value_t = 1e10, allow_negative_numbers = true)]
    stiffness: f64,
    /// Preston's coefficient k [m/(Pa s)].
    #[arg(long, value_name = "M_PA_S", default_value_t = 1e-9, allow_negative_numbers = true)]
    grind_rate: f64,
    /// Threshold pressure p_c, below which nothing is removed [MPa].
    #[arg(long, value_name = "MPA", default_value_t = 0.0, allow_negative_numbers = true)]
    threshold_mpa: f64,
}

impl ProcessFlags {
    /// The wheel asked for.
    pub(super) fn wheel(&self) -> Result<Wheel> {
        Ok(Wheel {
            radius: within("--wheel-radius-mm", self.wheel_radius_mm, (0.1, 1000.0))? * 1e-3,
            width: within("--wheel-width-mm", self.wheel_width_mm, (0.1, 1000.0))? * 1e-3,
        })
    }

    /// The process asked for.
    pub(super) fn settings(&self) -> Result<GrindSettings> {
        if !(1..=MOST_PASSES).contains(&self.passes) {
            return Err(wrong_use(format!("--passes {}: 1 to {MOST_PASSES} are accepted", self.passes)));
        }
        Ok(GrindSettings {
            passes: self.passes,
            force_setpoint: within("--force-n", self.force_n, (1e-3, 1e4))?,
            feed: within("--feed-mm-s", self.feed_mm_s, (1e-3, 1e4))? * 1e-3,
            stiffness: within("--stiffness", self.stiffness, (1e6, 1e14))?,
            grind_rate: within("--grind-rate", self.grind_rate, (1e-15, 1e-6))?,
            threshold_pressure: within("--threshold-mpa", self.threshold_mpa, (0.0, 1e4))? * 1e6,
            ..GrindSettings::default()
        })
    }
}

/// The answer of `simulate --json`: the figures, and what this run took.
#[derive(Serialize)]
struct SimulateAnswer<'a> {
    out: &'a Path,
    real_time_factor: f64,
    seconds: f64,
    #[serde(flatten)]
    summary: GrindSummary,
}

pub(super) fn run(args: &SimulateArgs, console: &Console) -> Result<()> {
    let (wheel, settings) = (args.process.wheel()?, args.process.settings()?);
    let folder = StagedFolder::new(&args.out.out, GRIND_FILE, args.out.force)?;
    let ground = grind_asset(&args.asset, wheel, settings, console)?;
    finishing::write(&ground, &args.asset, folder, console)?;
    console.step("weld", finishing::describe_rest(&ground));
    console.step("done", format!("{}", args.out.out.display()));
    console.answer(&SimulateAnswer {
        out: &args.out.out,
        real_time_factor: ground.real_time_factor(),
        seconds: ground.seconds,
        summary: ground.summary(),
    })
}
