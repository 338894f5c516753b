//! `robofin simulate`: simulates a trial as it was run, or passes along the weld of an asset.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Result, bail};
use clap::Args;
use effects::{CompiledModel, Process, RowCounts};
use robot::{Tool, Wheel};
use serde::Serialize;
use sim::Executor;

use super::backend_flags::{BackendFlags, name_of};
use super::faults::refuse_all;
use super::flags::{OutFlags, STIFFNESS, metres};
use super::model_flags::ModelFlags;
use super::values::{number, whole};
use crate::batch::{self, BATCH, BATCH_FILE, BatchLine, BatchRun};
use crate::console::Console;
use crate::finishing::{self, GROUND, GrindSummary, Grinding, Plan, Session, grind_asset};
use crate::trial_run::{TRIAL_RUN, TrialPasses, TrialRun, TrialRunSummary, is_trial};
use files::folder::StagedFolder;
use study::snapshot::{Keeping, Resume, kept};
use trial_simulation::Simulation;
use trials::trial::Trial;

/// Accepted numbers of passes; each takes seconds.
const PASSES: [u64; 2] = [1, 200];
/// Accepted sizes of a wheel [mm].
const WHEEL_MM: [f64; 2] = [0.1, 1e3];

#[derive(Debug, Args)]
#[command(after_help = "Example:\n  robofin weld data/bracket.obj --out out/bracket --seed 7\n  \
                  robofin simulate out/bracket --out out/ground --passes 2 --force-n 15\n  \
                  robofin simulate trials/plate-03 --model model.toml --out out/plate-03")]
pub(super) struct SimulateArgs {
    /// Trial folder (with a trial.toml), or asset folder made by `robofin weld`.
    folder: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    #[command(flatten)]
    backend: BackendFlags,
    #[command(flatten, next_help_heading = "Model")]
    model: ModelFlags,
    /// Voxel of a trial's field [mm] [default: the scan's pitch].
    #[arg(
        long,
        value_name = "MM",
        allow_negative_numbers = true,
        value_parser = number([1e-3, 1e2]),
        help_heading = "Trial"
    )]
    voxel_mm: Option<f64>,
    /// Keep a trial's tool to the logged heights instead of simulating its controller.
    #[arg(long, help_heading = "Trial")]
    replay: bool,
    /// Write what each pixel of a trial's scan went through: pressure, time, sliding, removal, as CSV maps.
    #[arg(long, help_heading = "Trial")]
    covariates: bool,
    /// Table of parameter sets for a trial (CSV: name, then parameters as effect.parameter in their own units); one
    /// JSON line for each.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["covariates", "snapshot", "resume"], help_heading = "Trial")]
    batch: Option<PathBuf>,
    #[command(flatten, next_help_heading = "States")]
    state: StateFlags,
    #[command(flatten, next_help_heading = "Grinding of an asset")]
    process: ProcessFlags,
}

/// States between passes.
#[derive(Clone, Debug, Args)]
pub(super) struct StateFlags {
    /// Keep the state of workpiece and tool after every pass, to begin from it later.
    #[arg(long)]
    snapshot: bool,
    /// Begin from a state in the result folder of an earlier run with --snapshot.
    #[arg(long, value_name = "DIR")]
    resume: Option<PathBuf>,
    /// Pass after which to begin [default: the last one kept].
    #[arg(
        long,
        value_name = "N",
        requires = "resume",
        allow_negative_numbers = true,
        value_parser = whole::<usize>(PASSES)
    )]
    after_pass: Option<usize>,
}

impl StateFlags {
    /// Returns the snapshots to keep in a run of `passes` passes, and the state to begin from.
    fn keeping(&self, passes: usize) -> Result<Keeping> {
        let resume = self.resume.as_ref().map(|folder| Resume::new(folder, self.after_pass, passes)).transpose()?;
        Ok(Keeping { snapshots: self.snapshot, resume })
    }
}

/// Wheel and passes along an asset's weld; the defaults grind a weld on steel. A trial states its own.
#[derive(Clone, Debug, Args)]
pub(super) struct ProcessFlags {
    /// Radius of the wheel [mm] [default: 50].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = number(WHEEL_MM))]
    wheel_radius_mm: Option<f64>,
    /// Width of the wheel [mm] [default: 20].
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = number(WHEEL_MM))]
    wheel_width_mm: Option<f64>,
    /// Passes along the weld, back and forth [default: 2].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<u32>(PASSES))]
    passes: Option<u32>,
    /// Normal force that the controller holds [N] [default: 15].
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number([1e-3, 1e4]))]
    force_n: Option<f64>,
    /// Speed along the weld [mm/s] [default: 5].
    #[arg(long, value_name = "MM_S", allow_negative_numbers = true, value_parser = number([1e-3, 1e4]))]
    feed_mm_s: Option<f64>,
    /// Contact stiffness K: pressure per depth [Pa/m] [default: 1e10].
    #[arg(
        long,
        value_name = "PA_M",
        conflicts_with = "model",
        allow_negative_numbers = true,
        value_parser = number(STIFFNESS)
    )]
    stiffness: Option<f64>,
    /// Preston's coefficient k [m/(Pa s)] [default: 1e-9].
    #[arg(
        long,
        value_name = "M_PA_S",
        conflicts_with = "model",
        allow_negative_numbers = true,
        value_parser = number([1e-15, 1e-6])
    )]
    grind_rate: Option<f64>,
    /// Threshold pressure p_c, below which nothing is removed [MPa] [default: 0].
    #[arg(
        long,
        value_name = "MPA",
        conflicts_with = "model",
        allow_negative_numbers = true,
        value_parser = number([0.0, 1e4])
    )]
    threshold_mpa: Option<f64>,
}

