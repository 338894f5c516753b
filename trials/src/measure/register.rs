//! Registration of two maps of one surface: offset, tilt and, on request, a lateral shift and turn, by iteratively
//! reweighted least squares.

use glam::DVec2;
use rayon::prelude::*;
use sdf_bake::HeightMap;
use thiserror::Error;

use super::robust::centre_and_sigma;

/// Minimum number of pixels that determine a plane.
const LEAST_PIXELS: usize = 16;
/// Maximum number of pixels that are used; of more, every second, third and so on.
const MOST_USED: usize = 250_000;
/// Numbers of reweighting rounds with Huber's weights, then with Tukey's, which ignore outliers entirely.
const ROUNDS: (usize, usize) = (10, 20);
/// Tuning constants of Huber's and Tukey's weights for 95 % efficiency under a normal distribution [standard
/// deviations].
const TUNING: (f64, f64) = (1.345, 4.685);
/// Spread below which the fit is exact [m].
const EXACT: f64 = 1e-12;
/// Minimum spread of heights for the weight of the prior on shifts and turn [m]: far above the rounding of heights in a
/// file, 1 nm.
const FINEST: f64 = 1e-7;
/// Unknowns: offset, tilt along x and y, shift along x and y, turn.
const UNKNOWNS: usize = 6;
/// Share of a column's norm that must remain after projection on the others; less counts as dependent.
const INDEPENDENT: f64 = 1e-6;

/// Degrees of freedom of a registration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DegreesOfFreedom {
    /// Offset and tilt.
    Plane,
    /// Offset, tilt, and a lateral shift and turn about z; these need a surface with slopes along x and y.
    All,
}

/// Position of one map relative to another: `measured(p) = reference(p - shift - turn z × (p - centre)) + offset +
/// tilt · (p - centre)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Registration {
    /// Height difference at `centre` [m].
    pub offset: f64,
    /// Slope of the difference along x and y [1].
    pub tilt: DVec2,
    /// Lateral shift [m]; zero unless requested.
    pub shift: DVec2,
    /// Turn about z [rad], positive from x to y; zero unless requested.
    pub turn: f64,
    /// Mean position of the pixels used [m].
    pub centre: DVec2,
    /// Robust standard deviation of the residuals on the pixels used [m].
    pub sigma: f64,
    /// Pixels used.
    pub pixels: usize,
}

/// Error of two maps that cannot be registered.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum RegistrationError {
    /// The maps have different pixels.
    #[error("{found:?} pixels on one map and {reference:?} on the other: the same are expected")]
    DifferentPixels {
        /// Pixels of the measured map.
        found: (usize, usize),
        /// Pixels of the reference.
        reference: (usize, usize),
    },
    /// Too few pixels for a registration.
    #[error("{found} pixels may be used, at least {LEAST_PIXELS} that do not lie on one line are needed")]
    TooFewPixels {
        /// Number of pixels that both maps have and the mask selects.
        found: usize,
    },
}

/// Equation of one pixel: the coefficient of each unknown, and the difference of the maps [m].
struct Equation {
    basis: [f64; UNKNOWNS],
    difference: f64,
}

