//! Closest surface point of a point in the band, by steps along the gradient.

use glam::{DVec3, IVec3};

use crate::grid::{BrickGrid, cell_corner};
use crate::tangent::Tangent;

/// Greatest number of steps along the gradient.
const STEPS: usize = 5;
/// Step length at which the iteration has converged [voxels].
const SETTLED: f64 = 1e-6;
/// Greatest deviation of a slope from 1; above it an edge of the field crosses the stencil.
const CLEAN: f64 = 0.05;
/// [`CLEAN`] for differences across two voxels.
const CLEAN_ACROSS: f64 = 0.1;

impl BrickGrid {
    /// Returns the point of {φ = 0} closest to `point` [m], or `None` beyond the band.
    ///
    /// Third order in the voxel size if the field is smooth along the path and the stencil of 4³ voxels lies in the
    /// band, which requires a band about three voxels wider than the point's distance. Next to a sharp edge, where the
    /// interpolant is rounder than the surface, the result comes from the tangent planes of the voxels around the
    /// point.
    pub fn closest_surface_point(&self, point: DVec3) -> Option<DVec3> {
        let mut at = point;
        for taken in 0..STEPS {
            let (phi, gradient) = match self.sample_cubic(at) {
                Some((phi, gradient)) if (gradient.length() - 1.0).abs() < CLEAN => (phi, gradient),
                _ if taken > 0 => break,
                _ => match self.sample_across(at) {
                    (phi, gradient) if (gradient.length() - 1.0).abs() < CLEAN_ACROSS => (phi, gradient),
                    _ => return self.closest_on_planes(point),
                },
            };
            if phi.abs() >= f64::from(self.band) {
                return None;
            }
            let step = gradient * (phi / gradient.length_squared());
            at -= step;
            if step.length() < SETTLED * self.voxel {
                break;
            }
        }
        Some(at)
    }

    /// φ [m] and its gradient at a point [m], from trilinear values a voxel away on both sides.
    fn sample_across(&self, point: DVec3) -> (f64, DVec3) {
        let slope = |axis: DVec3| {
            let step = axis * self.voxel;
            f64::from(self.sample(point + step) - self.sample(point - step)) / (2.0 * self.voxel)
        };
        (f64::from(self.sample(point)), DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)))
    }

    /// Returns the point closest to `point` [m] on the tangent planes of the voxels around it: on the intersection of
    /// their half-spaces at an outer edge, on their union at an inner edge.
    fn closest_on_planes(&self, point: DVec3) -> Option<DVec3> {
        let (corner, _) = self.cell(point);
        let corners = (0..8).map(|i| corner + cell_corner(i));
        let tangents: Vec<Tangent> = corners.clone().filter_map(|voxel| self.tangent(voxel)).collect();
        let heights = |at: DVec3| tangents.iter().map(move |t| (t.normal.dot(at - t.foot), t.normal));
        let highest = |at| heights(at).max_by(|a, b| a.0.total_cmp(&b.0));
        let lowest = |at| heights(at).min_by(|a, b| a.0.total_cmp(&b.0));
        let (mut outer, mut inner) = (0.0, 0.0);
        for voxel in corners {
            let phi = f64::from(self.phi_at(voxel)) / self.voxel;
            outer += (highest(voxel.as_dvec3())?.0 - phi).abs();
            inner += (lowest(voxel.as_dvec3())?.0 - phi).abs();
        }
        let mut at = point / self.voxel;
        for _ in 0..STEPS {
            let (height, normal) = if outer <= inner { highest(at)? } else { lowest(at)? };
            at -= normal * height;
        }
        Some(at * self.voxel)
    }

    fn tangent(&self, voxel: IVec3) -> Option<Tangent> {
        let tangent = self.tangent_of(|step| self.phi_at(voxel + step))?;
        Some(Tangent { foot: tangent.foot + voxel.as_dvec3(), ..tangent })
    }

    /// φ [m] and its gradient at a point [m] by cubic convolution of 4³ voxels (Keys 1981, a = −1/2): third order, with
    /// a continuous gradient. `None` if one of the voxels is beyond the band.
    pub fn sample_cubic(&self, point: DVec3) -> Option<(f64, DVec3)> {
        let (corner, fraction) = self.cell(point);
        let [x, y, z] = fraction.to_array().map(|t| weights(f64::from(t)));
        let (mut value, mut gradient) = (0.0, DVec3::ZERO);
        for i in 0..4 {
            for j in 0..4 {
                let (mut row, mut slope) = (0.0, 0.0);
                for k in 0..4 {
                    let phi = self.phi_at(corner + IVec3::new(i as i32, j as i32, k as i32) - 1);
                    if phi.abs() >= self.band {
                        return None;
                    }
                    row += z.0[k] * f64::from(phi);
                    slope += z.1[k] * f64::from(phi);
                }
                value += x.0[i] * y.0[j] * row;
                gradient += DVec3::new(x.1[i] * y.0[j] * row, x.0[i] * y.1[j] * row, x.0[i] * y.0[j] * slope);
            }
        }
        Some((value, gradient / self.voxel))
    }
}

