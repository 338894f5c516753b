//! What a grinding run is told, with defaults that give a plausible weld on steel.

use sdf_bake::BrickGrid;
use sdf_bake::redistance::KEPT_VOXELS;
use serde::{Deserialize, Serialize};

use crate::path::Path;
use crate::removal::RemovalLaw;
use crate::tool::Wheel;

/// Band a field needs so that the surface can move while distances beyond it are renewed [voxels].
pub const BAND_VOXELS: f64 = KEPT_VOXELS + 1.0;

/// Process parameters of a grinding pass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GrindSettings {
    /// K [Pa/m], pressure per depth. Default 1e10: a resin-bonded wheel on steel; 15 N then press a 20 mm
    /// wide wheel of 50 mm radius 32 µm deep into a flat plate.
    pub stiffness: f64,
    /// k [m/(Pa s)]. Default 1e-9, inside 1e-10 to 1.5e-9, which an energy balance k = μ v_s / u gives for
    /// steel: friction μ 0.3 to 0.5, wheel speed v_s 20 to 60 m/s, specific energy u 20 to 60 GJ/m³.
    pub grind_rate: f64,
    /// p_c [Pa], pressure below which nothing is removed. Default 0: a sharp wheel.
    pub threshold_pressure: f64,
    /// Normal force the controller holds [N]. Default 15.
    pub force_setpoint: f64,
    /// Speed along the path [m/s], for who plans it. Default 5e-3.
    pub feed: f64,
    /// Passes over the weld. Default 2.
    pub passes: u32,
    /// Speed of the wheel [rad/s], logged. Default 628, 6000 rpm.
    pub spindle_speed: f64,
    /// Way of the wheel in one step [voxels]. Default 0.5.
    pub step_voxels: f64,
    /// Share of its depth that a point may lose in one step, at most, by `k K dt`. Default 0.5.
    pub step_removal: f64,
    /// The controller seeks the surface this far above and below the path [m]. Default 20e-3.
    pub search_reach: f64,
}

impl Default for GrindSettings {
    fn default() -> Self {
        Self {
            stiffness: 1e10,
            grind_rate: 1e-9,
            threshold_pressure: 0.0,
            force_setpoint: 15.0,
            feed: 5e-3,
            passes: 2,
            spindle_speed: 6000.0 * std::f64::consts::TAU / 60.0,
            step_voxels: 0.5,
            step_removal: 0.5,
            search_reach: 20e-3,
        }
    }
}

/// Why a pass cannot be simulated.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum GrindError {
    /// A parameter out of its range.
    #[error("{name} is {found}, it must be {accepted}")]
    BadSetting {
        /// Field of [`GrindSettings`] or [`Wheel`].
        name: &'static str,
        /// Value given [SI].
        found: f64,
        /// What would do.
        accepted: &'static str,
    },
    /// The field's band does not let the surface move.
    #[error("the field's band is {found:.2} voxels, grinding needs at least {BAND_VOXELS}: bake it wider")]
    ThinBand {
        /// Band of the field [voxels].
        found: f64,
    },
    /// The state is no longer a number.
    #[error("the force is {force} N at {time} s: the run stopped there, the part holds the last good state")]
    NotFinite {
        /// Time in the pass [s].
        time: f64,
        /// Force found [N].
        force: f64,
    },
}

impl GrindSettings {
    /// The law of removal on the contact.
    pub fn law(&self) -> RemovalLaw {
        RemovalLaw {
            stiffness: self.stiffness,
            grind_rate: self.grind_rate,
            threshold_pressure: self.threshold_pressure,
        }
    }

    /// Steps of a pass over `path` in a field of `voxel` [m]: enough for the wheel to move and for the surface to recede
    /// by no more than `step_voxels` and `step_removal` allow.
    pub fn steps(&self, path: &Path, voxel: f64) -> f64 {
        let by_way = path.length() / (self.step_voxels * voxel);
        let by_removal = path.duration() * self.grind_rate * self.stiffness / self.step_removal;
        by_way.max(by_removal).ceil()
    }

    /// Checks all that a pass reads.
    ///
    /// # Errors
    /// The first parameter that is out of range, or a band that is too thin.
    pub fn check(&self, grid: &BrickGrid, wheel: &Wheel) -> Result<(), GrindError> {
        let positive = "positive and finite";
        for (name, found) in [
            ("wheel radius [m]", wheel.radius),
            ("wheel width [m]", wheel.width),
            ("stiffness [Pa/m]", self.stiffness),
            ("force setpoint [N]", self.force_setpoint),
            ("step_voxels", self.step_voxels),
            ("step_removal", self.step_removal),
            ("search_reach [m]", self.search_reach),
        ] {
            if !(found > 0.0 && found.is_finite()) {
                return Err(GrindError::BadSetting { name, found, accepted: positive });
            }
        }
        for (name, found) in
            [("grind_rate [m/(Pa s)]", self.grind_rate), ("threshold_pressure [Pa]", self.threshold_pressure)]
        {
            if !(found >= 0.0 && found.is_finite()) {
                return Err(GrindError::BadSetting { name, found, accepted: "zero or positive, and finite" });
            }
        }
        let band = f64::from(grid.band) / grid.voxel;
        if band >= BAND_VOXELS { Ok(()) } else { Err(GrindError::ThinBand { found: band }) }
    }
}
