//! The closest point of a bicubic surface over the voxel lattice, in voxel units.

use glam::{DVec2, DVec3, IVec2};

use super::lattice::{LatticeHeights, cubic_weights};

/// Greatest number of Newton steps; three are usual.
const STEPS: usize = 12;
/// Step below which the foot has converged [voxels]; the error of the distance is its square.
const SETTLED: f64 = 1e-5;

/// Height, slope and curvature of the surface at a point.
struct Patch {
    height: f64,
    slope: DVec2,
    /// h_xx, h_xy, h_yy.
    bend: [f64; 3],
}

/// Unsigned distance [voxels] from a lattice point [voxels] to the surface, at most `most`.
///
/// Newton's method starts from the nearest lattice point of the surface, so that the nearer one of two flanks is found.
/// All functions here are inlined, for [`in_wide_lanes`](crate::simd::in_wide_lanes).
#[inline(always)]
pub(super) fn distance(surface: &LatticeHeights, point: DVec3, most: f64) -> f64 {
    let (start, nearest) = nearest_node(surface, point, most);
    if nearest > most + 1.0 {
        return most;
    }
    descend(surface, point, start).min(most)
}

/// Returns the lattice point of the surface that is nearest to a lattice point above or below it, and its distance.
#[inline(always)]
fn nearest_node(surface: &LatticeHeights, point: DVec3, most: f64) -> (DVec2, f64) {
    let centre = point.truncate().as_ivec2();
    let (mut best, mut least) = (IVec2::ZERO, (surface.at(centre) - point.z).powi(2));
    let reach = least.sqrt().min(most + 1.0) as i32;
    for j in -reach..=reach {
        let row = surface.row(centre + IVec2::new(-reach, j), 2 * reach as usize + 1);
        for (i, height) in (-reach..).zip(row) {
            let square = f64::from(i * i + j * j) + (height - point.z).powi(2);
            if square < least {
                (best, least) = (IVec2::new(i, j), square);
            }
        }
    }
    ((centre + best).as_dvec2(), least.sqrt())
}

/// Distance after Newton steps from `foot`, each of which must reduce it.
#[inline(always)]
fn descend(surface: &LatticeHeights, point: DVec3, mut foot: DVec2) -> f64 {
    let mut patch = Patch::at(surface, foot);
    let mut nearest = (foot - point.truncate()).extend(patch.height - point.z).length();
    for _ in 0..STEPS {
        let mut step = newton_step(&patch, point, foot).clamp_length_max(1.0);
        let (next, length) = loop {
            let next = Patch::at(surface, foot + step);
            let length = (foot + step - point.truncate()).extend(next.height - point.z).length();
            if length <= nearest || step.length() < SETTLED {
                break (next, length);
            }
            step *= 0.5;
        };
        if length >= nearest {
            break;
        }
        (foot, patch, nearest) = (foot + step, next, length);
        if step.length() < SETTLED {
            break;
        }
    }
    nearest
}

/// Newton step towards the foot of the perpendicular; Gauss-Newton step if the curvature would increase the distance.
#[inline(always)]
fn newton_step(patch: &Patch, point: DVec3, foot: DVec2) -> DVec2 {
    let rise = patch.height - point.z;
    let (sx, sy) = (patch.slope.x, patch.slope.y);
    let gradient = foot - point.truncate() + rise * patch.slope;
    let solve = |a: f64, b: f64, c: f64| {
        let determinant = a * c - b * b;
        let step = DVec2::new(b * gradient.y - c * gradient.x, b * gradient.x - a * gradient.y) / determinant;
        (a + c > 0.0 && determinant > 0.1).then_some(step)
    };
    let [xx, xy, yy] = patch.bend;
    let (a, b, c) = (1.0 + sx * sx, sx * sy, 1.0 + sy * sy);
    solve(a + rise * xx, b + rise * xy, c + rise * yy).or_else(|| solve(a, b, c)).unwrap_or(DVec2::ZERO)
}

impl Patch {
    #[inline(always)]
    fn at(surface: &LatticeHeights, foot: DVec2) -> Self {
        let floor = foot.floor();
        let corner = floor.as_ivec2();
        let (x, y) = (weights(foot.x - floor.x), weights(foot.y - floor.y));
        let mut patch = Self { height: 0.0, slope: DVec2::ZERO, bend: [0.0; 3] };
        for (b, [value, slope, bend, _]) in y.into_iter().enumerate() {
            let row = surface.row(corner + IVec2::new(-1, b as i32 - 1), 4);
            let mut along = [0.0; 4];
            for (weights, height) in x.iter().zip(row) {
                for (sum, weight) in along.iter_mut().zip(weights) {
                    *sum += weight * height;
                }
            }
            patch.height += value * along[0];
            patch.slope += DVec2::new(value * along[1], slope * along[0]);
            patch.bend[0] += value * along[2];
            patch.bend[1] += slope * along[1];
            patch.bend[2] += bend * along[0];
        }
        patch
    }
}

/// For each of the four points around a cell at `t` (0 to 1) its weight as in [`cubic_weights`], the weight's first and
/// second derivative, and a zero that fills four lanes.
#[inline(always)]
fn weights(t: f64) -> [[f64; 4]; 4] {
    let t2 = t * t;
    let value = cubic_weights(t);
    let slope = [
        0.5 * (4.0 * t - 3.0 * t2 - 1.0),
        0.5 * (9.0 * t2 - 10.0 * t),
        0.5 * (8.0 * t - 9.0 * t2 + 1.0),
        0.5 * (3.0 * t2 - 2.0 * t),
    ];
    let bend = [2.0 - 3.0 * t, 9.0 * t - 5.0, 4.0 - 9.0 * t, 3.0 * t - 1.0];
    [0, 1, 2, 3].map(|point| [value[point], slope[point], bend[point], 0.0])
}
