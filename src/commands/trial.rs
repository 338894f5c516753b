//! `robofin trial`: folders of scans and logs, synthetic campaigns with hidden effects, and their answers.

use std::path::{Path, PathBuf};

use anyhow::{Result, anyhow};
use clap::{Args, Subcommand, ValueEnum};
use effects::Process;
use rand::TryRng;
use rand::rngs::SysRng;
use serde::Serialize;
use serde_json::Value;

use super::flags::{OutFlags, SEEDS};
use super::model_flags::OwnFlags;
use super::trial_files::{CheckArgs, InitArgs, check, init};
use super::values::{one_of, whole};
use crate::console::Console;
use crate::wrong_use;
use virtual_lab::write::{ANSWER_FILE, Places, SEAL_FILE, key_place, unseal, write_into};
use virtual_lab::{Choice, Experiment, FrontEnd, Hidden, Key, Made, MakeError, Plan, Size};

/// Heading of the help for hidden effects.
const HIDDEN: &str = "Hidden";
/// Accepted numbers of trials; each takes seconds.
const TRIALS: [u64; 2] = [1, 64];

#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  robofin trial init my-plate\n  robofin trial check my-plate --out out/check\n  robofin trial synth --out out/dull --effect \"grit-dulling:dulling_volume=150 mm^3\" --size small\n  \
                        robofin trial synth --out out/example --random --sealed\n  \
                        robofin trial unseal out/example --key out/example.key"
)]
pub(super) struct TrialArgs {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Write a first trial.toml for a folder of scans and logs.
    #[command(after_help = "Example:\n  robofin trial init my-plate")]
    Init(InitArgs),
    /// Draw scans, logs and tool over each other, with every check, before any fit.
    #[command(after_help = "Example:\n  robofin trial check my-plate --out out/check")]
    Check(CheckArgs),
    /// Make a campaign of synthetic measurements in which effects are hidden.
    #[command(after_help = "Examples:\n  robofin trial synth --out out/clean\n  \
                            robofin trial synth --out out/tilt --plan paper --effect \"tool-tilt:roll_angle=12 mrad\"\n  \
                            robofin trial synth --out out/example --random --sealed --size small")]
    Synth(SynthArgs),
    /// Open the sealed answer of a synthetic campaign.
    #[command(after_help = "Example:\n  robofin trial unseal out/example --key out/example.key")]
    Unseal(UnsealArgs),
}