/// Registers `measured` with `reference` over the pixels that `takes` selects; outliers get little or no weight.
///
/// Shift and turn are one Gauss-Newton step with the reference's central differences, accurate while they move pixels by
/// a small part of the pitch; a simulated reference can be observed again at the moved pixels. Priors draw both to zero,
/// so that the rounding of a plane surface, which looks like slopes, moves nothing: standard deviations of one pitch,
/// for the turn at a distance of the map's length.
///
/// # Errors
/// [`RegistrationError`] if the maps differ in shape, or too few pixels are left.
pub fn register(
    measured: &HeightMap,
    reference: &HeightMap,
    freedom: DegreesOfFreedom,
    takes: impl Fn(usize) -> bool,
) -> Result<Registration, RegistrationError> {
    let (pixels, other) = (measured.pixels, reference.pixels);
    if (pixels.nx, pixels.ny) != (other.nx, other.ny) {
        let (found, reference) = ((pixels.nx, pixels.ny), (other.nx, other.ny));
        return Err(RegistrationError::DifferentPixels { found, reference });
    }
    let known = |at: usize| (measured.heights[at] - reference.heights[at]).is_finite();
    let used: Vec<usize> = (0..pixels.len()).filter(|&at| takes(at) && known(at)).collect();
    let place = |at: usize| pixels.position(at % pixels.nx, at / pixels.nx);
    // A plane and a shift need no more: their errors are those of a pixel over the root of the count.
    let used: Vec<usize> = used.iter().copied().step_by(used.len().div_ceil(MOST_USED).max(1)).collect();
    let centre = used.iter().map(|&at| place(at)).sum::<DVec2>() / used.len().max(1) as f64;
    let scale = pixels.pitch * pixels.nx.max(pixels.ny) as f64;
    let equation = |at: usize| {
        let (x, slope) = ((place(at) - centre) / scale, slope(reference, at, freedom));
        let basis = [1.0, x.x, x.y, -slope.x, -slope.y, -slope.dot(x.perp())];
        let difference = measured.heights[at] - reference.heights[at];
        (!slope.is_nan()).then_some(Equation { basis, difference })
    };
    let equations: Vec<Equation> = used.iter().filter_map(|&at| equation(at)).collect();
    let too_few = RegistrationError::TooFewPixels { found: equations.len() };
    if equations.len() < LEAST_PIXELS {
        return Err(too_few);
    }
    let ([offset, tilt_x, tilt_y, shift_x, shift_y, turn], sigma) = fit(&equations, pixels.pitch).ok_or(too_few)?;
    let (tilt, shift) = (DVec2::new(tilt_x, tilt_y) / scale, DVec2::new(shift_x, shift_y));
    Ok(Registration { offset, tilt, shift, turn: turn / scale, centre, sigma, pixels: equations.len() })
}

/// Slope of a map at a pixel by central differences, NaN at the border and beside missing pixels; zero if neither
/// shift nor turn is requested.
fn slope(map: &HeightMap, at: usize, freedom: DegreesOfFreedom) -> DVec2 {
    let (nx, ny) = (map.pixels.nx, map.pixels.ny);
    let (i, j) = (at % nx, at / nx);
    if freedom == DegreesOfFreedom::Plane {
        return DVec2::ZERO;
    }
    if i == 0 || j == 0 || i + 1 == nx || j + 1 == ny {
        return DVec2::NAN;
    }
    let h = &map.heights;
    DVec2::new(h[at + 1] - h[at - 1], h[at + nx] - h[at - nx]) / (2.0 * map.pixels.pitch)
}

/// Returns true if all four neighbours of a pixel are known.
pub(crate) fn has_slope(map: &HeightMap, at: usize) -> bool {
    slope(map, at, DegreesOfFreedom::All).is_finite()
}

/// Slope of a map at a pixel from the known neighbours, zero along an axis without any.
fn one_sided_slope(map: &HeightMap, at: usize) -> DVec2 {
    let (nx, here) = (map.pixels.nx, map.heights[at]);
    let rise = |next: Option<usize>| next.map(|next| map.heights[next] - here).filter(|rise| rise.is_finite());
    let along = |before: Option<usize>, after: Option<usize>| {
        let known: Vec<f64> = rise(after).into_iter().chain(rise(before).map(|rise| -rise)).collect();
        known.iter().sum::<f64>() / known.len().max(1) as f64
    };
    let within = |next: usize| (next < map.heights.len()).then_some(next);
    let (west, east) = ((!at.is_multiple_of(nx)).then(|| at - 1), (at % nx + 1 < nx).then_some(at + 1));
    DVec2::new(along(west, east), along(at.checked_sub(nx), within(at + nx))) / map.pixels.pitch
}

