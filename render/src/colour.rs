//! Conversion between linear light and the codes of an image file.

use glam::Vec3;

/// Returns the eight-bit sRGB code (IEC 61966-2-1) of linear RGB; values outside 0 to 1 are clipped.
pub fn to_srgb8(linear: Vec3) -> [u8; 3] {
    linear.to_array().map(|c| (255.0 * encode(c) + 0.5) as u8)
}

/// Returns the linear RGB of an eight-bit sRGB code.
pub fn from_srgb8(code: [u8; 3]) -> Vec3 {
    Vec3::from(code.map(|c| decode(f32::from(c) / 255.0)))
}

fn encode(linear: f32) -> f32 {
    // The maximum of zero and NaN is zero: NaN becomes black.
    let c = linear.max(0.0).clamp(0.0, 1.0);
    if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
}

fn decode(code: f32) -> f32 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_codes_come_back() {
        for code in 0..=255 {
            assert_eq!(to_srgb8(from_srgb8([code; 3])), [code; 3]);
        }
        assert_eq!(to_srgb8(Vec3::new(f32::NAN, -1.0, 7.0)), [0, 0, 255]);
    }
}
