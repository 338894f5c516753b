//! Depth of the metal removed at a visible point, and the scale on which it is drawn.

use glam::{DVec3, Vec3};

use super::camera::Ray;
use super::field::Field;

/// Removed depths below this share of a voxel are rounding errors of the fields.
pub const REMOVED_RESOLUTION: f64 = 0.01;

/// Removed depth [m] at a point of the remaining surface: the distance t > 0 along its unit normal to the original
/// surface, φ_before(x + t n) = 0. Zero where nothing was removed; it may exceed the band many times.
pub fn removed_depth(before: &Field, point: DVec3, normal: Vec3) -> f64 {
    let direction = normal.as_dvec3().normalize_or_zero();
    let depth = before.leaving_distance(&Ray { origin: point, direction });
    if depth > REMOVED_RESOLUTION * before.grid.voxel { depth } else { 0.0 }
}

/// The smallest of 1, 2, 3, 5 or 8 times a power of ten that is not below `value`; 1 for a value that is not positive.
pub fn round_full_scale(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let decade = 10f64.powi(value.log10().floor() as i32);
    // The tolerance keeps 0.3 from becoming 0.5 by rounding.
    let enough = |step: &f64| *step * decade >= value * (1.0 - 1e-6);
    [1.0, 2.0, 3.0, 5.0, 8.0].into_iter().find(enough).unwrap_or(10.0) * decade
}

#[cfg(test)]
mod tests {
    use sdf_bake::BrickGrid;

    use super::*;

    #[test]
    fn a_plane_shifted_by_many_bands_gives_the_shift_exactly() {
        let low = DVec3::new(-0.01, -0.01, -0.01);
        let plane =
            |height: f64, tilt: DVec3| BrickGrid::from_distance(low, -low, 0.0005, 3.0, move |p| p.dot(tilt) - height);
        for tilt in [DVec3::Z, DVec3::new(0.2, -0.3, 0.9).normalize()] {
            for shift in [0.0, 0.00002, 0.0004, 0.0031, 0.0071] {
                let before = plane(0.004, tilt);
                let point = tilt * (0.004 - shift) + DVec3::new(0.0003, 0.0007, 0.0).reject_from(tilt);
                let depth = removed_depth(&Field::new(&before), point, tilt.as_vec3());
                assert!((depth - shift).abs() < 1e-6, "{depth} for {shift} along {tilt}");
            }
            let added = removed_depth(&Field::new(&plane(0.004, tilt)), tilt * 0.0045, tilt.as_vec3());
            assert_eq!(added, 0.0, "metal that was added is not removed");
        }
    }

    #[test]
    fn full_scales_are_round_and_enough() {
        for (value, scale) in [(0.3, 0.3), (0.31, 0.5), (0.00017, 0.0002), (6.0, 8.0), (9.0, 10.0), (0.0, 1.0)] {
            assert!((round_full_scale(value) / scale - 1.0).abs() < 1e-9, "{value}");
        }
        assert_eq!(round_full_scale(f64::NAN), 1.0);
    }
}
