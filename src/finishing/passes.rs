//! Passes of a plan along a weld, one after the other; if one fails, those before it are kept.

use std::path::PathBuf;

use anyhow::{Context, Error, Result, ensure};
use effects::{CompiledModel, States};
use robot::Tool;
use sdf_bake::BrickGrid;
use sim::{CurvePoint, Pass, PassRecord, PassSettings, TOOL_CELLS};

use super::{Grinding, Session};
use crate::asset::WeldTruth;
use lab::Origin;
use study::snapshot::{self, Resume, Snapshot};

/// Greatest number of steps in a pass; a step is shorter than a millisecond.
const MOST_STEPS: f64 = 2e5;

/// Refuses a pass that takes too many steps.
fn check_steps(path: &sim::Path, settings: &PassSettings, voxel: f64) -> Result<()> {
    let steps = settings.expected_steps(path, voxel);
    ensure!(
        steps <= MOST_STEPS,
        "a pass of {:.3e} s over {:.3e} mm takes {steps:.1e} steps in a field of {:.3e} mm voxels, and {MOST_STEPS:.0e} are \
         accepted: use a faster --feed-mm-s",
        path.duration(),
        path.length() * 1e3,
        voxel * 1e3,
    );
    Ok(())
}

/// Passes done.
#[derive(Default)]
pub(super) struct Done {
    pub(super) passes: Vec<PassRecord>,
    /// Volume lost by the field in each pass [m³].
    pub(super) lost: Vec<f64>,
    /// Volume lost in a failed pass, up to its last good step [m³].
    pub(super) lost_since: f64,
    /// Reason why no further pass was run.
    pub(super) stopped: Option<Error>,
    /// States of the wheel; `None` for a fresh wheel.
    tool: Option<States>,
    /// Folder for the states after further passes, and the inputs that they depend on.
    pub(super) folder: Option<(PathBuf, Origin)>,
}

impl Done {
    /// Reads the passes up to a state of an earlier run, and sets `grid` to that state.
    pub(super) fn read(resume: &Resume, grid: &mut BrickGrid, model: &CompiledModel, origin: &Origin) -> Result<Self> {
        let mut done = Self::default();
        for pass in 1..=resume.passes {
            let state = snapshot::read(&resume.folder, pass, model, origin)?;
            done.lost.push(grid.volume() - state.part.volume());
            done.passes.push(state.record);
            done.tool = Some(state.tool);
            *grid = state.part;
        }
        Ok(done)
    }
}

/// Runs the remaining passes of a plan.
pub(super) fn run_passes(
    grid: &mut BrickGrid,
    mut done: Done,
    weld: &WeldTruth,
    Grinding { wheel, plan, model }: &Grinding,
    session: Session<'_>,
) -> Result<Done> {
    let tool = &Tool::from(*wheel);
    let (curve, search_reach) = followed(weld, tool);
    let forth = sim::Path::along(&curve, plan.feed)?;
    let settings = PassSettings { force_setpoint: plan.force_setpoint, search_reach, ..PassSettings::default() };
    check_steps(&forth, &settings, grid.voxel)?;
    let back = forth.reversed();
    let mut states = done.tool.take().unwrap_or_else(|| States::new(model, TOOL_CELLS));
    let mut volume = grid.volume();
    for number in done.passes.len() + 1..=plan.passes as usize {
        let path = if number % 2 == 1 { &forth } else { &back };
        let trial_time = (number - 1) as f64 * forth.duration();
        let pass = Pass { number, trial_time, row: number - 1, ..Pass::first(tool, path, &settings, model) };
        let record = match run_one((grid, &mut states), pass, session) {
            Ok(record) => record,
            Err(error) if number == 1 => return Err(error),
            Err(error) => {
                done.stopped = Some(error);
                done.lost_since = volume - grid.volume();
                break;
            }
        };
        let left = grid.volume();
        let lost = volume - left;
        session.console.step(&format!("pass {number}"), describe(&record, lost));
        if let Some((folder, origin)) = &done.folder {
            let trial_time = number as f64 * forth.duration();
            let state = Snapshot { part: grid.clone(), tool: states.clone(), trial_time, record: record.clone() };
            snapshot::write(folder, number, &state, origin.clone())?;
        }
        done.lost.push(lost);
        volume = left;
        done.passes.push(record);
    }
    Ok(done)
}

/// Returns the line that the tool follows on a weld, and the search range for the surface above and below it [m].
///
/// A fillet's centreline is the crease below it, and its approach is oblique. The search starts from the crown, within
/// half of the weld's width or the bead's height, so that it does not reach the adjacent walls.
pub fn followed(weld: &WeldTruth, tool: &Tool) -> (Vec<CurvePoint>, f64) {
    let is_fillet = weld.toe_height_mm > 0.0;
    let lift = if is_fillet { weld.height_mm * 1e-3 } else { 0.0 };
    let points = weld.curve.position.iter().zip(&weld.curve.normal);
    let curve = points.map(|(&position, &normal)| CurvePoint { position: position + lift * normal, normal });
    let reach = match tool {
        Tool::Wheel(wheel) if is_fillet => (0.5 * wheel.width).min(lift),
        _ => PassSettings::default().search_reach,
    };
    (curve.collect(), reach)
}

/// Runs a pass; an error names it.
fn run_one(
    (grid, states): (&mut BrickGrid, &mut States),
    pass: Pass,
    Session { executor, console }: Session<'_>,
) -> Result<PassRecord> {
    let name = format!("pass {}", pass.number);
    let bar = console.bar(&name, 100);
    let mut show = |at: sim::Progress| bar.set_position((100.0 * at.time / at.duration) as u64);
    let record = executor.run_pass(grid, pass, states, &mut show).context(name.clone());
    bar.finish_and_clear();
    let record = record?;
    ensure!(
        record.steps_in_air < record.steps,
        "{name}: the wheel never touched the part; is the weld within reach of the wheel?"
    );
    Ok(record)
}

/// Describes a pass for people; `lost` is the volume lost by the field [m³], called removed volume in files and pages.
fn describe(record: &PassRecord, lost: f64) -> String {
    format!(
        "{:.2} mm³ removed from the field in {:.1} s ({} steps), force off by {:.2e} N rms, peak pressure {:.2} MPa",
        lost * 1e9,
        record.duration,
        record.steps,
        record.force_rms_error,
        record.pressure_max * 1e-6
    )
}
