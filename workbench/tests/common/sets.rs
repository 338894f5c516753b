//! Small data sets with hostile names, as the program writes them.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};
use serde_json::{Value, json};

/// Name of a part that is markup, with quotes and letters beyond ASCII.
pub const HOSTILE: &str = "<img src=x onerror=alert(1)> 'Ü\".stl";

/// A line of a catalogue of assets.
pub fn row(id: &str, source: &str, length_mm: f64, split: &str) -> Value {
    json!({
        "id": id, "split": split, "difficulty": if length_mm > 50.0 { "hard" } else { "easy" }, "source": source,
        "source_sha256": "0", "index": 0, "licence": "not stated", "seed": 1, "folder": format!("assets/{id}"),
        "requested": {},
        "measured": { "unit": "millimetres", "unit_doubts": [], "voxel_mm": 0.4, "bricks": 10, "checks": {}, "welds": [{
            "id": 1, "joint": "bead-on-plate", "length_mm": length_mm, "width_mm": 5.0, "height_mm": 1.5,
            "volume_mm3": 250.0, "exposure_min": 0.9 - length_mm / 1000.0, "exposure_mean": 0.95, "access_mean": 0.5,
            "geodesic_curvature_rms_per_m": 20.0, "geodesic_curvature_max_per_m": 40.0,
        }] },
        "files": { "preview.png": { "sha256": "0", "bytes": 1_200_000 } },
    })
}

/// Writes a set of assets; items with an odd number have a picture.
pub fn write_assets(folder: &Path, rows: &[Value]) {
    fs::create_dir_all(folder).unwrap();
    fs::write(folder.join("dataset.json"), r#"{"format":"robofin-dataset/1"}"#).unwrap();
    let lines: String = rows.iter().map(|row| format!("{row}\n")).collect();
    fs::write(folder.join("manifest.jsonl"), lines).unwrap();
    let failure = json!({
        "id": "f-0000", "source": HOSTILE, "index": 0, "stage": "weld", "reason": "open surface: <b>623</b> edges",
        "command": "robofin dataset 'x' --item 0 --out again",
    });
    fs::write(folder.join("failures.jsonl"), format!("{failure}\n")).unwrap();
    for (number, row) in rows.iter().enumerate() {
        let item = folder.join("assets").join(row["id"].as_str().unwrap());
        fs::create_dir_all(&item).unwrap();
        if number % 2 == 1 {
            fs::write(item.join("preview.png"), photograph([200, 120, 40])).unwrap();
        }
    }
}

fn png(image: &DynamicImage) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn photograph(colour: [u8; 3]) -> Vec<u8> {
    png(&DynamicImage::ImageRgb8(ImageBuffer::from_pixel(64, 48, Rgb(colour))))
}

/// Labels: background on the left, a class on the right.
fn labels(class: u8) -> Vec<u8> {
    png(&DynamicImage::ImageLuma8(ImageBuffer::from_fn(64, 48, |x, _| Luma([if x < 32 { 0 } else { class }]))))
}

fn depth() -> Vec<u8> {
    png(&DynamicImage::ImageLuma16(ImageBuffer::from_fn(64, 48, |x, y| Luma([(x * y) as u16]))))
}

/// A line of the metadata of a split.
pub fn line(id: &str, workpiece: &str, looks: &Value) -> Value {
    json!({
        "file_name": format!("images/{id}.png"), "id": id, "number": 1, "split": "train", "workpiece": workpiece,
        "placement": 0, "treatment": { "kind": "stage", "pattern": "spiral", "stage": 2 }, "exposed_share": 0.25,
        "agreement": 0.97, "appearance_pixels": [1536, 1000, 500, 36], "dose_pixels": [1536, 1100, 400, 36],
        "appearance": format!("appearance/{id}.png"), "dose": format!("dose/{id}.png"), "view": "views/v.json",
        "instances": "views/v-instances.png", "depth": "views/v-depth.png", "amodal": "views/v-amodal.png",
        "scene": json!({ "looks": looks, "obstacles": [] }).to_string(),
    })
}

/// Writes a set of labelled images in the split for training.
pub fn write_images(folder: &Path, lines: &[Value]) {
    for sub in ["train/images", "appearance", "dose", "views"] {
        fs::create_dir_all(folder.join(sub)).unwrap();
    }
    fs::write(folder.join("dataset.json"), r#"{"format":"robofin-images/3"}"#).unwrap();
    fs::write(folder.join("failures.jsonl"), "").unwrap();
    let text: String = lines.iter().map(|line| format!("{line}\n")).collect();
    fs::write(folder.join("train/metadata.jsonl"), text).unwrap();
    for name in lines.iter().map(|line| format!("{}.png", line["id"].as_str().unwrap())) {
        fs::write(folder.join("train/images").join(&name), photograph([90, 90, 90])).unwrap();
        fs::write(folder.join("appearance").join(&name), labels(1)).unwrap();
        fs::write(folder.join("dose").join(&name), labels(2)).unwrap();
    }
    fs::write(folder.join("views/v-instances.png"), labels(2)).unwrap();
    fs::write(folder.join("views/v-amodal.png"), labels(1)).unwrap();
    fs::write(folder.join("views/v-depth.png"), depth()).unwrap();
}