#[derive(Debug, Args)]
struct SynthArgs {
    #[command(flatten)]
    out: OutFlags,
    /// Process of the trials.
    #[arg(long, value_enum, default_value_t, help_heading = "Measurements")]
    process: ProcessFlag,
    /// Effect to hide; may be given several times. Parameters that are not given get a visible size; of one per pass or
    /// scan the value is the standard deviation [default: none].
    #[arg(
        long = "effect",
        value_name = "NAME[:PARAMETER=VALUE,...]",
        value_parser = parse_hidden,
        help_heading = HIDDEN
    )]
    effect: Vec<Hidden>,
    /// Draw what is hidden: nothing, an effect of the library, or one that it lacks.
    #[arg(long, conflicts_with = "effect", help_heading = HIDDEN)]
    random: bool,
    /// Encrypt the answer; the key goes to a file beside the folder.
    #[arg(long, help_heading = HIDDEN)]
    sealed: bool,
    /// Plan of the passes.
    #[arg(long, value_enum, default_value_t, help_heading = "Measurements")]
    plan: PlanFlag,
    /// Number of trials [default: 1 for the plan paper, else 4].
    #[arg(
        long,
        value_name = "N",
        allow_negative_numbers = true,
        value_parser = whole::<usize>(TRIALS),
        help_heading = "Measurements"
    )]
    trials: Option<usize>,
    /// Size of workpieces and scans.
    #[arg(long, value_enum, default_value_t, help_heading = "Measurements")]
    size: SizeFlag,
    /// Errors of scanner, robot and tool besides the hidden effects.
    #[arg(
        long,
        default_value = FrontEnd::default().word(),
        value_parser = one_of(&FrontEnd::ALL, |front_end| [front_end.word(), front_end.about()]),
        help_heading = "Measurements"
    )]
    instrument: FrontEnd,
    /// Seed; the same seed gives the same bytes [default: 0; sealed: a random one that is not shown].
    #[arg(long, value_name = "SEED", allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    seed: Option<u64>,
    #[command(flatten, next_help_heading = HIDDEN)]
    own: OwnFlags,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum ProcessFlag {
    /// A weld bead, ground with a wheel.
    #[default]
    Grinding,
    /// A coated panel, sanded with a pad.
    Sanding,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum PlanFlag {
    /// One trial of two equal passes.
    Paper,
    /// Force, feed, speed and direction differ from pass to pass.
    #[default]
    Varied,
    /// Equal but for their directions.
    Reversed,
    /// The feed steps within each pass, the force between them.
    Steps,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum SizeFlag {
    /// A bead of 30 mm, a panel of 60 by 50 mm.
    Small,
    /// A bead of 100 to 140 mm, a panel of 120 by 90 mm.
    #[default]
    Full,
}

#[derive(Debug, Args)]
struct UnsealArgs {
    /// Folder of the campaign.
    folder: PathBuf,
    /// The key's file.
    #[arg(long, value_name = "FILE")]
    key: PathBuf,
}

/// The answer of `trial synth --json`; it does not reveal the hidden effects.
#[derive(Serialize)]
struct SynthAnswer<'a> {
    out: &'a Path,
    trials: usize,
    passes: usize,
    sealed: bool,
    answer: PathBuf,
    #[serde(skip_serializing_if = "Option::is_none")]
    key: Option<PathBuf>,
}

/// The answer of `trial unseal --json`.
#[derive(Serialize)]
struct UnsealAnswer {
    measurements_unchanged: bool,
    answer: Value,
}

pub(super) fn run(args: &TrialArgs, console: &Console) -> Result<()> {
    match &args.action {
        Action::Init(args) => init(args, console),
        Action::Check(args) => check(args, console),
        Action::Synth(args) => synth(args, console),
        Action::Unseal(args) => open(args, console),
    }
}

impl SynthArgs {
    fn experiment(&self) -> Result<Experiment> {
        let process = match self.process {
            ProcessFlag::Grinding => Process::Grinding,
            ProcessFlag::Sanding => Process::Sanding,
        };
        let plan = match self.plan {
            PlanFlag::Paper => Plan::Paper,
            PlanFlag::Varied => Plan::Varied,
            PlanFlag::Reversed => Plan::Reversed,
            PlanFlag::Steps => Plan::Steps,
        };
        let trials = self.trials.unwrap_or(plan.usual_trials());
        let size = match self.size {
            SizeFlag::Small => Size::Small,
            SizeFlag::Full => Size::Full,
        };
        let choice = if self.random { Choice::Drawn } else { Choice::These(self.effect.clone()) };
        let seed = self.seed()?;
        let base = Experiment::new(process, &self.own.library()?, seed)?;
        Ok(Experiment { plan, trials, size, choice, ..base }.behind(self.instrument))
    }

    fn seed(&self) -> Result<u64> {
        match self.seed {
            Some(seed) => Ok(seed),
            None if self.sealed => SysRng.try_next_u64().map_err(|error| anyhow!("no random seed: {error}")),
            None => Ok(0),
        }
    }

    fn inputs(&self) -> Vec<&Path> {
        self.own.effects.iter().map(PathBuf::as_path).collect()
    }

    fn key(&self) -> Option<Key> {
        self.sealed.then(|| self.seed.map_or_else(Key::random, Key::of_seed))
    }
}

fn parse_hidden(text: &str) -> Result<Hidden, String> {
    Hidden::parse(text).map_err(|found| {
        format!(
            "{found} is not PARAMETER=VALUE; NAME or NAME:PARAMETER=VALUE,... is expected, such as \
             \"tool-tilt:roll_angle=12 \
             mrad\""
        )
    })
}

fn synth(args: &SynthArgs, console: &Console) -> Result<()> {
    let out = &args.out.out;
    let experiment = args.experiment()?;
    let places = Places::take(&args.out.beside(&args.inputs()), args.sealed)?;
    let bar = console.bar("passes", experiment.passes() as u64);
    let made = experiment.make_reporting(&|| bar.inc(1));
    bar.finish_and_clear();
    let made = made.map_err(|error| match error {
        MakeError::Model(error) => wrong_use(error.to_string()),
        MakeError::Effect(error) => error.into(),
        MakeError::Truth(error) => error.into(),
    })?;
    write_into(&made, &experiment, places, args.key())?;
    describe(args, &made, console);
    let (file, key) = if args.sealed { (SEAL_FILE, Some(key_place(out))) } else { (ANSWER_FILE, None) };
    console.answer(&SynthAnswer {
        out,
        trials: made.trials.len(),
        passes: experiment.passes(),
        sealed: args.sealed,
        answer: out.join(file),
        key,
    })
}

fn describe(args: &SynthArgs, made: &Made, console: &Console) {
    let out = &args.out.out;
    let passes: usize = made.trials.iter().map(|trial| trial.passes.len()).sum();
    console.step("measured", format!("{} trials, {passes} passes", made.trials.len()));
    if args.sealed {
        console.step("sealed", format!("the answer; its key is {}", key_place(out).display()));
    } else {
        let names: Vec<&str> = made.answer.effects.iter().map(|effect| effect.name.as_str()).collect();
        console.step("hidden", if names.is_empty() { "nothing".to_owned() } else { names.join(", ") });
    }
    console.step("done", format!("{}", out.display()));
}

fn open(args: &UnsealArgs, console: &Console) -> Result<()> {
    let unsealed = unseal(&args.folder, &args.key)?;
    let effects = unsealed.answer["effects"].as_array().cloned().unwrap_or_default();
    let texts: Vec<String> = effects.iter().map(shown).collect();
    console.step("hidden", if texts.is_empty() { "nothing".to_owned() } else { texts.join("\n") });
    console.step("model", unsealed.answer["model"].as_str().unwrap_or_default());
    let measurements_unchanged = unsealed.measurements_unchanged;
    let seal = match measurements_unchanged {
        true => "intact; the measurements are unchanged",
        false => "intact; the measurements were CHANGED since it was made",
    };
    console.step("seal", seal);
    console.answer(&UnsealAnswer { measurements_unchanged, answer: unsealed.answer })
}

/// Describes an effect with its parameters in one line.
fn shown(effect: &Value) -> String {
    let parameter = |(name, quantity): (&String, &Value)| {
        let values: Vec<&str> = quantity["values"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        format!("{name} = {} {}", values.join(" "), quantity["unit"].as_str().unwrap_or_default())
    };
    let parameters: Vec<String> = effect["parameters"].as_object().into_iter().flatten().map(parameter).collect();
    format!("{}: {}", effect["name"].as_str().unwrap_or_default(), parameters.join(", "))
}
