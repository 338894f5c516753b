//! Passes of a plan along a weld, to and fro.

use anyhow::{Context, Result, ensure};
use effects::{CompiledModel, States};
use lab::{Origin, identity, model_origin};
use robot::Tool;
use sdf_bake::BrickGrid;
use sim::{CurvePoint, Executor, Pass, PassRecord, PassSettings, Progress, TOOL_CELLS};
use trial_simulation::RunState;

use super::Grinding;
use crate::asset::WeldTruth;
use crate::pass_run::Passes;

/// Greatest number of steps in a pass; a step is shorter than a millisecond.
const MOST_STEPS: f64 = 2e5;

/// Planned passes along the weld of an asset.
pub(super) struct WeldPasses<'a> {
    grinding: &'a Grinding,
    /// The workpiece as welded.
    welded: &'a BrickGrid,
    asset_sha256: &'a str,
    executor: Executor<'a>,
    tool: Tool,
    forth: sim::Path,
    back: sim::Path,
    settings: PassSettings,
}

/// A completed pass along a weld.
pub struct WeldPass {
    /// Figures and log.
    pub record: PassRecord,
    /// Volume lost by the field [m³].
    pub lost: f64,
}

impl<'a> WeldPasses<'a> {
    /// Plans the passes along a weld.
    ///
    /// - `welded`: the workpiece, and the SHA-256 of its asset's manifest
    ///
    /// # Errors
    /// If the weld gives no path, or a pass takes too many steps.
    pub(super) fn new(
        grinding: &'a Grinding,
        (welded, asset_sha256): (&'a BrickGrid, &'a str),
        weld: &WeldTruth,
        executor: Executor<'a>,
    ) -> Result<Self> {
        let Grinding { wheel, plan, .. } = grinding;
        let tool = Tool::from(*wheel);
        let (curve, search_reach) = followed(weld, &tool);
        let forth = sim::Path::along(&curve, plan.feed)?;
        let settings = PassSettings { force_setpoint: plan.force_setpoint, search_reach, ..PassSettings::default() };
        check_steps(&forth, &settings, welded.voxel)?;
        let back = forth.reversed();
        Ok(Self { grinding, welded, asset_sha256, executor, tool, forth, back, settings })
    }
}

impl Passes for WeldPasses<'_> {
    type Pass = WeldPass;

    fn count(&self) -> usize {
        self.grinding.plan.passes as usize
    }

    fn model(&self) -> &CompiledModel {
        &self.grinding.model
    }

    fn start(&self) -> RunState {
        let tool = States::new(self.model(), TOOL_CELLS);
        RunState { part: self.welded.clone(), tool, passes: 0, trial_time: 0.0, first_row: 0 }
    }

    fn run(&self, state: &mut RunState, progress: &mut dyn FnMut(Progress)) -> Result<WeldPass> {
        let RunState { passes: done, trial_time, .. } = *state;
        let path = if done % 2 == 0 { &self.forth } else { &self.back };
        let first = Pass::first(&self.tool, path, &self.settings, self.model());
        let pass = Pass { number: done + 1, trial_time, row: done, ..first };
        let before = state.part.volume();
        let record = self.executor.run_pass(&mut state.part, pass, &mut state.tool, progress);
        let record = record.with_context(|| format!("pass {}", done + 1))?;
        ensure!(
            record.steps_in_air < record.steps,
            "pass {}: the wheel never touched the part; is the weld within reach of the wheel?",
            done + 1
        );
        state.passes += 1;
        state.trial_time = state.passes as f64 * self.forth.duration();
        Ok(WeldPass { record, lost: before - state.part.volume() })
    }

    fn read_back(&self, before: &RunState, after: &RunState, record: PassRecord) -> Result<WeldPass> {
        Ok(WeldPass { record, lost: before.part.volume() - after.part.volume() })
    }

    fn record<'p>(&self, pass: &'p WeldPass) -> &'p PassRecord {
        &pass.record
    }

    fn describe(&self, WeldPass { record, lost }: &WeldPass) -> String {
        format!(
            "{:.2} mm³ removed from the field in {:.1} s ({} steps), force off by {:.2e} N rms, peak pressure {:.2} MPa",
            lost * 1e9,
            record.duration,
            record.steps,
            record.force_rms_error,
            record.pressure_max * 1e-6
        )
    }

    fn origin(&self, _: usize) -> Origin {
        let Grinding { wheel, plan, model } = self.grinding;
        let mut origin = model_origin(model);
        origin.insert("asset".into(), self.asset_sha256.to_owned());
        origin.insert("wheel".into(), identity(wheel));
        origin.insert("force setpoint".into(), format!("{:?} N", plan.force_setpoint));
        origin.insert("feed".into(), format!("{:?} m/s", plan.feed));
        origin
    }
}

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
