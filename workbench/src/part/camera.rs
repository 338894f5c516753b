//! Camera of a picture: orbits the scanned area, zooms, and shifts sideways.

use glam::{DVec2, DVec3};
use render::Camera;
use sdf_bake::HeightMap;
use serde::Deserialize;

use crate::error::Refusal;

/// Least and greatest zoom factor.
const ZOOM: [f64; 2] = [0.3, 40.0];
/// Least and greatest accepted side of a picture [pixels].
const SIDES: [usize; 2] = [16, 2000];
/// Greatest elevation [°]: seen from straight above, the image has no up direction.
const HIGHEST: f64 = 89.5;

/// Camera parameters that the page controls.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(crate) struct Turn {
    /// Azimuth, from x towards y [°].
    pub(crate) azimuth: f64,
    /// Elevation above the plate [°].
    pub(crate) elevation: f64,
    /// Zoom factor relative to the view that just fits the whole area [1].
    pub(crate) zoom: f64,
    /// Shift of the area to the right, in picture heights [1].
    pub(crate) right: f64,
    /// Shift of the area upwards, in picture heights [1].
    pub(crate) up: f64,
}

impl Turn {
    /// Makes the camera on a scanned area, for a picture of `(width, height)` pixels.
    pub(crate) fn camera(&self, scan: &HeightMap, size: (usize, usize)) -> Camera {
        let (low, high) = bounds(scan);
        self.camera_on(low, high, size)
    }

    /// Makes the camera on a box [m], for a picture of `(width, height)` pixels.
    pub(crate) fn camera_on(&self, low: DVec3, high: DVec3, (width, height): (usize, usize)) -> Camera {
        let aspect = width as f64 / height as f64;
        let sound = |value: f64, usual: f64| if value.is_finite() { value } else { usual };
        let azimuth = sound(self.azimuth, 0.0).to_radians();
        let elevation = sound(self.elevation, HIGHEST).clamp(-HIGHEST, HIGHEST).to_radians();
        let camera = Camera::framing(low, high, azimuth, elevation, aspect);
        let middle = 0.5 * (low + high);
        let zoom = sound(self.zoom, 1.0).clamp(ZOOM[0], ZOOM[1]);
        let eye = middle + (camera.eye - middle) / zoom;
        let depth = (middle - eye).dot(camera.forward);
        let shown = camera.pixel_size(depth, 1);
        let aside =
            DVec2::new(sound(self.right, 0.0), sound(self.up, 0.0)).clamp(DVec2::splat(-5.0), DVec2::splat(5.0));
        Camera { eye: eye - shown * (aside.x * camera.right + aside.y * camera.up), ..camera }
    }
}

/// Size and smoothness of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(crate) struct Size {
    /// Width [pixels].
    pub(crate) width: usize,
    /// Height [pixels].
    pub(crate) height: usize,
    /// True to smooth edges with four samples per pixel, which takes four times as long.
    pub(crate) fine: bool,
}

/// A picture of a part: where it is seen from, and its size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shot {
    /// Camera.
    pub(crate) turn: Turn,
    /// Size.
    pub(crate) size: Size,
}

impl Size {
    /// Refuses pictures that are too large or too small.
    ///
    /// # Errors
    /// The accepted sides.
    pub(crate) fn check(self) -> Result<(), Refusal> {
        let [least, most] = SIDES;
        if (least..=most).contains(&self.width) && (least..=most).contains(&self.height) {
            return Ok(());
        }
        Err(Refusal::wrong(format!("pictures of {least} to {most} pixels along each side are accepted")))
    }
}

/// Returns the bounding box of a scanned area [m].
fn bounds(scan: &HeightMap) -> (DVec3, DVec3) {
    let pixels = scan.pixels;
    let end = pixels.position(pixels.nx - 1, pixels.ny - 1);
    let known = || scan.heights.iter().copied().filter(|height| height.is_finite());
    let (least, most) = (known().fold(f64::INFINITY, f64::min), known().fold(f64::NEG_INFINITY, f64::max));
    let (least, most) = if least <= most { (least, most) } else { (0.0, 0.0) };
    (pixels.origin.extend(least), end.extend(most))
}
