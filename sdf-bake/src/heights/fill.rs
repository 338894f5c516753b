//! Fills missing pixels by the thin plate of least bending energy through the measured pixels.
//!
//! The energy is `Σ h_xx² + 2 h_xy² + h_yy²` in second differences (Duchon 1977), over the stencils that include a
//! missing pixel and lie within the map. The result is exact for a surface of constant curvature. The normal equations
//! are solved by conjugate gradients.

use std::collections::VecDeque;

use super::HeightMap;

/// Relative residual at which the iteration stops.
const SETTLED: f64 = 1e-7;
/// Greatest number of conjugate gradient steps; holes of 50 pixels across need a few hundred.
const MOST_STEPS: usize = 2000;

/// One second difference: pixels and weights.
struct Stencil {
    pixels: [usize; 4],
    weights: [f64; 4],
}

/// Returns the map with every missing pixel filled. At least one pixel must be measured.
pub(super) fn filled(map: &HeightMap) -> HeightMap {
    let missing: Vec<bool> = map.heights.iter().map(|height| !height.is_finite()).collect();
    let mut heights = first_guess(map);
    let unknown: Vec<usize> = (0..missing.len()).filter(|&at| missing[at]).collect();
    if !unknown.is_empty() {
        relax(&mut heights, &missing, &unknown, &stencils(map, &missing));
    }
    HeightMap { pixels: map.pixels, heights }
}

/// Fills each hole layer by layer from its rim with the mean of the known neighbours.
fn first_guess(map: &HeightMap) -> Vec<f64> {
    let (nx, ny) = (map.pixels.nx as isize, map.pixels.ny as isize);
    let mut heights = map.heights.clone();
    let neighbours = |at: usize| {
        let (i, j) = ((at as isize) % nx, (at as isize) / nx);
        [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter().filter_map(move |(di, dj)| {
            let within = (0..nx).contains(&(i + di)) && (0..ny).contains(&(j + dj));
            within.then(|| ((j + dj) * nx + i + di) as usize)
        })
    };
    let mut waiting: Vec<bool> = heights.iter().map(|height| !height.is_finite()).collect();
    let seen = (0..heights.len()).filter(|&at| heights[at].is_finite());
    let mut queue: VecDeque<usize> = seen.collect();
    while let Some(at) = queue.pop_front() {
        for near in neighbours(at) {
            if std::mem::replace(&mut waiting[near], false) {
                let known = neighbours(near).map(|k| heights[k]).filter(|height| height.is_finite());
                let (sum, count) = known.fold((0.0, 0.0), |(sum, count), height| (sum + height, count + 1.0));
                heights[near] = sum / count;
                queue.push_back(near);
            }
        }
    }
    heights
}

/// All second differences that include a missing pixel.
fn stencils(map: &HeightMap, missing: &[bool]) -> Vec<Stencil> {
    let (nx, ny) = (map.pixels.nx, map.pixels.ny);
    let mut list = Vec::new();
    let mut push = |pixels: [usize; 4], weights: [f64; 4]| {
        if pixels.iter().any(|&at| missing[at]) {
            list.push(Stencil { pixels, weights });
        }
    };
    let twist = 2f64.sqrt();
    for j in 0..ny {
        for i in 0..nx {
            let at = j * nx + i;
            if i + 2 < nx {
                push([at, at + 1, at + 2, at], [1.0, -2.0, 1.0, 0.0]);
            }
            if j + 2 < ny {
                push([at, at + nx, at + 2 * nx, at], [1.0, -2.0, 1.0, 0.0]);
            }
            if i + 1 < nx && j + 1 < ny {
                push([at, at + 1, at + nx, at + nx + 1], [twist, -twist, -twist, twist]);
            }
        }
    }
    list
}

/// Conjugate gradients on the normal equations of the unknown pixels.
fn relax(heights: &mut [f64], missing: &[bool], unknown: &[usize], stencils: &[Stencil]) {
    let mut field = heights.to_vec();
    let mut residual = bending(&field, missing, stencils);
    let dot = |a: &[f64], b: &[f64]| unknown.iter().map(|&at| a[at] * b[at]).sum::<f64>();
    let mut direction = residual.clone();
    let first = dot(&residual, &residual);
    let mut square = first;
    for _ in 0..MOST_STEPS {
        if square <= SETTLED * SETTLED * first {
            break;
        }
        let curved = bending(&direction, missing, stencils);
        // `bending` is the negative of the operator.
        let way = -square / dot(&direction, &curved);
        for &at in unknown {
            field[at] += way * direction[at];
            residual[at] += way * curved[at];
        }
        let next = dot(&residual, &residual);
        for &at in unknown {
            direction[at] = residual[at] + next / square * direction[at];
        }
        square = next;
    }
    for &at in unknown {
        heights[at] = field[at];
    }
}

/// Minus half the gradient of the bending energy; zero at the measured pixels.
fn bending(field: &[f64], missing: &[bool], stencils: &[Stencil]) -> Vec<f64> {
    let mut gradient = vec![0.0; field.len()];
    for Stencil { pixels, weights } in stencils {
        let difference: f64 = pixels.iter().zip(weights).map(|(&at, weight)| weight * field[at]).sum();
        for (&at, weight) in pixels.iter().zip(weights) {
            if missing[at] {
                gradient[at] -= weight * difference;
            }
        }
    }
    gradient
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::super::PixelGrid;
    use super::*;

    fn with_holes(height: impl Fn(DVec2) -> f64) -> (HeightMap, HeightMap) {
        let pixels = PixelGrid { origin: DVec2::ZERO, pitch: 0.25e-3, nx: 60, ny: 40 };
        let whole = HeightMap::from_function(pixels, height);
        let mut holed = whole.clone();
        for (i, j) in (20..32).flat_map(|i| (10..20).map(move |j| (i, j))).chain([(0, 0), (5, 5), (6, 5), (59, 20)]) {
            holed.heights[pixels.at(i, j)] = f64::NAN;
        }
        (whole, holed)
    }

    fn worst(height: impl Fn(DVec2) -> f64) -> f64 {
        let (whole, holed) = with_holes(height);
        let filled = holed.filled().unwrap();
        whole.heights.iter().zip(&filled.heights).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn a_plane_is_filled_exactly_and_a_bead_within_microns() {
        let plane = worst(|p| 1e-3 + 0.3 * p.x - 0.2 * p.y);
        let bead = worst(|p| 2e-3 * (1.0 - ((p.y - 4e-3) / 5e-3).powi(2)) + 0.1 * p.x);
        println!("holes up to 12 x 10 pixels: {plane:.1e} m on a plane, {bead:.1e} m on a bead");
        assert!(plane < 1e-9 && bead < 4e-5, "{plane}, {bead}");
    }
}
