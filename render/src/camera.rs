//! Camera position, orientation and projection; gives one ray for every image point.

use glam::{DVec2, DVec3};

use super::lens::Distortion;

/// Vertical field of view [rad] of the cameras made here: that of a 70 mm lens on a 24 mm sensor. The focal length is
/// long enough for little perspective distortion.
const VERTICAL_FIELD_OF_VIEW: f64 = 0.34;
/// Free border around a framed box, as a share of the image.
const BORDER: f64 = 0.03;

/// A half-line in the part's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start [m].
    pub origin: DVec3,
    /// Unit direction.
    pub direction: DVec3,
}

/// Projection of points onto the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Pinhole.
    Perspective {
        /// Angle between the lower and the upper edge of the image [rad].
        vertical_field_of_view: f64,
    },
    /// Parallel rays.
    Orthographic {
        /// Length that the image shows from its lower to its upper edge [m].
        height: f64,
    },
}

/// A camera in the part's frame. `right`, `up` and `forward` are orthonormal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Centre of projection [m].
    pub eye: DVec3,
    /// Unit direction towards the right of the image.
    pub right: DVec3,
    /// Unit direction towards the top of the image.
    pub up: DVec3,
    /// Unit direction into the scene.
    pub forward: DVec3,
    /// Pinhole or orthographic.
    pub projection: Projection,
    /// Lens distortion; orthographic cameras have none.
    pub distortion: Distortion,
}

impl Projection {
    /// Projection of a lens and a sensor, both [m]; a 70 mm lens with a 24 mm sensor is `of_lens(0.070, 0.024)`.
    pub fn of_lens(focal_length: f64, sensor_height: f64) -> Self {
        Self::Perspective { vertical_field_of_view: 2.0 * (0.5 * sensor_height / focal_length).atan() }
    }
}

impl Camera {
    /// Camera at `eye` that looks at `target`, both [m], with the part's z axis upwards in the image.
    pub fn look_at(eye: DVec3, target: DVec3, projection: Projection) -> Self {
        Self { eye, ..Self::oriented((target - eye).normalize_or(DVec3::NEG_Z), projection) }
    }

