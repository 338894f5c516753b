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
pub(super) fn distance(surface: &LatticeHeights, point: DVec3, most: f64) -> f64 {
    let (start, nearest) = nearest_node(surface, point, most);
    if nearest > most + 1.0 {
        return most;
    }
    descend(surface, point, start).min(most)
}

/// Returns the lattice point of the surface that is nearest to a lattice point above or below it, and its distance.
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
    fn at(surface: &LatticeHeights, foot: DVec2) -> Self {
        let floor = foot.floor();
        let corner = floor.as_ivec2();
        let (x, y) = (Weights::at(foot.x - floor.x), Weights::at(foot.y - floor.y));
        let mut patch = Self { height: 0.0, slope: DVec2::ZERO, bend: [0.0; 3] };
        for b in 0..4 {
            let (mut value, mut slope, mut bend) = (0.0, 0.0, 0.0);
            let row = surface.row(corner + IVec2::new(-1, b as i32 - 1), 4);
            for (a, height) in row.iter().enumerate() {
                value += x.value[a] * height;
                slope += x.slope[a] * height;
                bend += x.bend[a] * height;
            }
            patch.height += y.value[b] * value;
            patch.slope += DVec2::new(y.value[b] * slope, y.slope[b] * value);
            patch.bend[0] += y.value[b] * bend;
            patch.bend[1] += y.slope[b] * slope;
            patch.bend[2] += y.bend[b] * value;
        }
        patch
    }
}

/// [`cubic_weights`] with their first and second derivatives.
struct Weights {
    value: [f64; 4],
    slope: [f64; 4],
    bend: [f64; 4],
}

impl Weights {
    fn at(t: f64) -> Self {
        let t2 = t * t;
        Self {
            value: cubic_weights(t),
            slope: [
                0.5 * (4.0 * t - 3.0 * t2 - 1.0),
                0.5 * (9.0 * t2 - 10.0 * t),
                0.5 * (8.0 * t - 9.0 * t2 + 1.0),
                0.5 * (3.0 * t2 - 2.0 * t),
            ],
            bend: [2.0 - 3.0 * t, 9.0 * t - 5.0, 4.0 - 9.0 * t, 3.0 * t - 1.0],
        }
    }
}
