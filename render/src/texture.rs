//! Variation of a material over a surface by noise: grain of wood, stains, orange peel. On the CPU only.

use glam::Vec3;

use super::lanes::integer;
use super::material::Material;

/// Amplitude of the finer of the two octaves, relative to the coarser one.
const FINER: f32 = 0.5;
/// Least roughness of a textured material.
const LEAST_ROUGHNESS: f32 = 0.04;

/// Variation of colour and roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// Period along each axis of the part's frame [m]; unequal periods give a grain.
    pub period: Vec3,
    /// Position of the pattern [periods].
    pub offset: Vec3,
    /// Greatest relative change of the colour, 0 to 1.
    pub contrast: f32,
    /// Greatest change of the roughness.
    pub roughness: f32,
}

impl Texture {
    /// Noise at a point [m], −1 to 1.
    #[inline(always)]
    pub(crate) fn value(&self, point: Vec3) -> f32 {
        noise_at(point / self.period + self.offset)
    }

    /// Varies a material by a value of the noise.
    #[inline(always)]
    pub(crate) fn applied(&self, material: Material, value: f32) -> Material {
        Material {
            colour: material.colour * (1.0 + self.contrast * value),
            roughness: (material.roughness + self.roughness * value).clamp(LEAST_ROUGHNESS, 1.0),
            ..material
        }
    }
}

/// Noise of two octaves, −1 to 1.
#[inline(always)]
pub(crate) fn noise_at(at: Vec3) -> f32 {
    (noise(at) + FINER * noise(2.03 * at + Vec3::splat(17.7))) / (1.0 + FINER)
}

/// Value noise of three dimensions, −1 to 1, with period 1 (Perlin 1985).
#[inline(always)]
fn noise(at: Vec3) -> f32 {
    let low = at.floor();
    let within = at - low;
    let share = within * within * (Vec3::splat(3.0) - 2.0 * within);
    // Written out, so that a loop over samples runs in lanes.
    let faces = [face(low, share), face(low + Vec3::Z, share)];
    2.0 * mix(faces[0], faces[1], share.z) - 1.0
}

/// Value between the four corners of a lattice cell with the z of `low`.
#[inline(always)]
fn face(low: Vec3, share: Vec3) -> f32 {
    let edges = [edge(low, share), edge(low + Vec3::Y, share)];
    mix(edges[0], edges[1], share.y)
}

#[inline(always)]
fn edge(low: Vec3, share: Vec3) -> f32 {
    mix(corner(low), corner(low + Vec3::X), share.x)
}

#[inline(always)]
fn corner(at: Vec3) -> f32 {
    let [x, y, z] = cell(at);
    unit(x ^ y.rotate_left(11) ^ z.rotate_left(22))
}

#[inline(always)]
fn mix(a: f32, b: f32, share: f32) -> f32 {
    a + (b - a) * share
}

/// Pseudorandom numbers of a lattice point: PCG3D (Jarzynski & Olano 2020).
#[inline(always)]
pub(crate) fn cell(at: Vec3) -> [u32; 3] {
    let of = |x: f32| (integer(x) as u32).wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let [mut x, mut y, mut z] = [of(at.x), of(at.y), of(at.z)];
    for _ in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        (x, y, z) = (x ^ x >> 16, y ^ y >> 16, z ^ z >> 16);
    }
    [x, y, z]
}

/// Number from 0 to 1 of pseudorandom bits.
#[inline(always)]
pub(crate) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / 16_777_216.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::PRIMER;

    #[test]
    fn noise_is_continuous_and_fills_its_range() {
        let values: Vec<f32> = (0..20_000).map(|i| noise(Vec3::new(0.013, 0.007, 0.003) * i as f32)).collect();
        assert!(values.iter().all(|value| value.abs() <= 1.0));
        assert!(values.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.1));
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f32>() / values.len() as f32;
        assert!(mean.abs() < 0.1 && variance > 0.03, "{mean}, {variance}");
    }

    #[test]
    fn a_long_period_gives_a_grain_and_contrast_bounds_the_colour() {
        let period = Vec3::new(0.2, 0.002, 0.2);
        let wood = Texture { period, offset: Vec3::splat(3.3), contrast: 0.4, roughness: 0.2 };
        let colour = |point: Vec3| wood.applied(PRIMER, wood.value(point)).colour.y / PRIMER.colour.y;
        let change =
            |step: Vec3| (0..500).map(move |i| (colour(step * (i + 1) as f32) - colour(step * i as f32)).abs());
        let (along, across) = (change(Vec3::X * 2e-4).sum::<f32>(), change(Vec3::Y * 2e-4).sum::<f32>());
        assert!(across > 20.0 * along, "{across} across, {along} along");
        assert!((0..500).all(|i| (colour(Vec3::splat(7e-4) * i as f32) - 1.0).abs() <= 0.4));
    }
}
