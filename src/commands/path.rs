//! `robofin path`: plans a tool path along a weld or over a patch of an asset.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use glam::DVec2;
use serde::Serialize;

use super::flags::OutFlags;
use super::values::{number, whole};
use crate::asset::{AssetFields, Manifest, Welds};
use crate::console::Console;
use files::folder::StagedFile;
use files::input::MOST_TEXT_BYTES;
use files::output::FileKind;
use instruments::program::{self, Language, ReadOptions};
use paths::program::points_of;
use paths::{LineDirection, Plan, Raster, Travel, along_weld, raster};
use robot::{LogRow, Tool, ToolText};
use trials::trial::{Log, RPM, log_csv, read_log};

/// Accepted sizes of a tool [mm], the same as for the wheel of `robofin simulate`.
const SIZES_MM: (f64, f64) = (0.1, 1000.0);
/// Heading of the help for tool and motion.
const MOTION: &str = "Tool and motion";
/// Greatest coordinate of a raster [mm]: the longest part is 100 m.
const FARTHEST_MM: f64 = 1e5;

#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  robofin weld data/bracket.obj --out out/bracket --seed 7\n  \
                  robofin path out/bracket --weld 1 --tool wheel:radius=50mm,width=20mm --out out/weld-path.csv\n  \
                  robofin path out/bracket --raster=-5,-5,5,5 --spacing-mm 2 --zigzag --tool pad:radius=10mm --out \
                  out/raster.csv")]
pub(super) struct PathArgs {
    /// Asset folder made by `robofin weld`.
    asset: PathBuf,
    #[command(flatten)]
    out: OutFlags,
    /// Id of the weld to follow [default: 1].
    #[arg(
        long,
        value_name = "ID",
        conflicts_with = "raster",
        allow_negative_numbers = true,
        value_parser = whole::<u16>([1, u16::MAX as u64]),
        help_heading = "Way"
    )]
    weld: Option<u16>,
    /// Patch of the part's top to cover in lines, in the part's frame: X0,Y0,X1,Y1 [mm].
    #[arg(
        long,
        value_name = "MM",
        requires = "spacing_mm",
        allow_hyphen_values = true,
        value_parser = parse_raster,
        help_heading = "Way"
    )]
    raster: Option<[f64; 4]>,
    /// Distance between the lines of a raster, at most [mm].
    #[arg(
        long,
        value_name = "MM",
        requires = "raster",
        allow_negative_numbers = true,
        value_parser = number([1e-3, 1e3]),
        help_heading = "Way"
    )]
    spacing_mm: Option<f64>,
    /// Direction in which the lines of a raster run.
    #[arg(long, value_enum, default_value_t, help_heading = "Way")]
    direction: DirectionFlag,
    /// Lines back and forth without lifting; otherwise the tool returns in the air.
    #[arg(long, requires = "raster", help_heading = "Way")]
    zigzag: bool,
    /// The tool: wheel:radius=LENGTH,width=LENGTH or pad:radius=LENGTH, lengths with mm or m.
    #[arg(
        long,
        value_name = "TOOL",
        default_value = "wheel:radius=50mm,width=20mm",
        value_parser = parse_tool,
        help_heading = MOTION
    )]
    tool: Tool,
    #[command(flatten, next_help_heading = MOTION)]
    motion: MotionFlags,
}

/// Speed, force and time.
#[derive(Clone, Debug, Args)]
struct MotionFlags {
    /// Speed along the path [mm/s].
    #[arg(
        long,
        value_name = "MM_S",
        default_value_t = 5.0,
        allow_negative_numbers = true,
        value_parser = number([1e-3, 1e4])
    )]
    feed_mm_s: f64,
    /// Distance over which the speed rises from zero or falls to it, at each end of a line [mm].
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 2.0,
        allow_negative_numbers = true,
        value_parser = number([0.0, 1e3])
    )]
    ramp_mm: f64,
    /// Height above the surface where the path starts and ends [mm].
    #[arg(
        long,
        value_name = "MM",
        default_value_t = 5.0,
        allow_negative_numbers = true,
        value_parser = number([0.0, 1e3])
    )]
    approach_mm: f64,
    /// Time between two rows [ms].
    #[arg(
        long,
        value_name = "MS",
        default_value_t = 10.0,
        allow_negative_numbers = true,
        value_parser = number([0.1, 1e4])
    )]
    period_ms: f64,
    /// Force setpoint on the surface [N].
    #[arg(
        long,
        value_name = "N",
        default_value_t = 15.0,
        allow_negative_numbers = true,
        value_parser = number([1e-3, 1e4])
    )]
    force_n: f64,
    /// Spindle speed [rpm].
    #[arg(
        long,
        value_name = "RPM",
        default_value_t = 6000.0,
        allow_negative_numbers = true,
        value_parser = number([0.0, 1e6])
    )]
    spindle_rpm: f64,
}

/// Direction in which the lines of a raster run.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum DirectionFlag {
    /// Along x.
    #[default]
    X,
    /// Along y.
    Y,
}

/// A planned path, with the columns of a log: the force is zero or the setpoint, the spindle speed constant.
const PLAN: FileKind = FileKind { what: "a planned path", is_own: is_plan };

fn is_plan(file: &Path) -> bool {
    if language(file).is_some() {
        return files::input::read(file, MOST_TEXT_BYTES)
            .is_ok_and(|bytes| program::read(file, &bytes, &ReadOptions::default()).is_ok());
    }
    let Ok(log) = read_log(file) else { return false };
    let rows = &log.content.rows;
    let setpoint = rows.iter().map(|row| row.force).fold(0.0, f64::max);
    let is_planned =
        |row: &LogRow| (row.force == 0.0 || row.force == setpoint) && row.spindle_speed == rows[0].spindle_speed;
    log.content.covariates.is_empty() && rows.iter().all(is_planned)
}