    /// The closest camera that shows a whole box.
    ///
    /// - `low`, `high`: corners of the box [m]
    /// - `azimuth`, `elevation`: direction from the box to the camera [rad]; azimuth from x towards y
    /// - `aspect`: image width divided by height
    pub fn framing(low: DVec3, high: DVec3, azimuth: f64, elevation: f64, aspect: f64) -> Self {
        let corner = |i: usize| {
            let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let corners: [DVec3; 8] = std::array::from_fn(corner);
        Self::close_up(&corners, outward(azimuth, elevation), BORDER * (high - low).length(), aspect)
    }

    /// The closest camera that shows all `points` [m], for example those of a weld.
    ///
    /// - `outward`: direction from the points to the camera, of any length
    /// - `margin`: distance shown around every point [m]
    /// - `aspect`: image width divided by height
    pub fn close_up(points: &[DVec3], outward: DVec3, margin: f64, aspect: f64) -> Self {
        let projection = Projection::Perspective { vertical_field_of_view: VERTICAL_FIELD_OF_VIEW };
        let mut camera = Self::oriented(-outward.normalize_or(DVec3::Z), projection);
        let slope_y = (0.5 * VERTICAL_FIELD_OF_VIEW).tan();
        let horizontal = fit(points, camera.right, camera.forward, slope_y * aspect, margin);
        let vertical = fit(points, camera.up, camera.forward, slope_y, margin);
        let along = horizontal.nearest.min(vertical.nearest);
        camera.eye = camera.right * horizontal.centre + camera.up * vertical.centre + camera.forward * along;
        camera
    }

    /// Returns the ray through a point of the image.
    ///
    /// - `at`: position from the left and from the top of the image, 0 to 1
    /// - `aspect`: image width divided by height
    pub fn ray(&self, at: DVec2, aspect: f64) -> Ray {
        let image = DVec2::new((2.0 * at.x - 1.0) * aspect, 2.0 * at.y - 1.0) * self.half_image();
        match self.projection {
            Projection::Perspective { .. } => {
                let plane = self.distortion.undistort(image);
                let direction = self.forward + self.right * plane.x - self.up * plane.y;
                Ray { origin: self.eye, direction: direction.normalize_or(self.forward) }
            }
            Projection::Orthographic { .. } => {
                Ray { origin: self.eye + self.right * image.x - self.up * image.y, direction: self.forward }
            }
        }
    }

    /// Half of the image height: for orthographic cameras [m], for perspective cameras at unit distance [1].
    pub(crate) fn half_image(&self) -> f64 {
        match self.projection {
            Projection::Perspective { vertical_field_of_view } => (0.5 * vertical_field_of_view).tan(),
            Projection::Orthographic { height } => 0.5 * height,
        }
    }

    /// Projects a point [m] to the image: position from the left and from the top, 0 to 1 within it; `None` behind a
    /// pinhole.
    pub fn project(&self, point: DVec3, aspect: f64) -> Option<DVec2> {
        let away = point - self.eye;
        let across = DVec2::new(away.dot(self.right), -away.dot(self.up));
        let at = match self.projection {
            Projection::Perspective { vertical_field_of_view } => {
                let depth = Some(self.depth(point)).filter(|depth| *depth > 0.0)?;
                self.distortion.distort(across / depth) / (0.5 * vertical_field_of_view).tan()
            }
            Projection::Orthographic { height } => across / (0.5 * height),
        };
        Some(0.5 + 0.5 * at / DVec2::new(aspect, 1.0))
    }

    /// Distance of a point [m] from the camera along its axis [m].
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye).dot(self.forward)
    }

    /// Length [m] that one pixel of an image `height` pixels high spans at `depth` [m].
    pub fn pixel_size(&self, depth: f64, height: usize) -> f64 {
        self.pixel_size_within(depth, height, self.half_image())
    }

    /// [`Camera::pixel_size`] for many pixels; `half_image`: [`Camera::half_image`].
    #[inline(always)]
    pub(crate) fn pixel_size_within(&self, depth: f64, height: usize, half_image: f64) -> f64 {
        let distance = if matches!(self.projection, Projection::Orthographic { .. }) { 1.0 } else { depth };
        2.0 * half_image * distance / height.max(1) as f64
    }

    /// A camera at the origin that looks along a unit vector.
    fn oriented(forward: DVec3, projection: Projection) -> Self {
        // Looking straight up or down, z has no direction in the image; y takes its place.
        let vertical = if forward.z.abs() > 1.0 - 1e-9 { DVec3::Y } else { DVec3::Z };
        let right = forward.cross(vertical).normalize_or(DVec3::X);
        Self {
            eye: DVec3::ZERO,
            right,
            up: right.cross(forward),
            forward,
            projection,
            distortion: Distortion::default(),
        }
    }
}

/// Unit vector towards a camera at `azimuth` (from x towards y) and `elevation` [rad].
pub fn outward(azimuth: f64, elevation: f64) -> DVec3 {
    DVec3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin())
}

/// One axis of the closest perspective camera.
struct Fit {
    /// Coordinate of the eye along the image axis [m].
    centre: f64,
    /// Greatest coordinate of the eye along the viewing axis [m] from which all points are visible.
    nearest: f64,
}