/// The robust solution, and the spread around it; `reach` [m] is the scale of the expected shifts.
fn fit(equations: &[Equation], reach: f64) -> Option<([f64; UNKNOWNS], f64)> {
    let prior = |sigma: f64| (sigma.max(FINEST) / reach).powi(2);
    let mut solution = weighted(equations, prior(0.0), |_| 1.0)?;
    let mut left = all_left(equations, &solution);
    let (_, mut sigma) = centre_and_sigma(&left)?;
    for round in 0..ROUNDS.0 + ROUNDS.1 {
        if sigma < EXACT {
            break;
        }
        let huber = |r: f64| (TUNING.0 * sigma / r.abs()).min(1.0);
        let tukey = |r: f64| (1.0 - (r / (TUNING.1 * sigma)).powi(2)).max(0.0).powi(2);
        let weight = |at: usize| if round < ROUNDS.0 { huber(left[at]) } else { tukey(left[at]) };
        solution = weighted(equations, prior(sigma), weight)?;
        left = all_left(equations, &solution);
        sigma = centre_and_sigma(&left)?.1;
    }
    Some((solution, sigma))
}

impl Equation {
    fn left(&self, solution: &[f64; UNKNOWNS]) -> f64 {
        self.difference - self.basis.iter().zip(solution).map(|(a, b)| a * b).sum::<f64>()
    }
}

/// Residual of each equation under a solution [m].
fn all_left(equations: &[Equation], solution: &[f64; UNKNOWNS]) -> Vec<f64> {
    equations.par_iter().map(|equation| equation.left(solution)).collect()
}

/// Least squares with a weight for each equation, by its index, and a prior on shifts and turn; `None` if not even the
/// plane is determined.
fn weighted(equations: &[Equation], prior: f64, weight: impl Fn(usize) -> f64) -> Option<[f64; UNKNOWNS]> {
    // Only the diagonal of the symmetric matrix and the entries to its left are summed.
    let mut matrix = [[0.0; UNKNOWNS]; UNKNOWNS];
    let mut right = [0.0; UNKNOWNS];
    for (at, Equation { basis, difference }) in equations.iter().enumerate() {
        let w = weight(at);
        for i in 0..UNKNOWNS {
            let weighted = w * basis[i];
            right[i] += weighted * difference;
            for j in 0..=i {
                matrix[i][j] += weighted * basis[j];
            }
        }
    }
    (3..UNKNOWNS).for_each(|shift| matrix[shift][shift] += prior);
    solved(&matrix, &right)
}

/// Solves the normal equations, of which only the lower triangle is read, by Cholesky factorisation. Shifts and
/// a turn that the surface does not determine stay zero; `None` if the plane is not determined.
fn solved(matrix: &[[f64; UNKNOWNS]; UNKNOWNS], right: &[f64; UNKNOWNS]) -> Option<[f64; UNKNOWNS]> {
    let mut factor = [[0.0; UNKNOWNS]; UNKNOWNS];
    let mut solution = [0.0; UNKNOWNS];
    for i in 0..UNKNOWNS {
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            factor[i][j] = if factor[j][j] > 0.0 { (matrix[i][j] - sum) / factor[j][j] } else { 0.0 };
        }
        let pivot = matrix[i][i] - (0..i).map(|k| factor[i][k] * factor[i][k]).sum::<f64>();
        if pivot > INDEPENDENT * matrix[i][i] {
            factor[i][i] = pivot.sqrt();
            solution[i] = (right[i] - (0..i).map(|k| factor[i][k] * solution[k]).sum::<f64>()) / factor[i][i];
        } else if i < 3 {
            return None;
        }
    }
    for i in (0..UNKNOWNS).rev() {
        let known: f64 = (i + 1..UNKNOWNS).map(|k| factor[k][i] * solution[k]).sum();
        solution[i] = if factor[i][i] > 0.0 { (solution[i] - known) / factor[i][i] } else { 0.0 };
    }
    solution.iter().all(|value| value.is_finite()).then_some(solution)
}

