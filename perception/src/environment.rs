//! Light from a picture: an equirectangular Radiance picture as the surroundings of a scene.

use std::io::Cursor;

use glam::{DVec3, Vec3};
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder};
use random::Stream;
use render::EnvironmentMap;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Least and greatest number of rows of a picture [pixels].
pub const ENVIRONMENT_ROWS: [u32; 2] = [8, 8192];

/// Error of a picture that is no surroundings.
#[derive(Debug, Error)]
pub enum EnvironmentError {
    /// Not a Radiance file, or a damaged one.
    #[error("{0}; a picture in the Radiance format (.hdr, RGBE) is accepted")]
    Format(image::ImageError),
    /// Not equirectangular, too small or too large.
    #[error("has {0} x {1} pixels; twice as many columns as rows, from {least} to {most} rows are accepted",
        least = ENVIRONMENT_ROWS[0], most = ENVIRONMENT_ROWS[1])]
    Size(u32, u32),
    /// Black, or a pixel that is not finite.
    #[error("is black or has a pixel that is not finite; a picture with light is accepted")]
    Dark,
}

/// Surroundings of an image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentDraw {
    /// Angle about the vertical by which the picture is turned [rad].
    pub turn: f64,
    /// Luminance of the mean radiance over all directions.
    pub gain: f64,
}

impl EnvironmentDraw {
    /// Draws the surroundings of an image with ambient light from sky, horizon and floor, relative to a bright workshop.
    pub(crate) fn draw(ambient: DVec3, seed: u64) -> Self {
        let turn = Stream::of(seed, "environment").between([0.0, std::f64::consts::TAU]);
        Self { turn, gain: 0.5 * ambient.element_sum() / 3.0 }
    }
}

/// Reads an equirectangular picture in the Radiance format (Ward 1991).
///
/// # Errors
/// [`EnvironmentError`] if it cannot be decoded, is not twice as wide as high, or has no light.
pub fn environment_map(bytes: &[u8]) -> Result<EnvironmentMap, EnvironmentError> {
    let decoder = HdrDecoder::new(Cursor::new(bytes)).map_err(EnvironmentError::Format)?;
    let (columns, rows) = decoder.dimensions();
    if columns != 2 * rows || !(ENVIRONMENT_ROWS[0]..=ENVIRONMENT_ROWS[1]).contains(&rows) {
        return Err(EnvironmentError::Size(columns, rows));
    }
    let picture = DynamicImage::from_decoder(decoder).map_err(EnvironmentError::Format)?.into_rgb32f();
    let pixels = picture.pixels().map(|pixel| Vec3::from_array(pixel.0)).collect();
    EnvironmentMap::new(rows as usize, pixels).ok_or(EnvironmentError::Dark)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Look, Scene, SceneFiles, Seeds, Shape, shoot};
    use image::codecs::hdr::HdrEncoder;

    fn hdr(columns: usize, rows: usize, radiance: impl Fn(usize) -> f32) -> Vec<u8> {
        let mut bytes = Vec::new();
        let pixels: Vec<image::Rgb<f32>> = (0..columns * rows).map(|at| image::Rgb([radiance(at); 3])).collect();
        HdrEncoder::new(&mut bytes).encode(&pixels, columns, rows).unwrap();
        bytes
    }

    #[test]
    fn what_is_no_picture_of_surroundings_is_refused_with_what_is_accepted() {
        let message = |bytes: &[u8]| environment_map(bytes).unwrap_err().to_string();
        assert!(message(b"no picture").contains("Radiance format (.hdr, RGBE) is accepted"));
        let whole = hdr(32, 16, |_| 1.0);
        assert!(message(&whole[..whole.len() / 2]).contains("is accepted"));
        assert!(message(&hdr(20, 16, |_| 1.0)).starts_with("has 20 x 16 pixels; twice as many columns as rows"));
        assert!(message(&hdr(8, 4, |_| 1.0)).contains("from 8 to 8192 rows"));
        assert!(message(&hdr(32, 16, |_| 0.0)).starts_with("is black"));
        assert!(environment_map(&whole).is_ok());
    }

    #[test]
    fn a_picture_lights_the_scene_and_keeps_the_labels_by_dose() {
        let mut part = Shape::Hood.field(2e-3);
        part.dose = vec![0.0; part.phi.len()];
        let draw = || Scene::draw(&part, &Seeds { placement: 1, image: 1 }, (64, 48), &[Look::Studio]).unwrap();
        let plain = shoot(&part, &draw(), (64, 48), &SceneFiles::default()).unwrap();
        let lit = |map: EnvironmentMap| {
            let files = SceneFiles { environment: Some(map), ..SceneFiles::default() };
            shoot(&part, &draw().surrounded(&Seeds { placement: 1, image: 1 }), (64, 48), &files).unwrap()
        };
        let even = lit(environment_map(&hdr(32, 16, |_| 1.0)).unwrap());
        let bright = lit(environment_map(&hdr(32, 16, |at| if at % 32 < 8 { 9.0 } else { 0.1 })).unwrap());
        assert_ne!(plain.image, even.image);
        assert_ne!(even.image, bright.image);
        assert_eq!(plain.dose, bright.dose);
    }
}
