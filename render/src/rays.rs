//! The rays of a tile in structure-of-arrays form, in double precision because a camera may be far away.

use glam::DVec3;

use super::camera::{Camera, Projection};
use super::lanes::LANES;

/// One number per ray.
pub(crate) type Wide = [f64; LANES];

/// Positions in the image.
pub(crate) struct ImagePositions {
    /// From the left, 0 to 1.
    pub(crate) across: Wide,
    /// From the top, 0 to 1.
    pub(crate) down: Wide,
    /// True for lanes with a position; the other lanes are undefined.
    pub(crate) wanted: [bool; LANES],
}

/// Rays in the part's frame.
pub(crate) struct Rays {
    /// Start points by component [m].
    pub(crate) origins: [Wide; 3],
    /// Unit directions by component.
    pub(crate) directions: [Wide; 3],
    /// True for lanes with a ray; the other lanes are undefined.
    pub(crate) wanted: [bool; LANES],
}

impl Rays {
    /// Lane form of [`Camera::ray`].
    ///
    /// - `aspect`: image width divided by height
    /// - `half_image`: [`Camera::half_image`]
    #[inline(always)]
    pub(crate) fn through(at: &ImagePositions, camera: &Camera, (aspect, half_image): (f64, f64)) -> Self {
        let mut rays = Self { origins: [[0.0; LANES]; 3], directions: [[0.0; LANES]; 3], wanted: at.wanted };
        let (mut across, mut down) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            across[i] = (2.0 * at.across[i] - 1.0) * aspect * half_image;
            down[i] = (2.0 * at.down[i] - 1.0) * half_image;
        }
        match camera.projection {
            Projection::Perspective { .. } => {
                if !camera.distortion.is_none() {
                    for i in (0..LANES).filter(|&i| at.wanted[i]) {
                        [across[i], down[i]] = camera.distortion.undistort([across[i], down[i]].into()).into();
                    }
                }
                for i in 0..LANES {
                    let direction = camera.forward + camera.right * across[i] - camera.up * down[i];
                    rays.set(i, camera.eye, direction.normalize_or(camera.forward));
                }
            }
            Projection::Orthographic { .. } => {
                for i in 0..LANES {
                    let origin = camera.eye + camera.right * across[i] - camera.up * down[i];
                    rays.set(i, origin, camera.forward);
                }
            }
        }
        rays
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, origin: DVec3, direction: DVec3) {
        for axis in 0..3 {
            (self.origins[axis][lane], self.directions[axis][lane]) = (origin[axis], direction[axis]);
        }
    }

    /// Start of one ray [m].
    #[inline(always)]
    pub(crate) fn origin(&self, lane: usize) -> DVec3 {
        DVec3::new(self.origins[0][lane], self.origins[1][lane], self.origins[2][lane])
    }

    /// Unit direction of one ray.
    #[inline(always)]
    pub(crate) fn direction(&self, lane: usize) -> DVec3 {
        DVec3::new(self.directions[0][lane], self.directions[1][lane], self.directions[2][lane])
    }

    /// Start [m] and unit direction halfway between the first and the last ray; zeros if there are no rays.
    #[inline(always)]
    pub(crate) fn middle(&self) -> (DVec3, DVec3) {
        let first = self.wanted.iter().position(|wanted| *wanted).unwrap_or(0);
        let last = self.wanted.iter().rposition(|wanted| *wanted).unwrap_or(0);
        let origin = (self.origin(first) + self.origin(last)) * 0.5;
        (origin, (self.direction(first) + self.direction(last)).normalize_or_zero())
    }

    /// Greatest distance of the starts or directions of all rays from a given one.
    #[inline(always)]
    pub(crate) fn farthest(&self, of: &[Wide; 3], from: DVec3) -> f64 {
        let mut squares = [0.0; LANES];
        for i in 0..LANES {
            let square = DVec3::new(of[0][i], of[1][i], of[2][i]).distance_squared(from);
            squares[i] = if self.wanted[i] { square } else { 0.0 };
        }
        squares.into_iter().fold(0.0, f64::max).sqrt()
    }

    /// Points on the rays at distances from their starts [m], by component.
    #[inline(always)]
    pub(crate) fn points(&self, distances: &Wide) -> [Wide; 3] {
        let mut points = self.origins;
        for axis in 0..3 {
            for i in 0..LANES {
                points[axis][i] += self.directions[axis][i] * distances[i];
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::lens::Distortion;

    #[test]
    fn rays_side_by_side_are_those_of_the_camera() {
        let distortion = Distortion { radial: [-0.3, 0.1, 0.0], tangential: [0.002, -0.001] };
        let at = |i: usize| DVec2::new(0.06 * i as f64, 1.0 - 0.051 * i as f64);
        let places = ImagePositions {
            across: std::array::from_fn(|i| at(i).x),
            down: std::array::from_fn(|i| at(i).y),
            wanted: std::array::from_fn(|i| i != 5),
        };
        for projection in [Projection::of_lens(0.035, 0.024), Projection::Orthographic { height: 0.2 }] {
            for distortion in [Distortion::default(), distortion] {
                let (eye, target) = (DVec3::new(0.3, -0.2, 0.4), DVec3::new(0.01, 0.02, 0.03));
                let camera = Camera { distortion, ..Camera::look_at(eye, target, projection) };
                let rays = Rays::through(&places, &camera, (1.5, camera.half_image()));
                for lane in (0..LANES).filter(|lane| places.wanted[*lane]) {
                    let alone = camera.ray(at(lane), 1.5);
                    assert_eq!((rays.origin(lane), rays.direction(lane)), (alone.origin, alone.direction));
                }
            }
        }
    }
}
