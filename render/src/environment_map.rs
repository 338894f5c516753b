//! Light of the surroundings from an equirectangular picture. On the CPU only.
//!
//! A mirror shows the picture itself, a rough surface a coarser one, a matt surface the light of the hemisphere.

use std::f32::consts::{PI, TAU};

use glam::Vec3;

/// Least number of rows; coarser levels are not made.
const LEAST_ROWS: usize = 8;
/// Greatest number of rows that are kept.
const MOST_ROWS: usize = 512;
/// Greatest number of rows over which radiance is integrated.
const SUMMED_ROWS: usize = 64;
/// Weights of red, green and blue in luminance (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);
/// Roughness from which the light of the hemisphere takes part, and at which it alone is seen.
const MATT: [f32; 2] = [0.6, 1.0];

/// A picture of the surroundings, its mean radiance over all directions scaled to luminance 1.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// The picture, each level with half the rows of the one before.
    levels: Vec<Level>,
    /// Radiance in the nine spherical harmonics up to degree 2.
    harmonics: [Vec3; 9],
}

/// A map as the surroundings of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// The map.
    pub map: &'a EnvironmentMap,
    /// Angle about the vertical by which the map is turned [rad].
    pub turn: f64,
    /// Luminance of the mean radiance over all directions.
    pub gain: f32,
}

/// Linear RGB, rows from the zenith, columns from the left; twice as many columns as rows.
#[derive(Clone, Debug, PartialEq)]
struct Level {
    rows: usize,
    pixels: Vec<Vec3>,
}

impl EnvironmentMap {
    /// Prepares a picture in linear RGB, row by row from the zenith, with twice as many columns as rows; `None` if the
    /// size differs, there are fewer than 8 rows, or the picture is black or not finite.
    pub fn new(rows: usize, pixels: Vec<Vec3>) -> Option<Self> {
        let has_size = rows >= LEAST_ROWS && pixels.len() == 2 * rows * rows;
        let is_light = |pixel: &Vec3| pixel.is_finite() && pixel.cmpge(Vec3::ZERO).all();
        if !has_size || !pixels.iter().all(is_light) {
            return None;
        }
        let mut finest = Level { rows, pixels };
        while finest.rows > MOST_ROWS {
            finest = finest.halved();
        }
        let mut levels = vec![finest];
        while let Some(level) = levels.last().filter(|level| level.rows >= 2 * LEAST_ROWS) {
            levels.push(level.halved());
        }
        let coarse = levels.iter().position(|level| level.rows <= SUMMED_ROWS)?;
        let luminance = (levels[coarse].sum(|_| 1.0) / (4.0 * PI)).dot(LUMINANCE);
        if !(luminance > 0.0 && luminance.is_finite()) {
            return None;
        }
        levels.iter_mut().flat_map(|level| &mut level.pixels).for_each(|pixel| *pixel /= luminance);
        let harmonics = std::array::from_fn(|i| levels[coarse].sum(|direction| basis(direction)[i]));
        Some(Self { levels, harmonics })
    }

    /// Mean radiance towards a surface that faces a unit direction, weighted by the cosine: the irradiance over π
    /// (Ramamoorthi & Hanrahan 2001, Eq. 8, with A₀ = π, A₁ = 2π/3, A₂ = π/4).
    fn radiosity(&self, normal: Vec3) -> Vec3 {
        let share = |i: usize| {
            if i == 0 {
                1.0
            } else if i < 4 {
                2.0 / 3.0
            } else {
                0.25
            }
        };
        let basis = basis(normal);
        (0..9).map(|i| self.harmonics[i] * (share(i) * basis[i])).sum::<Vec3>().max(Vec3::ZERO)
    }

    /// Radiance from a unit direction, blurred by the roughness of the mirror, 0 to 1. The pixel of the level spans the
    /// width of the microfacet distribution, the square of the roughness.
    fn radiance(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let matt = ((roughness - MATT[0]) / (MATT[1] - MATT[0])).clamp(0.0, 1.0);
        if matt >= 1.0 {
            return self.radiosity(direction);
        }
        let pixels = roughness * roughness * self.levels[0].rows as f32 / PI;
        let at = pixels.max(1.0).log2().min((self.levels.len() - 1) as f32);
        let low = at as usize;
        let next = (low + 1).min(self.levels.len() - 1);
        let sharp = self.levels[low].at(direction).lerp(self.levels[next].at(direction), at - low as f32);
        sharp.lerp(self.radiosity(direction), matt)
    }
}

impl Surroundings<'_> {
    /// [`EnvironmentMap::radiance`] of the turned map; `direction` is in the scene's frame.
    #[inline]
    pub(crate) fn radiance(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let (sine, cosine) = (self.turn as f32).sin_cos();
        let Vec3 { x, y, z } = direction;
        let turned = Vec3::new(x * cosine + y * sine, y * cosine - x * sine, z);
        self.map.radiance(turned, roughness) * self.gain
    }
}

impl Level {
    fn columns(&self) -> usize {
        2 * self.rows
    }

