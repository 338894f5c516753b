//! Lens distortion after Brown (1966) and Conrady (1919), in the coefficients that camera calibrations report.

use glam::DVec2;
use shaders::constants::INVERSION_STEPS;

/// Step length at which the inversion stops, at unit distance; far below any visible shift.
const INVERTED: f64 = 1e-11;

/// Distortion of the image plane at unit distance: x to the right, y downwards.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distortion {
    /// Coefficients k₁, k₂, k₃ of r², r⁴ and r⁶; k₁ < 0 for barrel distortion.
    pub radial: [f64; 3],
    /// Coefficients p₁ and p₂ of a decentred or tilted lens.
    pub tangential: [f64; 2],
}

impl Distortion {
    /// True if there is no distortion.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Maps a pinhole's image point to the distorted image.
    pub fn distort(&self, at: DVec2) -> DVec2 {
        at * self.stretch(at) + self.shift(at)
    }

    /// Maps a distorted image point to the pinhole's, by fixed-point iteration (Heikkilä & Silvén 1997).
    pub fn undistort(&self, imaged: DVec2) -> DVec2 {
        if self.is_none() {
            return imaged;
        }
        let mut at = imaged;
        for _ in 0..INVERSION_STEPS {
            let next = (imaged - self.shift(at)) * self.stretch(at).recip();
            let moved = (next - at).abs().max_element();
            at = next;
            if moved < INVERTED {
                break;
            }
        }
        at
    }

    fn stretch(&self, at: DVec2) -> f64 {
        let [k1, k2, k3] = self.radial;
        let r2 = at.length_squared();
        1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    }

    fn shift(&self, at: DVec2) -> DVec2 {
        let [p1, p2] = self.tangential;
        let r2 = at.length_squared();
        let product = 2.0 * at.x * at.y;
        DVec2::new(p1 * product + p2 * (r2 + 2.0 * at.x * at.x), p1 * (r2 + 2.0 * at.y * at.y) + p2 * product)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distortion_is_undone_over_the_whole_image() {
        let lens = Distortion { radial: [-0.21, 0.06, -0.004], tangential: [0.0011, -0.0007] };
        for i in 0..121 {
            let at = DVec2::new(f64::from(i % 11) - 5.0, f64::from(i / 11) - 5.0) * 0.1;
            assert!(lens.undistort(lens.distort(at)).distance(at) < 1e-9, "at {at}");
        }
        assert_eq!(Distortion::default().undistort(DVec2::new(0.3, 0.4)), DVec2::new(0.3, 0.4));
    }

    #[test]
    fn a_barrel_pulls_corners_in_by_the_polynomial() {
        let lens = Distortion { radial: [-0.1, 0.0, 0.0], tangential: [0.0; 2] };
        assert!(lens.distort(DVec2::new(0.5, 0.0)).distance(DVec2::new(0.5 * (1.0 - 0.025), 0.0)) < 1e-15);
    }
}
