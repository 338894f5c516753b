//! Colour map for a scalar: perceptually uniform, with increasing lightness, safe for colour-blind readers.
//!
//! A path through the Oklab space (Ottosson 2020) from indigo through teal to yellow, with the order of hues of viridis
//! (Smith & van der Walt 2015) and cividis (Nuñez, Anderton & Renslow 2018). Lightness rises linearly, and blue to
//! yellow is the one opponent pair that remains in red-green blindness.

use glam::{Mat3, Vec3};

/// Points of the path at equal steps of the value: Oklab lightness, green-red and blue-yellow.
const PATH: [Vec3; 6] = [
    Vec3::new(0.290, 0.050, -0.130),
    Vec3::new(0.414, 0.000, -0.120),
    Vec3::new(0.538, -0.050, -0.070),
    Vec3::new(0.662, -0.100, 0.020),
    Vec3::new(0.786, -0.105, 0.120),
    Vec3::new(0.910, -0.035, 0.180),
];

/// Linear RGB for a value; values outside 0 to 1 take the end's colour.
pub fn colour_map(value: f32) -> Vec3 {
    // The maximum of zero and NaN is zero: NaN takes the first colour.
    let at = value.max(0.0).clamp(0.0, 1.0) * (PATH.len() - 1) as f32;
    let from = (at as usize).min(PATH.len() - 2);
    oklab_to_linear(smooth_path(from, at - from as f32)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Catmull-Rom spline between two points of the path, so that the hue has no visible step.
fn smooth_path(from: usize, t: f32) -> Vec3 {
    let last = PATH.len() - 1;
    let (a, b) = (PATH[from], PATH[from + 1]);
    let before = if from == 0 { 2.0 * a - b } else { PATH[from - 1] };
    let after = if from + 1 == last { 2.0 * b - a } else { PATH[from + 2] };
    let (slope_a, slope_b) = (0.5 * (b - before), 0.5 * (after - a));
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0) + slope_a * (t3 - 2.0 * t2 + t) + b * (3.0 * t2 - 2.0 * t3) + slope_b * (t3 - t2)
}

/// Converts Oklab to linear RGB (Ottosson 2020, "A perceptual color space for image processing").
fn oklab_to_linear(lab: Vec3) -> Vec3 {
    let cone_roots = Mat3::from_cols(
        Vec3::ONE,
        Vec3::new(0.396_337_78, -0.105_561_346, -0.089_484_18),
        Vec3::new(0.215_803_76, -0.063_854_17, -1.291_485_5),
    ) * lab;
    let to_rgb = Mat3::from_cols(
        Vec3::new(4.076_741_7, -1.268_438, -0.004_196_086),
        Vec3::new(-3.307_711_6, 2.609_757_4, -0.703_418_6),
        Vec3::new(0.230_969_94, -0.341_319_4, 1.707_614_7),
    );
    to_rgb * (cone_roots * cone_roots * cone_roots)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness L* (0 to 100) of linear RGB.
    fn lightness(c: Vec3) -> f32 {
        116.0 * c.dot(Vec3::new(0.2126, 0.7152, 0.0722)).cbrt() - 16.0
    }

    /// Colour as perceived by a deuteranope (Viénot, Brettel & Mollon 1999).
    fn deuteranope(c: Vec3) -> Vec3 {
        let yellow = 0.292_75 * c.x + 0.707_25 * c.y;
        Vec3::new(yellow, yellow, -0.022_34 * c.x + 0.022_34 * c.y + c.z)
    }

    #[test]
    fn lightness_rises_evenly_also_for_a_deuteranope() {
        for see in [|c| c, deuteranope] {
            let steps: Vec<f32> = (0..=100).map(|i| lightness(see(colour_map(i as f32 / 100.0)))).collect();
            let mean = (steps[100] - steps[0]) / 100.0;
            assert!(mean > 0.6, "lightness spans {}", 100.0 * mean);
            for (i, pair) in steps.windows(2).enumerate() {
                let step = (pair[1] - pair[0]) / mean;
                assert!(step > 0.5 && step < 1.6, "step {i} is {step} of the mean");
            }
        }
    }

    #[test]
    fn the_path_stays_within_the_screen_s_colours() {
        for i in 0..=200 {
            let at = i as f32 / 40.0;
            let from = (at as usize).min(4);
            let c = oklab_to_linear(smooth_path(from, at - from as f32));
            assert!(c.min_element() > -0.004 && c.max_element() < 1.004, "{c} at {at}");
        }
    }

    #[test]
    fn values_beyond_the_ends_and_nan_have_a_colour() {
        assert_eq!(colour_map(-1.0), colour_map(0.0));
        assert_eq!(colour_map(2.0), colour_map(1.0));
        assert_eq!(colour_map(f32::NAN), colour_map(0.0));
    }
}
