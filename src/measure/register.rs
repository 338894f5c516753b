//! Offset and tilt between two maps of one surface, by iteratively reweighted least squares.

use glam::{DMat3, DVec2, DVec3};
use sdf_bake::HeightMap;
use thiserror::Error;

use super::robust::centre_and_sigma;

/// Fewest pixels that fix a plane.
const LEAST_PIXELS: usize = 16;
/// Rounds of reweighting with Huber's weights, then with Tukey's, which forget outliers altogether.
const ROUNDS: (usize, usize) = (10, 20);
/// Huber's and Tukey's constants for 95 % efficiency under a normal law [standard deviations].
const TUNING: (f64, f64) = (1.345, 4.685);
/// Spread below which the fit is exact [m].
const EXACT: f64 = 1e-12;

/// How one map lies over another: `measured - reference = offset + tilt · (place - centre)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration {
    /// Height difference at `centre` [m].
    pub offset: f64,
    /// Slope of the difference along x and y [1].
    pub tilt: DVec2,
    /// Mean place of the pixels used [m].
    pub centre: DVec2,
    /// Robust standard deviation of what is left on the pixels used [m].
    pub sigma: f64,
    /// Pixels used.
    pub pixels: usize,
}

/// Why two maps cannot be laid on each other.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum RegistrationError {
    /// The maps have other pixels.
    #[error("{found:?} pixels on one map and {reference:?} on the other: the same are expected")]
    DifferentPixels {
        /// Pixels of the measured map.
        found: (usize, usize),
        /// Pixels of the reference.
        reference: (usize, usize),
    },
    /// Not enough to lay one map on the other.
    #[error("{found} pixels may be used, at least {LEAST_PIXELS} that do not lie on one line are needed")]
    TooFewPixels {
        /// Pixels that both maps have and the mask takes.
        found: usize,
    },
}

/// Lays `measured` on `reference` over the pixels that `takes` says; outliers among them count little or nothing.
///
/// # Errors
/// [`RegistrationError`] when the maps differ in shape, or too few pixels are left.
pub fn register(
    measured: &HeightMap,
    reference: &HeightMap,
    takes: impl Fn(usize) -> bool,
) -> Result<Registration, RegistrationError> {
    let (found, expected) = (measured.pixels, reference.pixels);
    if (found.nx, found.ny) != (expected.nx, expected.ny) {
        let (found, reference) = ((found.nx, found.ny), (expected.nx, expected.ny));
        return Err(RegistrationError::DifferentPixels { found, reference });
    }
    let place = |at: usize| found.position(at % found.nx, at / found.nx);
    let difference = |at: usize| measured.heights[at] - reference.heights[at];
    let samples: Vec<(DVec2, f64)> = (0..found.len())
        .filter(|&at| takes(at) && difference(at).is_finite())
        .map(|at| (place(at), difference(at)))
        .collect();
    let too_few = RegistrationError::TooFewPixels { found: samples.len() };
    if samples.len() < LEAST_PIXELS {
        return Err(too_few);
    }
    let centre = samples.iter().map(|(place, _)| *place).sum::<DVec2>() / samples.len() as f64;
    let scale = found.pitch * found.nx.max(found.ny) as f64;
    let rows: Vec<(DVec3, f64)> =
        samples.iter().map(|&(place, d)| (((place - centre) / scale).extend(1.0), d)).collect();
    let (plane, sigma) = fit(&rows).ok_or(too_few)?;
    Ok(Registration { offset: plane.z, tilt: plane.truncate() / scale, centre, sigma, pixels: rows.len() })
}

/// The robust plane through rows of (basis, value), and the spread around it.
fn fit(rows: &[(DVec3, f64)]) -> Option<(DVec3, f64)> {
    let mut plane = weighted(rows, |_| 1.0)?;
    let mut sigma = spread(rows, plane)?;
    for round in 0..ROUNDS.0 + ROUNDS.1 {
        if sigma < EXACT {
            break;
        }
        let huber = |r: f64| (TUNING.0 * sigma / r.abs()).min(1.0);
        let tukey = |r: f64| (1.0 - (r / (TUNING.1 * sigma)).powi(2)).max(0.0).powi(2);
        plane = if round < ROUNDS.0 {
            weighted(rows, |(basis, d)| huber(d - plane.dot(*basis)))?
        } else {
            weighted(rows, |(basis, d)| tukey(d - plane.dot(*basis)))?
        };
        sigma = spread(rows, plane)?;
    }
    Some((plane, sigma))
}

