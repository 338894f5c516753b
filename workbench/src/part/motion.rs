//! Way of the tool in a pass, from its log: places, forces, and the pixels where a picture shows them.

use glam::DVec3;
use serde_json::{Value, json};
use trials::trial::{Pass, Trial};

use super::picture::{PictureData, PictureRequest};
use crate::error::Refusal;

/// Greatest number of moments of a pass; longer logs are thinned.
const MOST_MOMENTS: usize = 400;

/// Moments of a pass, from its log.
pub(super) struct Motion {
    /// Time since the first row [s].
    seconds: Vec<f64>,
    /// Lowest point of the tool [m].
    places: Vec<DVec3>,
    /// Normal force [N].
    forces: Vec<f64>,
    /// Setpoint of the force [N].
    setpoint: f64,
}

impl Motion {
    /// Takes the log of a pass.
    pub(super) fn of(trial: &Trial, pass: &Pass) -> Self {
        let rows = &pass.log.rows;
        let step = rows.len().div_ceil(MOST_MOMENTS).max(1);
        let begin = rows.first().map_or(0.0, |row| row.time);
        let drop = trial.tool.shape.drop();
        let kept = || rows.iter().step_by(step);
        Self {
            seconds: kept().map(|row| row.time - begin).collect(),
            places: kept().map(|row| row.position - drop * row.approach).collect(),
            forces: kept().map(|row| row.force).collect(),
            setpoint: pass.force_setpoint,
        }
    }
}

/// Returns the moments of the drawn pass: seconds, forces [N], places [mm], and pixels of the picture, `null` behind the
/// camera.
///
/// # Errors
/// If there is no such pass.
pub(crate) fn motion(looked: &PictureData, asked: &PictureRequest) -> Result<Value, Refusal> {
    let trial = looked.trial(asked)?;
    let motion = asked.pass.checked_sub(1).and_then(|pass| trial.motions.get(pass));
    let motion = motion.ok_or_else(|| Refusal::missing("before the first pass no tool moves"))?;
    let size = glam::DVec2::new(asked.width as f64, asked.height as f64);
    let camera = asked.turn().camera(&trial.before, (asked.width, asked.height));
    let pixel = |place: &DVec3| camera.project(*place, size.x / size.y).map(|at| (at * size).to_array());
    Ok(json!({
        "seconds": motion.seconds,
        "forces": motion.forces,
        "setpoint": motion.setpoint,
        "placesMm": motion.places.iter().map(|place| (1e3 * *place).to_array()).collect::<Vec<_>>(),
        "pixels": motion.places.iter().map(pixel).collect::<Vec<_>>(),
    }))
}