impl ProcessFlags {
    /// Refuses flags whose values a trial states itself.
    fn refuse_for_trial(&self, trial: &Path) -> Result<()> {
        let by_trial = "the trial states it";
        let by_model = "a trial takes it from --model";
        let flags = [
            ("--wheel-radius-mm", self.wheel_radius_mm.is_some(), by_trial),
            ("--wheel-width-mm", self.wheel_width_mm.is_some(), by_trial),
            ("--passes", self.passes.is_some(), by_trial),
            ("--force-n", self.force_n.is_some(), by_trial),
            ("--feed-mm-s", self.feed_mm_s.is_some(), by_trial),
            ("--stiffness", self.stiffness.is_some(), by_model),
            ("--grind-rate", self.grind_rate.is_some(), by_model),
            ("--threshold-mpa", self.threshold_mpa.is_some(), by_model),
        ];
        let given = flags.into_iter().filter(|(_, is_given, _)| *is_given);
        let fault = |(flag, _, why)| format!("{flag}: only for an asset; {} is a trial, and {why}", trial.display());
        refuse_all(given.map(fault).collect())
    }

    /// Returns the requested wheel.
    fn wheel(&self) -> Wheel {
        Wheel::cylinder(self.wheel_radius_mm.unwrap_or(50.0) * 1e-3, self.wheel_width_mm.unwrap_or(20.0) * 1e-3)
    }

    /// Returns the requested passes.
    fn plan(&self) -> Plan {
        Plan {
            passes: self.passes.unwrap_or(2),
            force_setpoint: self.force_n.unwrap_or(15.0),
            feed: self.feed_mm_s.unwrap_or(5.0) * 1e-3,
        }
    }

    /// Returns the text of the requested base law, in the format of a model file.
    fn law(&self) -> String {
        let (stiffness, grind_rate) = (self.stiffness.unwrap_or(1e10), self.grind_rate.unwrap_or(1e-9));
        let threshold = self.threshold_mpa.unwrap_or(0.0);
        format!(
            "[law.winkler]\nstiffness = \"{stiffness:e} Pa/m\"\n[law.preston-threshold]\n\
             grind_rate = \"{grind_rate:e} m/(Pa s)\"\nthreshold_pressure = \"{threshold:e} MPa\"\n"
        )
    }
}

/// The answer of `simulate --json`: the results, and the time of this run.
#[derive(Serialize)]
struct SimulateAnswer<'a> {
    out: &'a Path,
    backend: String,
    real_time_factor: f64,
    seconds: f64,
    #[serde(flatten)]
    summary: GrindSummary,
}

/// The answer of `simulate --json` for a trial.
#[derive(Serialize)]
struct TrialAnswer<'a> {
    out: &'a Path,
    notes: &'a [String],
    backend: String,
    real_time_factor: f64,
    #[serde(flatten)]
    summary: TrialRunSummary,
}

/// The answer of `simulate --batch --json`.
#[derive(Serialize)]
struct BatchAnswer<'a> {
    out: &'a Path,
    notes: &'a [String],
    backend: String,
    runs: usize,
    real_time_factor: f64,
}

impl SimulateArgs {
    /// Returns all input paths of a run.
    fn inputs(&self) -> Vec<&Path> {
        let others = [&self.batch, &self.state.resume].into_iter().flatten().map(PathBuf::as_path);
        self.model.inputs(&self.folder).into_iter().chain(others).collect()
    }
}

pub(super) fn run(args: &SimulateArgs, console: &Console) -> Result<()> {
    if is_trial(&args.folder) { run_trial(args, console) } else { run_asset(args, console) }
}

