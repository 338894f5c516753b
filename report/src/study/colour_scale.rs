//! One signed colour scale for all residual maps of a page: discrete steps, blue below, white within, orange above.

use image::Rgb;

/// Half width of the tolerance band [noise floors].
pub(crate) const BAND_FLOORS: f64 = 3.0;
/// End of the band's inner step, as a share of the band.
const INNER: f64 = 1.0 / 3.0;
/// Greatest number of steps beyond the band; the last one is open.
const MOST_STEPS: usize = 6;
/// Greatest share of all pixels in the open steps.
const OPEN_SHARE: f64 = 0.005;
/// Colour of pixels that were not measured.
pub(crate) const MISSING: Rgb<u8> = Rgb([0xa9, 0xad, 0xb3]);

/// Anchors from white to the strongest colour, in sRGB; distinguishable under all common colour-vision deficiencies.
const BELOW: [[u8; 3]; 5] =
    [[0xff, 0xff, 0xff], [0x9e, 0xc9, 0xe8], [0x4c, 0x94, 0xcb], [0x14, 0x5d, 0xa0], [0x08, 0x2a, 0x54]];
const ABOVE: [[u8; 3]; 5] =
    [[0xff, 0xff, 0xff], [0xfb, 0xc8, 0x8f], [0xee, 0x8a, 0x2c], [0xb5, 0x4f, 0x08], [0x5c, 0x23, 0x04]];

/// Steps of a residual, the same on both sides of zero: one third of the band, the rest of the band, and then steps
/// that each double the bound.
#[derive(Clone, Debug)]
pub struct ColourScale {
    /// Half width of the tolerance band [m].
    pub band: f64,
    /// Upper ends of the steps above zero [m]; the colour is constant beyond the last.
    pub bounds: Vec<f64>,
}

impl ColourScale {
    /// Makes a scale whose closed steps contain all but a few of the residuals [m].
    pub fn new(noise_floor: f64, residuals: impl Iterator<Item = f64>) -> Self {
        let mut sizes: Vec<f64> = residuals.filter(|r| r.is_finite()).map(f64::abs).collect();
        sizes.sort_by(f64::total_cmp);
        let most = sizes.get(((1.0 - OPEN_SHARE) * sizes.len() as f64) as usize).or(sizes.last()).copied();
        let band = BAND_FLOORS * noise_floor;
        let mut bounds = vec![INNER * band, band];
        while bounds.len() < MOST_STEPS + 1 && (bounds.len() < 4 || bounds[bounds.len() - 1] < most.unwrap_or(0.0)) {
            bounds.push(2.0 * bounds[bounds.len() - 1]);
        }
        Self { band, bounds }
    }

    /// Returns the number of steps on one side, including the open one.
    pub fn steps(&self) -> usize {
        self.bounds.len() + 1
    }

    /// Returns the position of a residual [m] on the colour bar, from `-steps` to `steps`; each step has length one.
    pub fn place(&self, residual: f64) -> f64 {
        let size = residual.abs();
        let step = self.bounds.partition_point(|&bound| bound <= size);
        let low = if step == 0 { 0.0 } else { self.bounds[step - 1] };
        // The open step is drawn as if its bound doubled, too.
        let high = self.bounds.get(step).copied().unwrap_or(2.0 * low);
        (step as f64 + ((size - low) / (high - low)).min(0.999)).copysign(residual)
    }

    /// Returns the colour of a residual [m].
    pub fn colour(&self, residual: f64) -> Rgb<u8> {
        if !residual.is_finite() {
            return MISSING;
        }
        let step = self.bounds.partition_point(|&bound| bound <= residual.abs());
        self.step_colour(step, residual < 0.0)
    }

    /// Returns the colour of a step, counted from zero outwards.
    pub fn step_colour(&self, step: usize, below: bool) -> Rgb<u8> {
        let anchors = if below { BELOW } else { ABOVE };
        // Colours within the band are pale.
        let depth = match step {
            0 => 0.06,
            1 => 0.28,
            _ => 0.8 + 3.2 * (step - 2) as f64 / (self.steps() - 3).max(1) as f64,
        };
        let (at, part) = ((depth as usize).min(3), depth - depth.floor().min(3.0));
        Rgb(std::array::from_fn(|c| {
            let (from, to) = (f64::from(anchors[at][c]), f64::from(anchors[at + 1][c]));
            (from + part * (to - from)).round() as u8
        }))
    }
}

/// Formats a colour for CSS.
pub(crate) fn css(Rgb([r, g, b]): Rgb<u8>) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn luminance(Rgb(colour): Rgb<u8>) -> f64 {
        let linear = colour.map(|c| (f64::from(c) / 255.0).powf(2.2));
        0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    }

    #[test]
    fn steps_double_beyond_the_band_until_they_hold_the_residuals() {
        let scale = ColourScale::new(2e-6, [1e-6, -30e-6, 5e-6, f64::NAN].into_iter());
        let micrometres: Vec<f64> = scale.bounds.iter().map(|b| (b * 1e6).round()).collect();
        assert_eq!(micrometres, [2.0, 6.0, 12.0, 24.0, 48.0]);
        assert!((scale.place(9e-6) - 2.5).abs() < 1e-9 && (scale.place(-1e-6) + 0.5).abs() < 1e-9);
        assert!(scale.place(1.0) < 6.0);
    }

    #[test]
    fn colours_darken_outwards_and_the_signs_differ_in_hue() {
        let scale = ColourScale::new(2e-6, [300e-6].into_iter());
        for below in [true, false] {
            let steps: Vec<f64> = (0..scale.steps()).map(|k| luminance(scale.step_colour(k, below))).collect();
            assert!(steps.windows(2).all(|pair| pair[1] < pair[0] - 0.01), "{steps:?}");
        }
        let (Rgb(below), Rgb(above)) = (scale.colour(-40e-6), scale.colour(40e-6));
        assert!(below[2] > below[0] && above[0] > above[2]);
        assert_eq!(scale.colour(f64::NAN), MISSING);
    }
}
