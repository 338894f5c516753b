//! `robofin convert`: writes a scan or a robot's program in another format.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::Args;
use serde::Serialize;

use super::values::number;
use crate::console::Console;
use crate::wrong_use;
use files::folder::StagedFile;
use files::input::{self, MOST_MESH_BYTES};
use files::output::{FileKind, OutputPath};
use instruments::program::{self, Language, Program, ReadOptions};
use instruments::surface::{self, Source, Window};
use paths::program::{ProgramDefaults, log_of};
use trials::trial::{RPM, log_csv};

/// A converted file; it never replaces a file, because it cannot be distinguished from a measurement.
const CONVERTED: FileKind = FileKind { what: "a converted file", is_own: |_| false };

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin convert plate.gwy\n  robofin convert plate.gwy --out plate.x3p\n  \
                  robofin convert line.src --out line.csv --force-n 15 --spindle-rpm 6000")]
pub(super) struct ConvertArgs {
    /// A scan in any format, or a program: G-code, KRL (.src), RAPID, URScript or a list of poses.
    input: PathBuf,
    /// File to make: a scan as .sur, .x3p or .asc; a program as .csv, a path as `robofin path` writes it, or as .nc,
    /// .src, .mod, .script or .pose [default: only report what is in the input].
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Force setpoint of the moves of a program that have a speed of their own [N].
    #[arg(long, value_name = "N", default_value_t = 15.0, allow_negative_numbers = true, value_parser = number([0.0, 1e4]))]
    force_n: f64,
    /// Spindle speed where a program gives none [rpm].
    #[arg(long, value_name = "RPM", default_value_t = 6000.0, allow_negative_numbers = true, value_parser = number([0.0, 1e6]))]
    spindle_rpm: f64,
    /// Speed of rapid moves [mm/s].
    #[arg(long, value_name = "MM_S", default_value_t = 100.0, allow_negative_numbers = true, value_parser = number([1e-3, 1e4]))]
    rapid_mm_s: f64,
}

/// The answer of `convert --json`.
#[derive(Serialize)]
struct ConvertAnswer<'a> {
    format: &'static str,
    summary: String,
    notes: &'a [String],
    out: Option<&'a Path>,
}

/// Runs the verb.
pub(super) fn run(args: &ConvertArgs, console: &Console) -> Result<()> {
    if let Some(out) = args.out.as_ref().filter(|out| out.exists()) {
        let what = "this file exists and is not replaced";
        return Err(wrong_use(format!("--out {}: {what}: choose another name", out.display())));
    }
    let bytes = input::read(&args.input, MOST_MESH_BYTES)?;
    let file = args
        .out
        .as_ref()
        .map(|place| StagedFile::new(&OutputPath { place, force: false, inputs: &[&args.input] }, &CONVERTED));
    let file = file.transpose()?;
    let is_program = args.input.extension().is_some_and(|own| Language::of_extension(&own.to_string_lossy()).is_some());
    let (format, summary, notes, made) = if is_program {
        let program = program::read(&args.input, &bytes, &ReadOptions::default())?;
        (program.format, program.summary(), program.notes.clone(), args.program(&program)?)
    } else {
        let surface = surface::read(&Source { file: &args.input, bytes: &bytes, window: Window::default() })?;
        let made = args.out.as_ref().map(|out| surface::write(out, &surface)).transpose()?;
        (surface.format, surface.summary(), surface.notes, made)
    };
    console.step("read", format!("{format}: {summary}"));
    notes.iter().for_each(|note| console.step("note", note));
    if let (Some(file), Some(made), Some(out)) = (file, made, &args.out) {
        file.commit(&made)?;
        console.step("written", out.display().to_string());
    }
    console.answer(&ConvertAnswer { format, summary, notes: &notes, out: args.out.as_deref() })
}

impl ConvertArgs {
    /// Writes a program in the format of the output file; `None` without one.
    fn program(&self, program: &Program) -> Result<Option<Vec<u8>>> {
        let Some(out) = &self.out else { return Ok(None) };
        let extension = out.extension().unwrap_or_default().to_string_lossy();
        if extension.eq_ignore_ascii_case("csv") {
            let defaults =
                ProgramDefaults { rapid: self.rapid_mm_s * 1e-3, force: self.force_n, spindle: self.spindle_rpm * RPM };
            return Ok(Some(log_csv(&log_of(program, &defaults)).into_bytes()));
        }
        let language = Language::of_extension(&extension).with_context(|| {
            format!("{}: .csv, .nc, .src, .mod, .script or .pose is expected of a program", out.display())
        })?;
        Ok(Some(program::write(&program.points, language)?.into_bytes()))
    }
}
