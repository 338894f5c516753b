//! Lens and sensor of a photograph.

use clap::Args;
use render::{Distortion, Sensor};

use super::flags::SEEDS;
use super::values::{number, whole};

/// Lens and sensor; the defaults show light as it is.
#[derive(Clone, Debug, Args)]
pub(super) struct SensorFlags {
    /// Signal of linear light 1, as a part of saturation.
    #[arg(
        long,
        value_name = "FACTOR",
        default_value_t = 1.0,
        allow_negative_numbers = true,
        value_parser = number([1e-3, 1e3])
    )]
    exposure: f64,
    /// Standard deviation of the lens's blur [pixels].
    #[arg(
        long,
        value_name = "PIXELS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number([0.0, 50.0])
    )]
    blur: f64,
    /// Electrons of a saturated pixel: the fewer, the more noise [default: no noise].
    #[arg(long, value_name = "ELECTRONS", allow_negative_numbers = true, value_parser = number([10.0, 1e9]))]
    full_well: Option<f64>,
    /// Standard deviation of the read-out [electrons]; needs --full-well.
    #[arg(
        long,
        value_name = "ELECTRONS",
        default_value_t = 0.0,
        allow_negative_numbers = true,
        value_parser = number([0.0, 1e6])
    )]
    read_noise: f64,
    /// Seed of the noise.
    #[arg(
        long,
        value_name = "SEED",
        default_value_t = 0,
        allow_negative_numbers = true,
        value_parser = whole::<u64>(SEEDS)
    )]
    noise_seed: u64,
    /// Distortion of the lens, in the order of OpenCV.
    #[arg(long, value_name = "K1,K2,P1,P2,K3", allow_hyphen_values = true, value_parser = parse_distortion)]
    pub(super) distortion: Option<Distortion>,
}

impl SensorFlags {
    /// Returns true if a flag differs from its default.
    pub(super) fn is_given(&self) -> bool {
        let Self { exposure, blur, full_well, read_noise, distortion, .. } = self;
        (*exposure, *blur, *read_noise) != (1.0, 0.0, 0.0) || full_well.is_some() || distortion.is_some()
    }

    /// Returns the contradiction between flags as a sentence; `None` without one.
    pub(super) fn fault(&self) -> Option<String> {
        let noise = self.read_noise;
        (self.full_well.is_none() && noise != 0.0).then(|| {
            format!("--read-noise {noise:?}: it needs --full-well, the electrons of a saturated pixel, 10 to 1e9")
        })
    }

    /// Returns the requested sensor.
    pub(super) fn sensor(&self) -> Sensor {
        Sensor {
            exposure: self.exposure as f32,
            blur: self.blur as f32,
            full_well: self.full_well.map_or(f32::INFINITY, |electrons| electrons as f32),
            read_noise: self.read_noise as f32,
            seed: self.noise_seed,
        }
    }
}

fn parse_distortion(text: &str) -> Result<Distortion, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[k1, k2, p1, p2, k3]) if [k1, k2, p1, p2, k3].iter().all(|k| k.abs() <= 10.0) => {
            Ok(Distortion { radial: [k1, k2, k3], tangential: [p1, p2] })
        }
        _ => Err("K1,K2,P1,P2,K3 within 10 is expected, for example -0.2,0.05,0.001,0,0".to_owned()),
    }
}