impl Registration {
    /// Height of the plane at a point [m].
    pub fn plane(&self, place: DVec2) -> f64 {
        self.offset + self.tilt.dot(place - self.centre)
    }

    /// The measured map without the plane; shift and turn are not applied.
    pub fn levelled(&self, measured: &HeightMap) -> HeightMap {
        let mut map = measured.clone();
        let pixels = map.pixels;
        for (at, height) in map.heights.iter_mut().enumerate() {
            *height -= self.plane(pixels.position(at % pixels.nx, at / pixels.nx));
        }
        map
    }

    /// Residual of `measured - reference` at each pixel [m], NaN where it is unknown.
    pub fn left(&self, measured: &HeightMap, reference: &HeightMap) -> Vec<f64> {
        let is_moved = self.shift != DVec2::ZERO || self.turn != 0.0;
        let freedom = if is_moved { DegreesOfFreedom::All } else { DegreesOfFreedom::Plane };
        let (levelled, pixels) = (self.levelled(measured), reference.pixels);
        let slope = |at: usize| Some(slope(reference, at, freedom)).filter(|slope| !slope.is_nan());
        let shifted = |at: usize| {
            let slope = slope(at).unwrap_or_else(|| one_sided_slope(reference, at));
            let place = pixels.position(at % pixels.nx, at / pixels.nx);
            reference.heights[at] - (self.shift + self.turn * (place - self.centre).perp()).dot(slope)
        };
        levelled.heights.iter().enumerate().map(|(at, height)| height - shifted(at)).collect()
    }
}

#[cfg(test)]
mod tests {
    use sdf_bake::PixelGrid;

    use super::*;

    fn bead(p: DVec2) -> f64 {
        let along = (1.0 - ((p.x - 0.035) / 0.03).powi(4)).max(0.0);
        (2e-3 * along * (1.0 - (p.y / 5e-3).powi(2))).max(0.0)
    }

