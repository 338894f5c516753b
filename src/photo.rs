//! Photographs of workpieces as files: pictures, float buffers and a record of their settings.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use png::{BitDepth, ColorType, Encoder};
use render::{Camera, Frame, Photographer, Picture, Projection, Raster, Scene, Sensor, to_exr};
use sdf_bake::BrickGrid;
use serde::Serialize;
use shaders::Device;

use crate::picture::to_png;
use files::output::FolderKind;

/// File that marks a folder of photographs.
pub const RENDER_FILE: &str = "render.json";
/// The folder of photographs.
pub const PHOTOGRAPHS: FolderKind = FolderKind {
    marker: RENDER_FILE,
    key: "samples_per_side",
    names: &[("", &["picture.png", "buffers.exr", "picture-*.png", "animation.png"])],
};
/// Frame rate of an animation [1/s].
const PICTURES_PER_SECOND: u16 = 12;

/// Backend of photographs.
pub enum PhotoBackend<'a> {
    /// CPU.
    Cpu,
    /// GPU.
    Device(Photographer<'a>),
}

impl<'a> PhotoBackend<'a> {
    /// Uses the device, or the CPU without one.
    ///
    /// # Errors
    /// If the driver refuses the kernels.
    pub fn new(device: Option<&'a Device>) -> Result<Self> {
        Ok(match device {
            None => Self::Cpu,
            Some(device) => Self::Device(Photographer::new(device)?),
        })
    }

    /// Photographs one part from the placements and cameras in `shots`; `each` gets the frames in order and may change
    /// them.
    ///
    /// # Errors
    /// Those of the device and of `each`.
    pub fn photograph(
        &self,
        part: &BrickGrid,
        shots: &[(Scene, Camera)],
        raster: &Raster,
        each: &mut dyn FnMut(usize, &mut Frame) -> Result<()>,
    ) -> Result<()> {
        match self {
            Self::Cpu => {
                let mut frame = Frame::empty(0, 0);
                shots.iter().enumerate().try_for_each(|(i, (scene, camera))| {
                    scene.photograph_over(&mut frame, camera, raster);
                    each(i, &mut frame)
                })
            }
            Self::Device(photographer) => {
                let buffers = photographer.load(part)?;
                shots.iter().enumerate().try_for_each(|(i, (scene, camera))| {
                    each(i, &mut photographer.photograph(&buffers, scene, camera, raster)?)
                })
            }
        }
    }
}

/// `render.json`: settings of the pictures in a folder.
#[derive(Serialize)]
pub struct RenderRecord {
    /// Version of the program.
    pub version: &'static str,
    /// Name of the photographed asset or field.
    pub source: String,
    /// Width and height [pixels].
    pub size: [usize; 2],
    /// Colour samples along each side of a pixel.
    pub samples_per_side: usize,
    /// `cpu`, or the device's name.
    pub backend: String,
    /// Sensor.
    pub sensor: SensorRecord,
    /// Records of the pictures.
    pub pictures: Vec<PictureRecord>,
}

/// A sensor in `render.json`.
#[derive(Serialize)]
pub struct SensorRecord {
    exposure: f32,
    blur_px: f32,
    /// Electrons of a saturated pixel; `None` without noise.
    full_well_electrons: Option<f32>,
    read_noise_electrons: f32,
    seed: u64,
}

/// A picture in `render.json`.
#[derive(Serialize)]
pub struct PictureRecord {
    /// File name.
    pub picture: String,
    /// File name of the float buffers, if they were kept.
    pub buffers: Option<String>,
    /// Position, axes and lens of the camera in the scene's frame.
    eye_m: [f64; 3],
    right: [f64; 3],
    up: [f64; 3],
    forward: [f64; 3],
    vertical_field_of_view_deg: Option<f64>,
    /// Distortion k1, k2, p1, p2, k3.
    distortion: [f64; 5],
    /// Placement of the part: rotation as a quaternion x, y, z, w, and translation [m].
    part_rotation_xyzw: [f64; 4],
    part_translation_m: [f64; 3],
}

impl PictureRecord {
    /// Makes the record of one photograph.
    pub fn new(picture: String, buffers: Option<String>, (scene, camera): &(Scene, Camera)) -> Self {
        let ([k1, k2, k3], [p1, p2]) = (camera.distortion.radial, camera.distortion.tangential);
        Self {
            picture,
            buffers,
            eye_m: camera.eye.to_array(),
            right: camera.right.to_array(),
            up: camera.up.to_array(),
            forward: camera.forward.to_array(),
            vertical_field_of_view_deg: match camera.projection {
                Projection::Perspective { vertical_field_of_view } => Some(vertical_field_of_view.to_degrees()),
                Projection::Orthographic { .. } => None,
            },
            distortion: [k1, k2, p1, p2, k3],
            part_rotation_xyzw: scene.placement.rotation.to_array(),
            part_translation_m: scene.placement.translation.to_array(),
        }
    }
}

impl From<&Sensor> for SensorRecord {
    fn from(sensor: &Sensor) -> Self {
        Self {
            exposure: sensor.exposure,
            blur_px: sensor.blur,
            full_well_electrons: sensor.full_well.is_finite().then_some(sensor.full_well),
            read_noise_electrons: sensor.read_noise,
            seed: sensor.seed,
        }
    }
}

/// Writes a frame's picture after the sensor model, and its float buffers before it if `buffers` names a file.
///
/// # Errors
/// If a file cannot be written.
pub fn write_frame(
    folder: &Path,
    frame: &mut Frame,
    sensor: &Sensor,
    (picture, buffers): (&str, Option<&str>),
) -> Result<Picture> {
    if let Some(name) = buffers {
        write(&folder.join(name), &to_exr(frame).context("the frame cannot be written as EXR")?)?;
    }
    sensor.expose(frame);
    let shown = frame.to_srgb8();
    write(&folder.join(picture), &to_png(&shown)?)?;
    Ok(shown)
}

/// Encodes pictures of one size as an endlessly repeating animated PNG.
///
/// # Errors
/// If there are no pictures, or they differ in size.
pub fn to_animated_png(pictures: &[Picture]) -> Result<Vec<u8>> {
    let first = pictures.first().context("an animation has one picture at least")?;
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, first.width as u32, first.height as u32);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let context = "the pictures cannot be written as an animated PNG";
    encoder.set_animated(pictures.len() as u32, 0).context(context)?;
    encoder.set_frame_delay(1, PICTURES_PER_SECOND).context(context)?;
    let mut writer = encoder.write_header().context(context)?;
    for picture in pictures {
        writer.write_image_data(&picture.rgb).context(context)?;
    }
    writer.finish().context(context)?;
    Ok(bytes)
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    fs::write(path, bytes).with_context(|| format!("{}: cannot write this file", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_animation_holds_its_pictures() {
        let picture = |shade: u8| Picture::filled(7, 5, [shade, 10, 200]);
        let pictures: Vec<Picture> = (0..4).map(|i| picture(60 * i)).collect();
        let bytes = to_animated_png(&pictures).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 4);
        for picture in &pictures {
            let mut rgb = vec![0; 7 * 5 * 3];
            reader.next_frame(&mut rgb).unwrap();
            assert_eq!(rgb, picture.rgb);
        }
        assert!(to_animated_png(&[]).is_err());
    }
}
