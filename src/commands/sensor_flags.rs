//! Lens and sensor of a photograph.

use anyhow::Result;
use clap::Args;
use render::{Distortion, Sensor};

use super::flags::{SEEDS, whole, within};
use crate::wrong_use;

/// Lens and sensor; the defaults show light as it is.
#[derive(Clone, Debug, Args)]
pub(super) struct SensorFlags {
    /// Signal of linear light 1, as a part of saturation.
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, allow_negative_numbers = true)]
    exposure: f64,
    /// Standard deviation of the lens's blur [pixels].
    #[arg(long, value_name = "PIXELS", default_value_t = 0.0, allow_negative_numbers = true)]
    blur: f64,
    /// Electrons of a saturated pixel: the fewer, the more noise [default: no noise].
    #[arg(long, value_name = "ELECTRONS", allow_negative_numbers = true)]
    full_well: Option<f64>,
    /// Standard deviation of the read-out [electrons]; needs --full-well.
    #[arg(long, value_name = "ELECTRONS", default_value_t = 0.0, allow_negative_numbers = true)]
    read_noise: f64,
    /// Seed of the noise.
    #[arg(long, value_name = "SEED", default_value_t = 0, allow_negative_numbers = true, value_parser = whole::<u64>(SEEDS))]
    noise_seed: u64,
    /// Distortion of the lens, in the order of OpenCV.
    #[arg(long, value_name = "K1,K2,P1,P2,K3", allow_hyphen_values = true, value_delimiter = ',', num_args = 1)]
    distortion: Vec<f64>,
}

impl SensorFlags {
    /// Whether anything but the defaults was asked for.
    pub(super) fn is_given(&self) -> bool {
        let Self { exposure, blur, full_well, read_noise, distortion, .. } = self;
        (*exposure, *blur, *read_noise) != (1.0, 0.0, 0.0) || full_well.is_some() || !distortion.is_empty()
    }

    /// The sensor asked for.
    pub(super) fn sensor(&self) -> Result<Sensor> {
        if self.full_well.is_none() && self.read_noise != 0.0 {
            return Err(wrong_use(format!(
                "--read-noise {:?}: it needs --full-well, the electrons of a saturated pixel, 10 to 1e9",
                self.read_noise
            )));
        }
        let full_well = self.full_well.map(|electrons| within("--full-well", electrons, (10.0, 1e9))).transpose()?;
        Ok(Sensor {
            exposure: within("--exposure", self.exposure, (1e-3, 1e3))? as f32,
            blur: within("--blur", self.blur, (0.0, 50.0))? as f32,
            full_well: full_well.map_or(f32::INFINITY, |electrons| electrons as f32),
            read_noise: within("--read-noise", self.read_noise, (0.0, 1e6))? as f32,
            seed: self.noise_seed,
        })
    }

    /// The distortion asked for.
    pub(super) fn distortion(&self) -> Result<Distortion> {
        match *self.distortion.as_slice() {
            [] => Ok(Distortion::default()),
            [k1, k2, p1, p2, k3] if [k1, k2, p1, p2, k3].iter().all(|k| k.abs() <= 10.0) => {
                Ok(Distortion { radial: [k1, k2, k3], tangential: [p1, p2] })
            }
            _ => Err(wrong_use(format!(
                "--distortion {:?}: K1,K2,P1,P2,K3 within 10 is expected, for example -0.2,0.05,0.001,0,0",
                self.distortion
            ))),
        }
    }
}
