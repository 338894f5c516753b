//! Inputs and settings of a pass; the defaults suit a weld on steel.

use sdf_bake::BrickGrid;
use sdf_bake::redistance::KEPT_VOXELS;
use serde::{Deserialize, Serialize};
pub use shaders::constants::{LONGEST_STEP, TOUCH};
use std::cell::RefCell;
use std::ops::Range;

use crate::clock::Clock;
use crate::covariates::Covariates;
use crate::force_profile::ForceProfile;
use crate::measured::Measured;
use crate::path::Path;
use crate::wrench::WrenchGauge;
use effects::{CompiledModel, Hook, RunError, Variable};
use robot::Controller;
use robot::Tool;

/// Band that a field needs for its surface to move while distances beyond it are reinitialised [voxels].
pub const BAND_VOXELS: f64 = KEPT_VOXELS + 1.0;

/// Minimum number of cells across a tool.
const LEAST_CELLS: f64 = 2.0;
/// Longest step of all [s]: for sanding, while the tool keeps its velocity.
pub(crate) const LONGEST_STEADY_STEP: f64 = 0.08;
/// Longest step under an effect that makes the controller's reading depend on time [s]: a tenth of a period at 20 Hz.
const CLOCKED_STEP: f64 = 5e-3;

/// Controller and numerics of a pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PassSettings {
    /// Controller of the force. Default: ideal.
    pub controller: Controller,
    /// Normal force the controller holds [N]. Default 15.
    pub force_setpoint: f64,
    /// Speed of the spindle [rad/s]. Default 628, 6000 rpm.
    pub spindle_speed: f64,
    /// Distance of the tool in one step [voxels]; longer for a pad that sands. Default 0.6.
    pub step_voxels: f64,
    /// True if an admittance controller is stepped at its own period only where its dynamics matter. Default: true.
    pub quasi_static: bool,
    /// Distance of the tool after which the height field is written back [voxels]. Default 6.
    pub write_back_voxels: f64,
    /// Thickness of the coating h_c [m], for sanding. Default 50e-6.
    pub coating: f64,
    /// Search range for the tool's travel above and below its path [m]. Default 20e-3.
    pub search_reach: f64,
    /// Number of steps after which a pass is given up: some parameter values make the contact too unsteady to simulate.
    /// Default: none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_steps: Option<usize>,
}

impl Default for PassSettings {
    fn default() -> Self {
        Self {
            controller: Controller::Ideal,
            force_setpoint: 15.0,
            spindle_speed: 6000.0 * std::f64::consts::TAU / 60.0,
            step_voxels: 0.6,
            quasi_static: true,
            write_back_voxels: 6.0,
            coating: 50e-6,
            search_reach: 20e-3,
            most_steps: None,
        }
    }
}

/// Inputs of a pass: tool, path, settings, model, and its place in the trial.
#[derive(Clone, Copy)]
pub struct Pass<'a> {
    /// The tool that presses on the part.
    pub tool: &'a Tool,
    /// Path of the tool.
    pub path: &'a Path,
    /// Controller, setpoints and numerics.
    pub settings: &'a PassSettings,
    /// Laws and effects that give pressure and removal.
    pub model: &'a CompiledModel,
    /// Number of the pass in its trial, from 1.
    pub number: usize,
    /// Row of parameters that have one value per pass, from 0.
    pub row: usize,
    /// Time since the trial's first pass began, pauses included [s].
    pub trial_time: f64,
    /// Duration of the approach [s], in which the tool keeps to its path. It ends early if the force exceeds [`TOUCH`]
    /// of the setpoint; then the controller takes over.
    pub approach: f64,
    /// Quantities measured along the pass, for formulas.
    pub measured: &'a [Measured],
    /// Setpoint that changes along the pass; otherwise that of the settings.
    pub force: Option<&'a ForceProfile>,
    /// Covariates to be accumulated for each point of the surface; `None` costs nothing.
    pub covariates: Option<&'a RefCell<Covariates>>,
    /// Timer of the phases of the work; `None` costs nothing.
    pub clock: Option<&'a Clock>,
    /// Receives the wrench at the end of each step; `None` costs nothing.
    pub gauge: Option<&'a WrenchGauge>,
}

impl<'a> Pass<'a> {
    /// Mean setpoint over an interval since the pass began [N].
    pub(crate) fn force_setpoint(&self, times: Range<f64>) -> f64 {
        self.force.map_or(self.settings.force_setpoint, |course| course.mean(times))
    }

    /// The first pass of a trial.
    pub fn first(tool: &'a Tool, path: &'a Path, settings: &'a PassSettings, model: &'a CompiledModel) -> Self {
        Self {
            tool,
            path,
            settings,
            model,
            number: 1,
            row: 0,
            trial_time: 0.0,
            approach: 0.0,
            measured: &[],
            force: None,
            covariates: None,
            clock: None,
            gauge: None,
        }
    }
}

