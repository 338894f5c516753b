//! The float buffers of a frame, read by other programs for OpenEXR.

use std::fs;
use std::path::Path;
use std::process::Command;

use glam::Vec3;
use render::to_exr;
use render::{Frame, VisibleObject};
use serde_json::Value;

use crate::packages::packages;

/// Name and type of the attribute that names a part, each closed by a zero.
const PART_NAME: &[u8] = b"name\0string\0";
/// Bit of the version field for files of several parts (OpenEXR file layout, "Version Field").
const MULTIPART: u8 = 0x10;

/// Makes a frame with a different value in every buffer and pixel.
fn frame() -> Frame {
    let mut frame = Frame::empty(5, 3);
    for pixel in 0..15 {
        let at = pixel as f32;
        frame.colour[pixel] = Vec3::new(0.01 * at, 0.1 * at, 1.0 / (at + 1.0));
        frame.normal[pixel] = Vec3::new(-at, 0.5, 0.25 * at);
        frame.position[pixel] = Vec3::new(1e-4 * at, -2.0, 3e7);
        frame.depth[pixel] = if pixel % 3 > 0 { 0.3 + 1e-6 * at } else { f32::INFINITY };
        frame.dose[pixel] = 0.07 * at;
        frame.removed[pixel] = 1e-5 * at;
        frame.weld[pixel] = 1000 * pixel as u16;
        frame.seen[pixel] = [VisibleObject::Background, VisibleObject::Part, VisibleObject::Table][pixel % 3];
    }
    frame
}

fn digits(values: impl IntoIterator<Item = f32>) -> String {
    values.into_iter().flat_map(f32::to_le_bytes).map(|byte| format!("{byte:02x}")).collect()
}

#[test]
fn the_buffers_are_one_part_without_a_name() {
    let bytes = to_exr(&frame()).expect("a file");
    assert_eq!(bytes[5] & MULTIPART, 0, "version field {:?}", &bytes[4..8]);
    let named = bytes.windows(PART_NAME.len()).any(|window| window == PART_NAME);
    assert!(!named, "the part has a name, which Blender takes for the layer of all channels");
}

#[test]
fn openexr_and_opencv_read_the_buffers_bit_by_bit() {
    let what = "float buffers against OpenEXR and OpenCV";
    let Some(python) = packages("exr-readers", &EXR_READERS, "import cv2, OpenEXR", what) else { return };
    let place = tempfile::tempdir().expect("a temporary folder");
    let (file, frame) = (place.path().join("buffers.exr"), frame());
    fs::write(&file, to_exr(&frame).expect("a file")).expect("written");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/check_exr.py");
    let done = Command::new(python).arg("-B").arg(script).arg(&file).output().expect("Python runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let answer: Value = serde_json::from_slice(&done.stdout).expect("a line of JSON");
    assert_eq!(answer["name"], Value::Null);
    let colour = |axis: usize| digits(frame.colour.iter().map(|colour| colour[axis]));
    assert_eq!(answer["opencv"], serde_json::json!([colour(2), colour(1), colour(0)]), "blue, green, red");
    let along = |vectors: &[Vec3], axis: usize| digits(vectors.iter().map(|vector| vector[axis]));
    let mut expected = vec![
        ("Z".to_owned(), digits(frame.depth.iter().copied())),
        ("dose".to_owned(), digits(frame.dose.iter().copied())),
        ("removed".to_owned(), digits(frame.removed.iter().copied())),
        ("weld".to_owned(), digits(frame.weld.iter().map(|&weld| f32::from(weld)))),
        ("seen".to_owned(), digits(frame.seen.iter().map(|&seen| f32::from(seen as u8)))),
    ];
    for (axis, (colour_name, name)) in [("R", "X"), ("G", "Y"), ("B", "Z")].into_iter().enumerate() {
        expected.push((colour_name.to_owned(), colour(axis)));
        expected.push((format!("normal.{name}"), along(&frame.normal, axis)));
        expected.push((format!("position.{name}"), along(&frame.position, axis)));
    }
    let channels: Value = expected.into_iter().map(|(name, values)| (name, Value::String(values))).collect();
    assert_eq!(answer["channels"], channels);
}

/// Packages that read OpenEXR. The program does not need them, so they are not in `scripts/requirements.txt`.
const EXR_READERS: [&str; 3] = ["OpenEXR==3.5.3", "opencv-python-headless==4.14.0.94", "numpy>=2,<3"];