/// Weights of four values around a position `t` (0 to 1) between the middle two, and weights of the derivative.
fn weights(t: f64) -> ([f64; 4], [f64; 4]) {
    let (t2, t3) = (t * t, t * t * t);
    let value = [
        0.5 * (-t3 + 2.0 * t2 - t),
        0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t),
        0.5 * (t3 - t2),
    ];
    let slope = [
        0.5 * (-3.0 * t2 + 4.0 * t - 1.0),
        0.5 * (9.0 * t2 - 10.0 * t),
        0.5 * (-9.0 * t2 + 8.0 * t + 1.0),
        0.5 * (3.0 * t2 - 2.0 * t),
    ];
    (value, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Exact closest point of a torus around z.
    fn torus_foot(p: DVec3, ring: f64, tube: f64) -> DVec3 {
        let centre = DVec3::new(p.x, p.y, 0.0).normalize() * ring;
        centre + (p - centre).normalize() * tube
    }

    /// Largest error [m] of closest points up to `reach` [voxels] from a torus.
    fn torus_error(voxel: f64, reach: f64) -> f64 {
        let (ring, tube) = (0.01, 0.004);
        let half = DVec3::new(ring + tube, ring + tube, tube);
        let distance = |p: DVec3| (p.x.hypot(p.y) - ring).hypot(p.z) - tube;
        let grid = BrickGrid::from_distance(-half, half, voxel, 6.0, distance);
        let error = |i: i32| {
            let (turn, around) = (f64::from(i) * 2.399_963, f64::from(i) * 0.713);
            let off = reach * voxel * (f64::from(i % 41) / 20.0 - 1.0);
            let out = DVec3::new(turn.cos(), turn.sin(), 0.0);
            let p = out * ring + (out * around.cos() + DVec3::Z * around.sin()) * (tube + off);
            grid.closest_surface_point(p).unwrap().distance(torus_foot(p, ring, tube))
        };
        (0..2000).map(error).fold(0.0, f64::max)
    }

    #[test]
    fn closest_points_of_a_torus_are_third_order() {
        let (coarse, fine) = (torus_error(0.0005, 1.5), torus_error(0.00025, 1.5));
        println!("closest point: error {:.1e} voxels, half the voxel {:.1e}", coarse / 0.0005, fine / 0.00025);
        assert!(coarse < 0.02 * 0.0005, "{coarse}");
        assert!(coarse / fine > 6.5, "{coarse} to {fine}");
    }

    #[test]
    fn closest_points_of_a_box_lie_on_it() {
        let (half, voxel) = (DVec3::new(0.0063, 0.0051, 0.0042), 0.0004);
        let grid = BrickGrid::from_distance(-half, half, voxel, 4.0, |p| {
            let q = p.abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        });
        let mut worst = [0f64; 2];
        for i in 0..4000 {
            let t = f64::from(i);
            let p = DVec3::new((t * 0.754_877).fract(), (t * 0.569_84).fract(), t / 4000.0) * 2.0 - 1.0;
            let p = p * (half + 2.0 * voxel);
            let foot = p.clamp(-half, half);
            if foot == p || foot.distance(p) > 2.0 * voxel {
                continue;
            }
            let on_edge = (foot.abs() - half).to_array().iter().filter(|d| d.abs() < 1e-12).count() > 1;
            let error = grid.closest_surface_point(p).unwrap().distance(foot) / voxel;
            worst[usize::from(on_edge)] = worst[usize::from(on_edge)].max(error);
        }
        println!("closest point of a box: {:.3} voxels on faces, {:.3} on edges and corners", worst[0], worst[1]);
        assert!(worst[0] < 0.5 && worst[1] < 0.5, "{worst:?}");
    }

    #[test]
    fn beyond_the_band_there_is_none() {
        let grid =
            BrickGrid::from_distance(DVec3::splat(-0.01), DVec3::splat(0.01), 0.0005, 3.0, |p| p.length() - 0.01);
        assert_eq!(grid.closest_surface_point(DVec3::ZERO), None);
        assert_eq!(grid.closest_surface_point(DVec3::X), None);
        assert!(grid.closest_surface_point(DVec3::X * 0.0112).is_some());
    }
}