/// Error of a pass that cannot be simulated.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum PassError {
    /// A parameter out of its range.
    #[error("{name} is {found}, it must be {accepted}")]
    BadSetting {
        /// Name of the parameter, with its unit.
        name: &'static str,
        /// Value given [SI].
        found: f64,
        /// Accepted values.
        accepted: &'static str,
    },
    /// The field's band is too thin for the surface to move.
    #[error("the field's band is {found:.2} voxels, grinding needs at least {BAND_VOXELS}: bake it wider")]
    ThinBand {
        /// Band of the field [voxels].
        found: f64,
    },
    /// Voxels too coarse for the tool.
    #[error(
        "voxels of {voxel} mm are too coarse for a tool of {size} mm: at most {} mm is accepted",
        .size / LEAST_CELLS
    )]
    CoarseField {
        /// Voxel of the field [mm].
        voxel: f64,
        /// Width of the tool [mm].
        size: f64,
    },
    /// An effect that acts through the controller's dynamics, with a controller that has none.
    #[error(
        "`{effect}` lets the controller read a past force, and an ideal controller would undo that: an admittance \
         controller, or the effect at its null value, is accepted"
    )]
    NoDynamics {
        /// Name of the effect.
        effect: String,
    },
    /// The tool touched, but reached the setpoint nowhere on its path.
    #[error(
        "the tool touches, but the force does not reach {setpoint} N within {} mm below its path: a stiffer contact, a \
         smaller force \
         or a larger search_reach is accepted", .reach * 1e3
    )]
    TooSoft {
        /// Setpoint [N].
        setpoint: f64,
        /// Distance below the path that was searched [m].
        reach: f64,
    },
    /// More steps than the settings allow.
    #[error("stopped at {time:.4} s of the pass: {most} steps are allowed")]
    TooManySteps {
        /// Time in the pass [s].
        time: f64,
        /// Steps allowed.
        most: usize,
    },
    /// A formula of the model gave no finite number.
    #[error("at {time:.4} s of the pass: {error}; the part holds the last good state")]
    Formula {
        /// Time in the pass [s].
        time: f64,
        /// The formula and the cause.
        error: RunError,
    },
}

impl PassSettings {
    /// Longest step [s] in which the controller resolves what effects do to its force reading: an admittance controller
    /// that reads a past force is stepped at its own period.
    ///
    /// # Errors
    /// [`PassError::NoDynamics`] if an ideal controller would read a past force.
    pub fn longest_step(&self, model: &CompiledModel) -> Result<f64, PassError> {
        let mut longest = LONGEST_STEADY_STEP;
        for effect in model.acting(Hook::Force) {
            match self.controller {
                Controller::Replay => {}
                Controller::Ideal if !effect.states.is_empty() => {
                    return Err(PassError::NoDynamics { effect: effect.name.clone() });
                }
                Controller::Admittance { period, .. } if !effect.states.is_empty() => longest = longest.min(period),
                _ if effect.reads(&[Variable::Time, Variable::ContactTime]) => longest = longest.min(CLOCKED_STEP),
                _ => {}
            }
        }
        Ok(longest)
    }

    /// Checks that a pass of a duration [s] can end within the allowed steps if none is longer than `longest` [s].
    ///
    /// # Errors
    /// [`PassError::TooManySteps`] at time 0.
    pub(crate) fn check_steps(&self, duration: f64, longest: f64) -> Result<(), PassError> {
        match self.most_steps.filter(|most| duration > *most as f64 * longest) {
            Some(most) => Err(PassError::TooManySteps { time: 0.0, most }),
            None => Ok(()),
        }
    }

    /// Approximate upper bound of the steps of a pass along a path on voxels of a size [m]. It follows from the steps'
    /// distance in voxels, their longest duration, and the controller's own period.
    pub fn expected_steps(&self, path: &Path, voxel: f64) -> f64 {
        let longest = match self.controller {
            Controller::Admittance { period, .. } => period.min(LONGEST_STEP),
            Controller::Ideal | Controller::Replay => LONGEST_STEP,
        };
        (path.length() / (self.step_voxels * voxel)).max(path.duration() / longest)
    }

    /// Checks all that a pass reads.
    ///
    /// # Errors
    /// The first parameter that is out of range, a band that is too thin, or voxels that are too coarse.
    pub fn check(&self, grid: &BrickGrid, tool: &Tool) -> Result<(), PassError> {
        let positive = "positive and finite";
        let bad = |name, found| Err(PassError::BadSetting { name, found, accepted: positive });
        if let Some((name, found)) = tool.bad_size() {
            return bad(name, found);
        }
        let mut settings = vec![
            ("force setpoint [N]", self.force_setpoint),
            ("step_voxels", self.step_voxels),
            ("write_back_voxels", self.write_back_voxels),
            ("coating thickness [m]", self.coating),
            ("search_reach [m]", self.search_reach),
        ];
        if let Controller::Admittance { mass, damping, period } = self.controller {
            if !(mass >= 0.0 && mass.is_finite()) {
                let (name, accepted) = ("admittance mass [kg]", "zero, or positive and finite");
                return Err(PassError::BadSetting { name, found: mass, accepted });
            }
            settings.extend([("admittance damping [N s/m]", damping), ("admittance period [s]", period)]);
        }
        for (name, found) in settings {
            if !(found > 0.0 && found.is_finite()) {
                return bad(name, found);
            }
        }
        let band = f64::from(grid.band) / grid.voxel;
        if band < BAND_VOXELS {
            return Err(PassError::ThinBand { found: band });
        }
        Self::check_voxel(grid.voxel, tool)
    }

    /// Checks that a `voxel` [m] resolves a tool.
    ///
    /// # Errors
    /// [`PassError::CoarseField`] if it does not.
    pub fn check_voxel(voxel: f64, tool: &Tool) -> Result<(), PassError> {
        let (along, across) = tool.half_footprint(f64::INFINITY);
        let (voxel, size) = (voxel * 1e3, 2e3 * along.min(across));
        if size < LEAST_CELLS * voxel { Err(PassError::CoarseField { voxel, size }) } else { Ok(()) }
    }
}
