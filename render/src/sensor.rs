//! Model of a camera's sensor: blur, exposure, noise and saturation.

use glam::Vec3;
use rayon::prelude::*;

use super::frame::Frame;

/// A sensor behind a lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensor {
    /// Signal for linear light 1, as a share of saturation.
    pub exposure: f32,
    /// Standard deviation of the lens blur [pixels].
    pub blur: f32,
    /// Full-well capacity: electrons of a saturated pixel. Shot noise decreases with it; infinite for none.
    pub full_well: f32,
    /// Standard deviation of the read noise [electrons].
    pub read_noise: f32,
    /// Seed of the noise: the same seed gives the same picture.
    pub seed: u64,
}

impl Default for Sensor {
    /// An ideal sensor: linear light is unchanged.
    fn default() -> Self {
        Self { exposure: 1.0, blur: 0.0, full_well: f32::INFINITY, read_noise: 0.0, seed: 0 }
    }
}

impl Sensor {
    /// Converts the colour of a frame to the sensor's signal, 0 to 1; the other buffers stay exact.
    pub fn expose(&self, frame: &mut Frame) {
        if self.blur > 0.0 {
            blur(frame, self.blur);
        }
        let noisy = self.full_well.is_finite();
        frame.colour.par_iter_mut().enumerate().for_each(|(pixel, colour)| {
            *colour *= self.exposure;
            if noisy {
                *colour = Vec3::from_array(std::array::from_fn(|channel| {
                    self.read_out(colour[channel].clamp(0.0, 1.0), (3 * pixel + channel) as u64)
                }));
            }
            *colour = colour.clamp(Vec3::ZERO, Vec3::ONE);
        });
    }

    /// Adds shot noise, whose variance is the number of electrons, and read noise to a signal.
    fn read_out(&self, signal: f32, sample: u64) -> f32 {
        let electrons = signal * self.full_well;
        let deviation = (electrons + self.read_noise * self.read_noise).sqrt();
        (electrons + deviation * standard_normal(self.seed, sample)) / self.full_well
    }
}

/// Random number of mean 0 and variance 1 for every sample: the sum of eight uniform bytes (Irwin 1927, Hall 1927) from
/// SplitMix64 (Steele, Lea & Flood 2014).
fn standard_normal(seed: u64, sample: u64) -> f32 {
    let mut z = seed.wrapping_add(sample.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    let sum: u32 = z.to_le_bytes().iter().map(|&byte| u32::from(byte)).sum();
    // A uniform byte has mean 127.5 and variance (256² − 1) / 12.
    (sum as f32 - 1020.0) / (8f32 * 65_535.0 / 12.0).sqrt()
}

/// Gaussian blur of the colour, rows and then columns; border pixels are repeated beyond the border.
fn blur(frame: &mut Frame, deviation: f32) {
    let reach = (3.0 * deviation).ceil() as isize;
    let weight = |i: isize| (-0.5 * (i as f32 / deviation).powi(2)).exp();
    let total: f32 = (-reach..=reach).map(weight).sum();
    let weights: Vec<f32> = (-reach..=reach).map(|i| weight(i) / total).collect();
    let (width, height) = (frame.width, frame.height);
    let along = |from: &[Vec3], across: bool| -> Vec<Vec3> {
        let place = |pixel: usize, step: isize| {
            let (x, y) = (pixel % width, pixel / width);
            if across {
                y * width + x.saturating_add_signed(step).min(width - 1)
            } else {
                y.saturating_add_signed(step).min(height - 1) * width + x
            }
        };
        let mean = |pixel: usize| {
            weights.iter().zip(-reach..=reach).map(|(&weight, step)| from[place(pixel, step)] * weight).sum()
        };
        (0..width * height).into_par_iter().map(mean).collect()
    };
    frame.colour = along(&along(&frame.colour, true), false);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: usize, height: usize, colour: impl Fn(usize) -> f32) -> Frame {
        let mut frame = Frame::empty(width, height);
        frame.colour = (0..width * height).map(|i| Vec3::splat(colour(i))).collect();
        frame
    }

    #[test]
    fn noise_has_the_deviation_of_electrons_and_the_seed_s_bytes() {
        let sensor = Sensor { full_well: 10_000.0, read_noise: 20.0, seed: 7, ..Sensor::default() };
        for signal in [0.04f32, 0.5] {
            let mut noisy = frame(300, 200, |_| signal);
            sensor.expose(&mut noisy);
            let values: Vec<f32> = noisy.colour.iter().flat_map(|c| c.to_array()).collect();
            let mean = values.iter().sum::<f32>() / values.len() as f32;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32;
            let expected = (signal * 1e4 + 400.0) / 1e8;
            assert!((mean - signal).abs() < 1e-4, "{mean}");
            assert!((variance / expected - 1.0).abs() < 0.02, "{variance} for {expected}");
            let mut again = frame(300, 200, |_| signal);
            sensor.expose(&mut again);
            assert_eq!(noisy.colour, again.colour);
            Sensor { seed: 8, ..sensor }.expose(&mut again);
            assert_ne!(noisy.colour, again.colour);
        }
    }

    #[test]
    fn a_blurred_point_keeps_its_light_and_gets_its_width() {
        let mut point = frame(41, 31, |i| if i == 15 * 41 + 20 { 1.0 } else { 0.0 });
        Sensor { blur: 2.0, ..Sensor::default() }.expose(&mut point);
        let light = |i: usize| point.colour[i].x;
        let sum: f32 = (0..41 * 31).map(light).sum();
        let second: f32 = (0..41 * 31).map(|i| light(i) * ((i % 41) as f32 - 20.0).powi(2)).sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        assert!((second / sum - 4.0).abs() < 0.15, "{second}");
    }

    #[test]
    fn exposure_scales_and_saturates() {
        let mut pixels = frame(3, 1, |i| [0.1, 0.4, 0.9][i]);
        Sensor { exposure: 2.0, ..Sensor::default() }.expose(&mut pixels);
        let seen: Vec<f32> = pixels.colour.iter().map(|c| c.x).collect();
        assert_eq!(seen, [0.2, 0.8, 1.0]);
    }
}