/// Returns the robot language of a file's extension.
fn language(file: &Path) -> Option<Language> {
    file.extension().and_then(|extension| Language::of_extension(&extension.to_string_lossy()))
}

/// Writes a plan in the format of the file's name: a robot's program, or rows.
fn text_of(log: &Log, file: &Path) -> Result<String> {
    match language(file) {
        Some(language) => Ok(program::write(&points_of(log), language)?),
        None => Ok(log_csv(log)),
    }
}

/// The answer of `path --json`.
#[derive(Serialize)]
struct PathAnswer<'a> {
    out: &'a Path,
    rows: usize,
    lines: usize,
    pressed_length_mm: f64,
    duration_s: f64,
    feed_mm_s: f64,
    force_n: f64,
    has_approach_axis: bool,
}

pub(super) fn run(args: &PathArgs, console: &Console) -> Result<()> {
    let (travel, patch) = (args.travel(), args.patch());
    let file = StagedFile::new(&args.out.beside(&[&args.asset]), &PLAN)?;
    Manifest::read(&args.asset)?;
    let plan = match &patch {
        Some(patch) => raster(&AssetFields::open(&args.asset)?.welded, patch)?,
        None => weld_plan(&args.asset, args.weld.unwrap_or(1))?,
    };
    let log = plan.timed(&travel)?;
    file.commit(text_of(&log, &args.out.out)?.as_bytes())?;
    let answer = args.answer(&plan, &log, patch.map_or(1, |patch| patch.count()));
    console.step(
        "path",
        format!(
            "{} lines, {:.2} mm on the surface, {:.2} s in {} rows",
            answer.lines, answer.pressed_length_mm, answer.duration_s, answer.rows
        ),
    );
    console.step("done", format!("{}", args.out.out.display()));
    console.answer(&answer)
}

fn weld_plan(asset: &Path, id: u16) -> Result<Plan> {
    let welds = Welds::read(asset)?.welds;
    let known: Vec<String> = welds.iter().map(|weld| weld.id.to_string()).collect();
    let weld = welds.iter().find(|weld| weld.id == id);
    let weld = weld.with_context(|| format!("--weld {id}: the asset has the welds {}", known.join(", ")))?;
    Ok(along_weld(&weld.curve.position, &weld.curve.normal, weld.height_mm * 1e-3)?)
}

impl PathArgs {
    fn travel(&self) -> Travel {
        let motion = &self.motion;
        Travel {
            tool: self.tool.clone(),
            feed: motion.feed_mm_s * 1e-3,
            ramp: motion.ramp_mm * 1e-3,
            clearance: motion.approach_mm * 1e-3,
            period: motion.period_ms * 1e-3,
            force: motion.force_n,
            spindle_speed: motion.spindle_rpm * RPM,
        }
    }

    fn patch(&self) -> Option<Raster> {
        let ([x0, y0, x1, y1], spacing) = self.raster.zip(self.spacing_mm)?;
        Some(Raster {
            low: DVec2::new(x0, y0) * 1e-3,
            high: DVec2::new(x1, y1) * 1e-3,
            spacing: spacing * 1e-3,
            direction: match self.direction {
                DirectionFlag::X => LineDirection::X,
                DirectionFlag::Y => LineDirection::Y,
            },
            zigzag: self.zigzag,
            clearance: self.motion.approach_mm * 1e-3,
        })
    }

    fn answer(&self, plan: &Plan, log: &Log, lines: usize) -> PathAnswer<'_> {
        PathAnswer {
            out: &self.out.out,
            rows: log.rows.len(),
            lines,
            pressed_length_mm: plan.pressed_length() * 1e3,
            duration_s: log.rows.last().map_or(0.0, |row| row.time),
            feed_mm_s: self.motion.feed_mm_s,
            force_n: self.motion.force_n,
            has_approach_axis: log.has_approach,
        }
    }
}

/// Parses `X0,Y0,X1,Y1` [mm].
fn parse_raster(text: &str) -> Result<[f64; 4], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let corners = numbers.and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
    let is_patch = |[x0, y0, x1, y1]: &[f64; 4]| x0 < x1 && y0 < y1;
    let is_near = |corners: &[f64; 4]| corners.iter().all(|number| number.abs() <= FARTHEST_MM);
    corners.filter(|corners| is_patch(corners) && is_near(corners)).ok_or_else(|| {
        format!(
            "X0,Y0,X1,Y1 in mm with X0 < X1 and Y0 < Y1, each within {FARTHEST_MM:e}, is expected, for example 0,0,40,20"
        )
    })
}

/// Parses `wheel:radius=50mm,width=20mm` or `pad:radius=25mm`.
fn parse_tool(text: &str) -> Result<Tool, String> {
    let (least, most) = SIZES_MM;
    let accepted = |why: String| format!("{why}; sizes of {least:?} to {most:?} mm are accepted");
    let tool = match text.parse().map_err(accepted)? {
        ToolText::Solid(tool @ (Tool::Wheel(_) | Tool::Pad(_))) => tool,
        _ => return Err("wheel:radius=LENGTH,width=LENGTH or pad:radius=LENGTH is expected".to_owned()),
    };
    let sizes = match &tool {
        Tool::Wheel(wheel) => [("radius", wheel.radius), ("width", wheel.width)],
        other => [("radius", other.rim_radius()); 2],
    };
    let is_off = |(_, size): &(&str, f64)| !(least..=most).contains(&(1e3 * size));
    if let Some((key, size)) = sizes.into_iter().find(is_off) {
        return Err(format!("the {key} is {:?} mm; {least:?} to {most:?} mm is accepted", 1e3 * size));
    }
    Ok(tool)
}