    fn maps(shift: DVec2) -> (HeightMap, HeightMap) {
        let pixels = PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: 0.5e-3, nx: 140, ny: 40 };
        let reference = HeightMap::from_function(pixels, bead);
        let measured = HeightMap::from_function(pixels, |p| bead(p - shift) + 12e-6 + 0.4e-3 * p.x - 0.7e-3 * p.y);
        (measured, reference)
    }

    fn dirty(map: &mut HeightMap) {
        for (at, height) in map.heights.iter_mut().enumerate() {
            *height += 2e-6 * (((at * 7919) % 1000) as f64 / 500.0 - 1.0);
            if at % 3 == 0 {
                *height -= 80e-6;
            }
            if at % 50 == 0 {
                *height = f64::NAN;
            }
        }
    }

    fn worst(found: &Registration) -> f64 {
        let corners = (0..4).map(|k| DVec2::new(0.07 * f64::from(k % 2), 0.02 * f64::from(k / 2) - 0.01));
        let error = |p: DVec2| (found.plane(p) - (12e-6 + 0.4e-3 * p.x - 0.7e-3 * p.y)).abs();
        corners.map(error).fold(0.0, f64::max)
    }

    #[test]
    fn offset_and_tilt_are_found_below_a_third_of_outliers() {
        let (mut measured, reference) = maps(DVec2::ZERO);
        dirty(&mut measured);
        let found = register(&measured, &reference, DegreesOfFreedom::Plane, |_| true).unwrap();
        println!("registration is off by {:.1e} m at the map's corners", worst(&found));
        assert!(worst(&found) < 0.2e-6, "{found:?}");
        assert!(super::super::residual(&found.levelled(&measured), &reference, |at| at % 3 != 0).rms < 2e-6);
    }

    #[test]
    fn a_shift_is_told_from_a_tilt() {
        let shift = DVec2::new(23e-6, -17e-6);
        let (mut measured, reference) = maps(shift);
        dirty(&mut measured);
        let found = register(&measured, &reference, DegreesOfFreedom::All, |_| true).unwrap();
        println!("shift {} m, off by {:.1e} m", found.shift, (found.shift - shift).length());
        assert!((found.shift - shift).length() < 1.5e-6, "{found:?}");
        assert!(worst(&found) < 0.3e-6, "{found:?}");
        let left = found.left(&measured, &reference);
        let clean: Vec<f64> =
            left.iter().copied().enumerate().filter(|(k, d)| k % 3 != 0 && d.is_finite()).map(|(_, d)| d).collect();
        assert!(centre_and_sigma(&clean).unwrap().1 < 2e-6);
    }

    #[test]
    fn a_turn_is_found_beside_a_shift() {
        let (turn, shift) = (1.5e-3, DVec2::new(-8e-6, 12e-6));
        let (mut measured, reference) = maps(DVec2::ZERO);
        let (pixels, middle) = (reference.pixels, DVec2::new(0.035, 0.0));
        measured = HeightMap::from_function(pixels, |p| {
            let from = p - shift - middle;
            bead(middle + DVec2::from_angle(-turn).rotate(from)) + measured.heights[pixels.nearest(p).unwrap()]
                - bead(p)
        });
        dirty(&mut measured);
        let found = register(&measured, &reference, DegreesOfFreedom::All, |_| true).unwrap();
        let at_middle = found.shift + found.turn * (middle - found.centre).perp();
        println!("turn {} rad, shift {} m, off by {:.1e} m", found.turn, at_middle, (at_middle - shift).length());
        assert!((found.turn - turn).abs() < 0.1e-3 && (at_middle - shift).length() < 2e-6, "{found:?}");
        let plane = register(&measured, &reference, DegreesOfFreedom::Plane, |_| true).unwrap();
        assert!(plane.turn == 0.0 && plane.sigma > 1.5 * found.sigma, "{plane:?}");
    }

    #[test]
    fn a_flat_plate_has_no_shift() {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 40, ny: 30 };
        let plate = HeightMap::from_function(pixels, |_| 0.0);
        let mut other = plate.clone();
        dirty(&mut other);
        let found = register(&other, &plate, DegreesOfFreedom::All, |_| true).unwrap();
        assert_eq!((found.shift, found.turn), (DVec2::ZERO, 0.0));
    }

    #[test]
    fn rounding_of_a_plate_shifts_nothing() {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.5e-3, nx: 40, ny: 30 };
        let rounded = |p: DVec2| 3e-10 * ((p.x * 7919e3).sin() + (p.y * 104_729e3).sin());
        let plate = HeightMap::from_function(pixels, rounded);
        let exact = HeightMap::from_function(pixels, |_| 0.0);
        let mut dirtied = exact.clone();
        dirty(&mut dirtied);
        for other in [exact, dirtied] {
            let found = register(&other, &plate, DegreesOfFreedom::All, |_| true).unwrap();
            assert!(found.shift.length() < 1e-2 * pixels.pitch, "{found:?}");
        }
    }

    #[test]
    fn maps_that_cannot_be_laid_on_each_other_say_why() {
        let (measured, reference) = maps(DVec2::ZERO);
        let plane = |takes: &dyn Fn(usize) -> bool| register(&measured, &reference, DegreesOfFreedom::Plane, takes);
        assert!(matches!(plane(&|at| at < 9), Err(RegistrationError::TooFewPixels { found: 9 })));
        assert!(plane(&|at| at < 140).is_err(), "one row fixes no tilt across it");
        let mut short = reference.clone();
        short.pixels.nx = 139;
        let error = register(&measured, &short, DegreesOfFreedom::Plane, |_| true);
        assert!(matches!(error, Err(RegistrationError::DifferentPixels { .. })));
    }
}
