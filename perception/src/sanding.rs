//! Simulated sanding of a coated workpiece along a pattern, stage by stage.
//!
//! Pressure, spindle speed and feed are chosen so that one straight stroke of the pad leaves a dose D of 1.6 on its
//! centre line. With a pad of radius R under the mean pressure p, ∫ p ω r dt along the centre line is p ω R² / v, so
//! Eq. (2) gives the feed v = (K_P/h_c) p ω R² / D.

use effects::{CompiledModel, Library, Model, ModelError, RowCounts, States};
use glam::DVec3;
use paths::{PadPatch, PatchError, Pattern, Stroke};
use robot::{Pad, Tool};
use sdf_bake::BrickGrid;
use serde::{Deserialize, Serialize};
use sim::{Pass, PassError, PassRecord, PassSettings, PathError, PathSample, TOOL_CELLS, run_pass};
use thiserror::Error;

/// Dose on the centre line of one straight stroke.
const LINE_DOSE: f64 = 1.6;
/// Mean pressure under the pad [Pa].
const PRESSURE: f64 = 14e3;
/// Spindle speed [rad/s]: 3000 rpm.
pub const SPINDLE: f64 = 100.0 * std::f64::consts::PI;
/// Text of the model: the base laws of sanding.
const MODEL: &str = "process = \"sanding\"\n";

/// Reason why a workpiece cannot be sanded.
#[derive(Debug, Error)]
pub enum SandingError {
    /// No region is large enough for the pad.
    #[error(transparent)]
    Patch(#[from] PatchError),
    /// The base laws of sanding do not compile.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The base laws have no rate.
    #[error("the base law of sanding has no sanding_rate")]
    NoRate,
    /// A stroke is no path.
    #[error(transparent)]
    Path(#[from] PathError),
    /// A pass failed.
    #[error(transparent)]
    Pass(#[from] PassError),
}

/// Results of one stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageFigures {
    /// Time in contact [s].
    pub contact_s: f64,
    /// Impulse ∫ F dt [N s].
    pub impulse_ns: f64,
    /// Volume of coating removed in this stage [mm³].
    pub coating_mm3: f64,
}

/// Simulates the stages of a path on a workpiece; `done` gets the part after each stage.
///
/// # Errors
/// If no region is large enough for the pad, a pass fails, or `done` fails.
pub fn sand<E: From<SandingError>>(
    part: &mut BrickGrid,
    (pattern, stages): (Pattern, u32),
    mut done: impl FnMut(&BrickGrid, StageFigures) -> Result<(), E>,
) -> Result<Setting, E> {
    let patch = PadPatch::find(part).map_err(SandingError::from)?;
    let model = model()?;
    let setting = Setting::of(patch.radius, &model)?;
    let mut states = States::new(&model, TOOL_CELLS);
    for strokes in pattern.stages(&patch, stages) {
        let mut figures = StageFigures::default();
        for stroke in &strokes {
            figures.add(&setting.stroke(part, &path(stroke, &patch, setting.feed)?, (&model, &mut states))?);
        }
        done(part, figures)?;
    }
    Ok(setting)
}

/// Compiles the base laws of sanding.
fn model() -> Result<CompiledModel, SandingError> {
    let library = Library::builtin();
    Ok(CompiledModel::new(&Model::parse("sanding", MODEL, library)?, library, RowCounts::default())?)
}

impl StageFigures {
    fn add(&mut self, pass: &PassRecord) {
        self.contact_s += pass.contact_time;
        self.impulse_ns += pass.impulse;
        self.coating_mm3 += 1e9 * pass.coating_volume;
    }
}

/// Settings of the sanding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Radius of the pad [m].
    pub radius: f64,
    /// Normal force [N].
    pub force: f64,
    /// Feed along the path [m/s].
    pub feed: f64,
}

impl Setting {
    fn of(radius: f64, model: &CompiledModel) -> Result<Self, SandingError> {
        let rate = model.law_value("sanding_rate").ok_or(SandingError::NoRate)?;
        let feed = rate * PRESSURE * SPINDLE * radius * radius / LINE_DOSE;
        Ok(Self { radius, force: PRESSURE * std::f64::consts::PI * radius * radius, feed })
    }

    /// Simulates one stroke.
    fn stroke(
        &self,
        part: &mut BrickGrid,
        path: &sim::Path,
        (model, states): (&CompiledModel, &mut States),
    ) -> Result<PassRecord, SandingError> {
        let tool = Tool::from(Pad { radius: self.radius });
        let settings = PassSettings { force_setpoint: self.force, spindle_speed: SPINDLE, ..PassSettings::default() };
        Ok(run_pass(part, Pass::first(&tool, path, &settings, model), states, &mut |_| {})?)
    }
}

/// Makes a stroke at constant feed, with the pad flat on the surface.
fn path(stroke: &Stroke, patch: &PadPatch, feed: f64) -> Result<sim::Path, SandingError> {
    let mut time = 0.0;
    let mut before = None;
    let samples = stroke.iter().map(|&at| {
        let rest = patch.rest(at);
        time += before.map_or(0.0, |before: DVec3| before.distance(rest.contact)) / feed;
        before = Some(rest.contact);
        let axis = DVec3::Y.reject_from_normalized(rest.approach).normalize();
        PathSample { time, position: rest.contact, approach: rest.approach, axis }
    });
    Ok(sim::Path::from_samples(samples.collect())?)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::Shape;

    #[test]
    fn a_line_leaves_its_dose_in_the_middle_and_none_beside_the_pad() {
        let mut panel = Shape::Panel.field(1e-3);
        let phi = panel.phi.clone();
        let patch = PadPatch::find(&panel).unwrap();
        let mut last = 0.0;
        let setting = sand(&mut panel, (Pattern::AlongX, 5), |part, figures| {
            let dose: f64 = part.dose.iter().map(|&dose| f64::from(dose)).sum();
            assert!(dose > last && figures.coating_mm3 > 0.0, "{figures:?}");
            last = dose;
            Ok::<(), SandingError>(())
        });
        let setting = setting.unwrap();
        assert!(panel.phi == phi, "sanding moved the surface");
        let line = patch.rest(DVec2::new(0.5 * (patch.low.x + patch.high.x), patch.low.y));
        let dose = f64::from(panel.sample_dose(line.contact));
        // Neighbouring strokes overlap here, so the dose of one stroke is the least.
        assert!(dose > 0.9 * LINE_DOSE && dose < 2.0 * LINE_DOSE, "{dose}, {setting:?}");
        let beside = patch.rest(patch.low).contact - DVec3::new(1.2 * patch.radius, 0.0, 0.0);
        assert_eq!(panel.sample_dose(beside), 0.0);
    }
}