/// Weighted least squares; `None` where the rows do not fix a plane.
fn weighted(rows: &[(DVec3, f64)], weight: impl Fn(&(DVec3, f64)) -> f64) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for row in rows {
        let (basis, w) = (row.0, weight(row));
        matrix += DMat3::from_cols(basis * basis.x, basis * basis.y, basis * basis.z) * w;
        right += basis * (row.1 * w);
    }
    let plane = matrix.inverse() * right;
    // Lengths are of order one, so that a determinant this small is a line.
    (matrix.determinant() > 1e-12 * matrix.z_axis.z.powi(3) && plane.is_finite()).then_some(plane)
}

fn spread(rows: &[(DVec3, f64)], plane: DVec3) -> Option<f64> {
    let residuals: Vec<f64> = rows.iter().map(|(basis, d)| d - plane.dot(*basis)).collect();
    centre_and_sigma(&residuals).map(|(_, sigma)| sigma)
}

impl Registration {
    /// What the registration says at a place [m].
    pub fn at(&self, place: DVec2) -> f64 {
        self.offset + self.tilt.dot(place - self.centre)
    }

    /// The measured map, laid on the reference.
    pub fn applied_to(&self, measured: &HeightMap) -> HeightMap {
        let mut map = measured.clone();
        let pixels = map.pixels;
        for (at, height) in map.heights.iter_mut().enumerate() {
            *height -= self.at(pixels.position(at % pixels.nx, at / pixels.nx));
        }
        map
    }
}

#[cfg(test)]
mod tests {
    use sdf_bake::PixelGrid;

    use super::*;

    fn maps() -> (HeightMap, HeightMap) {
        let pixels = PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: 0.5e-3, nx: 140, ny: 40 };
        let surface = |p: DVec2| (2e-3 * (1.0 - (p.y / 5e-3).powi(2))).max(0.0);
        let reference = HeightMap::from_function(pixels, surface);
        let measured = HeightMap::from_function(pixels, |p| surface(p) + 12e-6 + 0.4e-3 * p.x - 0.7e-3 * p.y);
        (measured, reference)
    }

    #[test]
    fn offset_and_tilt_are_found_below_a_third_of_outliers() {
        let (mut measured, reference) = maps();
        for (at, height) in measured.heights.iter_mut().enumerate() {
            *height += 2e-6 * (((at * 7919) % 1000) as f64 / 500.0 - 1.0);
            if at % 3 == 0 {
                *height -= 80e-6;
            }
            if at % 50 == 0 {
                *height = f64::NAN;
            }
        }
        let found = register(&measured, &reference, |_| true).unwrap();
        let error = (0..4)
            .map(|k| DVec2::new(0.07 * f64::from(k % 2), 0.02 * f64::from(k / 2) - 0.01))
            .map(|p| (found.at(p) - (12e-6 + 0.4e-3 * p.x - 0.7e-3 * p.y)).abs());
        let worst = error.fold(0.0, f64::max);
        println!("registration is off by {worst:.1e} m at the map's corners");
        assert!(worst < 0.2e-6, "{worst}: {found:?}");
        let laid = found.applied_to(&measured);
        assert!(super::super::residual(&laid, &reference, |at| at % 3 != 0).rms < 2e-6);
    }

    #[test]
    fn maps_that_cannot_be_laid_on_each_other_say_why() {
        let (measured, reference) = maps();
        assert!(matches!(
            register(&measured, &reference, |at| at < 9),
            Err(RegistrationError::TooFewPixels { found: 9 })
        ));
        assert!(register(&measured, &reference, |at| at < 140).is_err(), "one row fixes no tilt across it");
        let mut short = reference.clone();
        short.pixels.nx = 139;
        assert!(matches!(register(&measured, &short, |_| true), Err(RegistrationError::DifferentPixels { .. })));
    }
}
