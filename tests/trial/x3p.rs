//! X3P files: every number type of heights, missing pixels, and invalid files.

use std::fs;
use std::io::{Cursor, Write as _};

use sdf_bake::HeightMap;
use trials::trial::{Read, ScanFrame, TrialError, read_heights};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::files::{bead, pixels};

/// Returns `main.xml` in the layout of ISO 25178-72.
fn main_xml(kind: &str, increment: f64, extra: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?><p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\"><Record1><Axes>\
         <CX><AxisType>I</AxisType><DataType>D</DataType><Increment>0.00025</Increment><Offset>0</Offset></CX>\
         <CY><AxisType>I</AxisType><DataType>D</DataType><Increment>0.00025</Increment><Offset>0</Offset></CY>\
         <CZ><AxisType>A</AxisType><DataType>{kind}</DataType><Increment>{increment}</Increment><Offset>0</Offset></CZ>\
         </Axes></Record1><Record3><MatrixDimension><SizeX>61</SizeX><SizeY>33</SizeY><SizeZ>1</SizeZ>\
         </MatrixDimension><DataLink><PointDataLink>bindata/data.bin</PointDataLink>{extra}</DataLink></Record3>\
         </p:ISO5436_2>"
    )
}

fn archive(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in members {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn read(bytes: &[u8]) -> Result<Read<HeightMap>, TrialError> {
    let folder = tempfile::tempdir().unwrap();
    // The format is recognised by content, not by name.
    let file = folder.path().join("scan.dat");
    fs::write(&file, bytes).unwrap();
    read_heights(&file, ScanFrame { origin: Some(pixels().origin), pitch: Some(0.25e-3), ..ScanFrame::default() })
}

fn heights() -> Vec<f64> {
    HeightMap::from_function(pixels(), bead).heights
}

#[test]
fn heights_of_every_type_are_read() {
    let steps = |step: f64| heights().into_iter().map(move |height| (height / step).round());
    let members: [(&str, f64, Vec<u8>); 4] = [
        ("D", 1.0, heights().iter().flat_map(|h| h.to_le_bytes()).collect()),
        ("F", 1.0, heights().iter().flat_map(|&h| (h as f32).to_le_bytes()).collect()),
        ("L", 1e-9, steps(1e-9).flat_map(|h| (h as i32).to_le_bytes()).collect()),
        ("I", 1e-7, steps(1e-7).flat_map(|h| (h as i16).to_le_bytes()).collect()),
    ];
    for (kind, increment, data) in members {
        let xml = main_xml(kind, increment, "");
        let scan = read(&archive(&[("main.xml", xml.as_bytes()), ("bindata/data.bin", &data)])).unwrap();
        assert_eq!(scan.content.pixels, pixels());
        assert!(scan.notes[0].contains("X3P file: 61 x 33 pixels, pitch 250 µm"), "{:?}", scan.notes);
        for (found, exact) in scan.content.heights.iter().zip(heights()) {
            assert!((found - exact).abs() < 0.51e-7, "type {kind}: {found}, {exact}");
        }
    }
}

#[test]
fn pixels_are_missing_where_they_are_nan_or_not_valid() {
    let mut with_nan = heights();
    with_nan[70] = f64::NAN;
    let data: Vec<u8> = with_nan.iter().flat_map(|h| h.to_le_bytes()).collect();
    let mut valid = vec![0xff; (61 * 33usize).div_ceil(8)];
    valid[1] = 0b1111_1110;
    let xml = main_xml("D", 1.0, "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>");
    let members: [(&str, &[u8]); 3] =
        [("main.xml", xml.as_bytes()), ("bindata/data.bin", &data), ("bindata/valid.bin", &valid)];
    let map = read(&archive(&members)).unwrap().content;
    assert_eq!(map.missing(), 2);
    assert!(map.heights[8].is_nan() && map.heights[70].is_nan());
}

#[test]
fn what_is_no_x3p_file_is_refused_with_the_reason() {
    let data: Vec<u8> = heights().iter().flat_map(|h| h.to_le_bytes()).collect();
    let good = main_xml("D", 1.0, "");
    let without = |from: &str, to: &str| good.replace(from, to);
    for (xml, data, words) in [
        (good.clone(), &data[8..], "16096 bytes where the matrix needs 16104"),
        (without("bindata/data.bin", "elsewhere.bin"), &data[..], "member text of 13 characters"),
        (without("<SizeX>61</SizeX>", "<SizeX>99999999999</SizeX>"), &data[..], "a matrix of 99999999999 x 33"),
        (without("<SizeX>61</SizeX>", ""), &data[..], "no Record3/MatrixDimension/SizeX"),
        (without("<DataType>D</DataType><Increment>1<", "<DataType>Q</DataType><Increment>1<"), &data[..], "type"),
        (without("</p:ISO5436_2>", ""), &data[..], "main.xml"),
    ] {
        let error =
            read(&archive(&[("main.xml", xml.as_bytes()), ("bindata/data.bin", data)])).unwrap_err().to_string();
        assert!(error.contains(words) && error.contains("ISO 25178-72"), "{words:?} is missing in: {error}");
    }
    assert!(read(&archive(&[("readme.txt", b"hello")])).unwrap_err().to_string().contains("member main.xml"));
}
