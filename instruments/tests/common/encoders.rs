//! Encoders of formats that no other available program writes, made from public readers.

use std::io::{Cursor, Write};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::{NX, NY, PITCH, height, is_hole};

/// A zip of members.
fn zipped(members: &[(&str, Vec<u8>)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in members {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A value for each pixel, from the top row on.
fn rows<T>(value: impl Fn(usize, usize) -> T) -> Vec<T> {
    (0..NX * NY).map(|at| value(at % NX, NY - 1 - at / NX)).collect()
}

/// All of them, with their file names.
pub fn all() -> [(&'static str, Vec<u8>); 5] {
    [("map.plux", plux()), ("map.vk4", vk4()), ("map.vk6", vk6()), ("map.zon", zon(false)), ("packed.zon", zon(true))]
}

/// A Sensofar PLUX file, heights in micrometres.
pub fn plux() -> Vec<u8> {
    let index = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<xml><GENERAL><DATE>2024-01-02T03:04:05</DATE>\
         <IMAGE_SIZE_X>{NX}</IMAGE_SIZE_X><IMAGE_SIZE_Y>{NY}</IMAGE_SIZE_Y><FOV_X>{}</FOV_X><FOV_Y>{}</FOV_Y>\
         </GENERAL><INFO><ITEM_0><NAME>Device</NAME><VALUE>none</VALUE></ITEM_0></INFO>\
         <LAYER_0><FILENAME_Z>LAYER_0.raw</FILENAME_Z></LAYER_0></xml>",
        PITCH.x * 1e6,
        PITCH.y * 1e6
    );
    let value = |i, j| if is_hole(i, j) { f32::NAN } else { (height(i, j) * 1e6) as f32 };
    let heights = rows(value).iter().flat_map(|height| height.to_le_bytes()).collect();
    zipped(&[("index.xml", index.into_bytes()), ("LAYER_0.raw", heights)])
}

/// A Keyence VK4, heights in steps of 100 pm.
pub fn vk4() -> Vec<u8> {
    const CONDITIONS: u32 = 84;
    const WORDS: u32 = 76;
    const STRINGS: u32 = CONDITIONS + 4 * WORDS;
    const IMAGE: u32 = STRINGS + 8;
    let mut places = [0_u32; 17];
    (places[0], places[6], places[16]) = (CONDITIONS, IMAGE, STRINGS);
    let mut conditions = [0_u32; WORDS as usize];
    conditions[..7].copy_from_slice(&[4 * WORDS, 2024, 1, 2, 3, 4, 5]);
    let size = |metres: f64| (metres * 1e12).round() as u32;
    conditions[42..45].copy_from_slice(&[size(PITCH.x), size(PITCH.y), 100]);
    let (nx, ny) = (NX as u32, NY as u32);
    let image = [nx, ny, 32, 0, nx * ny * 4, 0, 0];
    let mut bytes = b"VK4_\0\0\0\0\0\0\0\0".to_vec();
    let mut put = |words: &[u32]| bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    put(&places);
    put(&[0]);
    put(&conditions);
    // Two empty texts.
    put(&[0, 0]);
    put(&image);
    put(&[0; 192]);
    put(&rows(|i, j| (height(i, j) * 1e10).round() as u32));
    bytes
}

/// A Keyence VK6: a signature, a preview and a zip around a VK4.
pub fn vk6() -> Vec<u8> {
    let mut bytes = b"VK6\0\0\0\0".to_vec();
    bytes.extend(zipped(&[("Vk4File", vk4())]));
    bytes
}

/// A Keyence ZON, heights in steps of 1 nm, its members also compressed with zstd or not.
pub fn zon(packs: bool) -> Vec<u8> {
    let preview = b"BM\x0e\0\0\0\0\0\0\0\0\0\0\0";
    let mut bytes = if packs { b"KPK1".to_vec() } else { b"KPK0".to_vec() };
    bytes.extend((preview.len() as u32).to_le_bytes());
    bytes.extend(preview);
    let head = |size: usize, stride: usize| {
        [NX, NY, size, stride].iter().flat_map(|word| (*word as u32).to_le_bytes()).collect::<Vec<u8>>()
    };
    let mut heights = head(4, 4 * NX);
    heights.extend(rows(|i, j| (height(i, j) * 1e9).round() as i32).iter().flat_map(|step| step.to_le_bytes()));
    // Rows of the states are padded to a multiple of eight bytes and more.
    let mut states = head(1, NX + 8);
    let state = |i, j| if is_hole(i, j) { 1 + (i % 2) as u8 } else { 0 };
    for row in rows(state).chunks(NX) {
        states.extend(row);
        states.extend([0; 8]);
    }
    let sizes = format!(
        "\u{feff}<?xml version=\"1.0\"?><Calibration><XYCalibration><MeterPerPixel>{}</MeterPerPixel></XYCalibration>\
         <ZCalibration><MeterPerUnit>1e-9</MeterPerUnit></ZCalibration></Calibration>",
        PITCH.x
    );
    let scan = "<ScanInformations><ScanDateTime>2024-01-02T03:04:05</ScanDateTime></ScanInformations>";
    let device = "<Device><DeviceModelName>none</DeviceModelName><DeviceSerialId>0</DeviceSerialId></Device>";
    let pack = |bytes: Vec<u8>| match packs {
        true => ruzstd::encoding::compress_to_vec(&bytes[..], ruzstd::encoding::CompressionLevel::Uncompressed),
        false => bytes,
    };
    bytes.extend(zipped(&[
        ("4cdb0c75-5706-48cc-a9a1-adf395d609ae", pack(heights)),
        ("9e7ca6dd-0e6a-4d7b-8986-f0a7b773c916", pack(states)),
        ("686613b8-27b5-4a29-8ffc-438c2780873e", pack(sizes.into_bytes())),
        ("1d35862b-3b48-4df2-9235-833ef590b043", pack(scan.as_bytes().to_vec())),
        ("cbc1d39b-215f-4d56-a20e-cf8e5f570755", pack(device.as_bytes().to_vec())),
    ]));
    bytes
}