/// A point (u, w) is visible from (e, f) if |u − e| + margin √(1 + slope²) ≤ slope (w − f). Both signs bound e; the two
/// bounds meet at the greatest f.
fn fit(points: &[DVec3], axis: DVec3, forward: DVec3, slope: f64, margin: f64) -> Fit {
    let pad = margin * (1.0 + slope * slope).sqrt();
    let bound = |sign: f64| {
        let reach = |p: &DVec3| sign * p.dot(axis) - slope * p.dot(forward) + pad;
        points.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
    };
    if points.is_empty() {
        return Fit { centre: 0.0, nearest: 0.0 };
    }
    let (upper, lower) = (bound(1.0), bound(-1.0));
    Fit { centre: 0.5 * (upper - lower), nearest: -0.5 * (upper + lower) / slope }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Image coordinates (−1 to 1) of a point.
    fn project(camera: &Camera, point: DVec3, aspect: f64) -> DVec2 {
        let away = point - camera.eye;
        let scale = camera.depth(point) * (0.5 * VERTICAL_FIELD_OF_VIEW).tan();
        DVec2::new(away.dot(camera.right) / (scale * aspect), away.dot(camera.up) / scale)
    }

    #[test]
    fn framing_shows_the_whole_box_and_touches_two_borders() {
        let (low, high) = (DVec3::new(-0.02, 0.01, 0.0), DVec3::new(0.13, 0.05, 0.03));
        for (azimuth, elevation) in [(0.3, 0.5), (-2.0, 0.1), (1.0, 1.5), (4.0, -0.7)] {
            let camera = Camera::framing(low, high, azimuth, elevation, 4.0 / 3.0);
            let corners = (0..8).map(|i| {
                let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
                project(&camera, DVec3::new(pick(0), pick(1), pick(2)), 4.0 / 3.0)
            });
            let (least, most) = corners
                .fold((DVec2::MAX, DVec2::MIN), |(least, most), at| (DVec2::min(least, at), DVec2::max(most, at)));
            assert!(least.min_element() > -1.0 && most.max_element() < 1.0, "{least} to {most}");
            let filled = (most - least).max_element();
            assert!(filled > 1.75, "the box fills {filled} of 2 at azimuth {azimuth}");
        }
    }

    #[test]
    fn the_central_ray_runs_from_the_eye_to_the_target() {
        let (eye, target) = (DVec3::new(0.3, -0.2, 0.4), DVec3::new(0.01, 0.02, 0.03));
        let camera = Camera::look_at(eye, target, Projection::Orthographic { height: 0.1 });
        let ray = camera.ray(DVec2::splat(0.5), 1.5);
        assert!((ray.origin - eye).length() < 1e-15);
        assert!((ray.direction - (target - eye).normalize()).length() < 1e-15);
        let top = camera.ray(DVec2::new(0.5, 0.0), 1.5);
        assert!((top.origin.distance(eye) - 0.05).abs() < 1e-15 && top.origin.z > eye.z);
    }

    #[test]
    fn points_are_imaged_where_their_rays_leave() {
        let distortion = Distortion { radial: [-0.3, 0.1, 0.0], tangential: [0.002, -0.001] };
        let (eye, target) = (DVec3::new(0.3, -0.2, 0.4), DVec3::new(0.01, 0.02, 0.03));
        for projection in [Projection::of_lens(0.035, 0.024), Projection::Orthographic { height: 0.2 }] {
            let camera = Camera { distortion, ..Camera::look_at(eye, target, projection) };
            for i in 0..25 {
                let at = DVec2::new(f64::from(i % 5), f64::from(i / 5)) / 4.0;
                let ray = camera.ray(at, 1.5);
                let back = camera.project(ray.origin + ray.direction * 0.37, 1.5).unwrap();
                assert!(back.distance(at) < 1e-9, "{back} for {at}");
            }
            let behind = camera.project(eye - camera.forward, 1.5);
            assert_eq!(behind.is_none(), matches!(projection, Projection::Perspective { .. }));
        }
    }

    #[test]
    fn a_camera_straight_above_has_an_orthonormal_frame() {
        let projection = Projection::Perspective { vertical_field_of_view: 0.5 };
        let camera = Camera::look_at(DVec3::Z, DVec3::ZERO, projection);
        assert!((camera.right.cross(camera.up) + camera.forward).length() < 1e-12);
        assert!((camera.up - DVec3::Y).length() < 1e-12);
    }
}