fn run_trial(args: &SimulateArgs, console: &Console) -> Result<()> {
    args.process.refuse_for_trial(&args.folder)?;
    let kind = if args.batch.is_some() { &BATCH } else { &TRIAL_RUN };
    let folder = StagedFolder::new(&args.out.beside(&args.inputs()), kind)?;
    let trial = Trial::read(&args.folder)?;
    for note in &trial.notes {
        console.step("trial", note);
    }
    let rows = RowCounts { passes: trial.passes.len(), scans: trial.passes.len() };
    let model = args.model.compile(trial.process, "", rows)?;
    let voxel = metres(args.voxel_mm).unwrap_or(trial.scans.before.pixels.pitch);
    let keeping = args.state.keeping(trial.passes.len())?;
    let mut simulation = Simulation::new(&trial, voxel, args.replay)?;
    simulation.covariates = args.covariates;
    let runs = args.batch.as_deref().map(|file| batch::read(file, &model)).transpose()?;
    let device = args.backend.device(simulation.refusal(&model), console)?;
    simulation.device = device.as_ref();
    if let Some(runs) = runs {
        return run_batch((&runs, folder), &simulation, args, console);
    }
    let trial_run =
        TrialRun::new(&TrialPasses { simulation: &simulation, model: &model }, (&keeping, folder.path()), console)?;
    let summary = trial_run.summary(&trial, &model);
    trial_run.describe(&summary, console);
    trial_run.write(&summary, &trial, folder, console)?;
    let passes = (trial_run.passes.len(), trial.passes.len());
    let real_time_factor = trial_run.real_time_factor();
    if let Some(error) = trial_run.stopped {
        return Err(error.context(kept(&args.out.out, passes, keeping.snapshots)));
    }
    console.step("done", format!("{}", args.out.out.display()));
    let backend = name_of(device.as_ref());
    let (out, notes) = (&args.out.out, &trial.notes);
    console.answer(&TrialAnswer { out, notes, backend, real_time_factor, summary })
}

/// Simulates the trial with every parameter set of a table.
fn run_batch(
    (runs, folder): (&[BatchRun], StagedFolder),
    simulation: &Simulation,
    args: &SimulateArgs,
    console: &Console,
) -> Result<()> {
    let started = Instant::now();
    let models: Vec<CompiledModel> = runs.iter().map(|run| run.model.clone()).collect();
    let outcomes = simulation.run_models(&models);
    let seconds = started.elapsed().as_secs_f64();
    let mut text = String::new();
    for (run, outcome) in runs.iter().zip(&outcomes) {
        text += &serde_json::to_string(&BatchLine::new(run, simulation.trial, outcome))?;
        text.push('\n');
    }
    std::fs::write(folder.path().join(BATCH_FILE), text)?;
    folder.commit()?;
    let simulated = runs.len() as f64 * simulation.duration(0);
    console.step("batch", format!("{} runs of {:.1} s in {seconds:.1} s", runs.len(), simulation.duration(0)));
    let stopped: Vec<_> = outcomes.iter().filter_map(|outcome| outcome.stopped.as_ref()).collect();
    if let Some(first) = stopped.first() {
        let file = args.out.out.join(BATCH_FILE);
        bail!("{} of {} runs ended early, {} says why; the first: {first}", stopped.len(), runs.len(), file.display());
    }
    let (backend, real_time_factor) = (name_of(simulation.device), simulated / seconds);
    let (out, notes) = (&args.out.out, &simulation.trial.notes);
    console.answer(&BatchAnswer { out, notes, backend, runs: runs.len(), real_time_factor })
}

fn run_asset(args: &SimulateArgs, console: &Console) -> Result<()> {
    let of_trials = [
        ("--voxel-mm", args.voxel_mm.is_some()),
        ("--replay", args.replay),
        ("--covariates", args.covariates),
        ("--batch", args.batch.is_some()),
    ];
    let given = of_trials.into_iter().filter(|(_, is_given)| *is_given);
    let fault = |(flag, _)| format!("{flag}: only for a trial; {} is an asset", args.folder.display());
    refuse_all(given.map(fault).collect())?;
    let (wheel, plan) = (args.process.wheel(), args.process.plan());
    let rows = RowCounts { passes: plan.passes as usize, scans: plan.passes as usize };
    let model = args.model.compile(Process::Grinding, &args.process.law(), rows)?;
    let folder = StagedFolder::new(&args.out.beside(&args.inputs()), &GROUND)?;
    let keeping = args.state.keeping(plan.passes as usize)?;
    let refusal = sim::gpu::refusal_of(&Tool::from(wheel), &model);
    let device = args.backend.device(refusal, console)?;
    let executor = Executor::from(device.as_ref());
    let (grinding, session) = (Grinding { wheel, plan, model }, Session { executor, console });
    let mut ground = grind_asset(&args.folder, grinding, &keeping, folder.path(), session)?;
    finishing::write(&ground, &args.folder, folder, &[], console)?;
    console.step("weld", finishing::describe_rest(&ground));
    if let Some(error) = ground.run.stopped.take() {
        let passes = (ground.run.passes.len(), plan.passes as usize);
        return Err(error.context(kept(&args.out.out, passes, keeping.snapshots)));
    }
    console.step("done", format!("{}", args.out.out.display()));
    console.answer(&SimulateAnswer {
        out: &args.out.out,
        backend: name_of(device.as_ref()),
        real_time_factor: ground.run.real_time_factor(),
        seconds: ground.run.seconds,
        summary: ground.summary(),
    })
}