    /// Unit vector to the middle of a pixel.
    fn direction(&self, pixel: usize) -> Vec3 {
        let (row, column) = (pixel / self.columns(), pixel % self.columns());
        let polar = PI * (row as f32 + 0.5) / self.rows as f32;
        let azimuth = PI - TAU * (column as f32 + 0.5) / self.columns() as f32;
        Vec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos())
    }

    /// Solid angle of a pixel [sr].
    fn solid_angle(&self, pixel: usize) -> f32 {
        let edge = |row: usize| (PI * row as f32 / self.rows as f32).cos();
        let row = pixel / self.columns();
        (edge(row) - edge(row + 1)) * TAU / self.columns() as f32
    }

    /// Integral over all directions, with a weight.
    fn sum(&self, weight: impl Fn(Vec3) -> f32) -> Vec3 {
        let of = |(pixel, light): (usize, &Vec3)| *light * (self.solid_angle(pixel) * weight(self.direction(pixel)));
        self.pixels.iter().enumerate().map(of).sum()
    }

    /// Half the rows: means of four pixels by their solid angles.
    fn halved(&self) -> Self {
        let (rows, columns) = (self.rows / 2, self.rows);
        let mean = |pixel: usize| {
            let first = (2 * (pixel / columns)) * self.columns() + 2 * (pixel % columns);
            let four = [first, first + 1, first + self.columns(), first + self.columns() + 1];
            let weight: f32 = four.iter().map(|&of| self.solid_angle(of)).sum();
            four.iter().map(|&of| self.pixels[of] * self.solid_angle(of)).sum::<Vec3>() / weight
        };
        Self { rows, pixels: (0..2 * rows * rows).map(mean).collect() }
    }

    /// Radiance from a unit direction, bilinear between pixels.
    fn at(&self, direction: Vec3) -> Vec3 {
        let (rows, columns) = (self.rows as i32, self.columns() as i32);
        let down = direction.z.clamp(-1.0, 1.0).acos() / PI * rows as f32 - 0.5;
        let across = (PI - direction.y.atan2(direction.x)) / TAU * columns as f32 - 0.5;
        let (low, left) = (down.floor(), across.floor());
        let pixel = |row: i32, column: i32| {
            self.pixels[(row.clamp(0, rows - 1) * columns + column.rem_euclid(columns)) as usize]
        };
        let row = |row: i32| pixel(row, left as i32).lerp(pixel(row, left as i32 + 1), across - left);
        row(low as i32).lerp(row(low as i32 + 1), down - low)
    }
}

/// Real spherical harmonics up to degree 2 (Ramamoorthi & Hanrahan 2001, Eq. 3).
fn basis(Vec3 { x, y, z }: Vec3) -> [f32; 9] {
    [
        0.282_095,
        0.488_603 * y,
        0.488_603 * z,
        0.488_603 * x,
        1.092_548 * x * y,
        1.092_548 * y * z,
        0.315_392 * (3.0 * z * z - 1.0),
        1.092_548 * x * z,
        0.546_274 * (x * x - y * y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map with a radiance for each direction.
    fn map(rows: usize, radiance: impl Fn(Vec3) -> Vec3) -> EnvironmentMap {
        let frame = Level { rows, pixels: Vec::new() };
        EnvironmentMap::new(rows, (0..2 * rows * rows).map(|pixel| radiance(frame.direction(pixel))).collect()).unwrap()
    }

    #[test]
    fn a_mirror_shows_the_picture_and_a_matt_surface_the_hemisphere() {
        // Radiance 1 + z has the mean 1, and the cosine-weighted mean 1 + 2/3 z.
        let sky = map(64, |direction| Vec3::splat(1.0 + direction.z));
        for direction in [Vec3::Z, Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::new(0.6, 0.0, 0.8)] {
            assert!((sky.radiance(direction, 0.0).x - 1.0 - direction.z).abs() < 0.02, "{direction}");
            assert!((sky.radiance(direction, 1.0).x - 1.0 - 2.0 / 3.0 * direction.z).abs() < 0.01, "{direction}");
        }
    }

    #[test]
    fn a_lamp_is_where_the_turned_picture_shows_it_and_rough_metal_spreads_it() {
        let towards = Vec3::new(0.8, 0.0, 0.6);
        let lamp = map(64, |direction| Vec3::splat(if direction.dot(towards) > 0.95 { 10.0 } else { 0.1 }));
        let around = Surroundings { map: &lamp, turn: std::f64::consts::FRAC_PI_2, gain: 1.0 };
        let turned = Vec3::new(0.0, 0.8, 0.6);
        let [mirror, rough] = [0.0, 0.5].map(|roughness| around.radiance(turned, roughness).x);
        assert!(mirror > 5.0 * around.radiance(towards, 0.0).x && rough < mirror && rough > 1.0, "{mirror} {rough}");
    }

    #[test]
    fn a_picture_without_light_or_of_another_shape_is_refused() {
        assert_eq!(EnvironmentMap::new(8, vec![Vec3::ZERO; 128]), None);
        assert_eq!(EnvironmentMap::new(8, vec![Vec3::ONE; 64]), None);
        assert_eq!(EnvironmentMap::new(4, vec![Vec3::ONE; 32]), None);
        assert_eq!(EnvironmentMap::new(8, vec![Vec3::splat(f32::INFINITY); 128]), None);
    }
}
