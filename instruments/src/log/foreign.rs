//! Known formats that are not supported, recognised by their first bytes: the error explains how to convert them.

use std::path::Path;

use crate::misread::{Misread, Place};

/// First bytes, name of the format, and how to convert it.
const FOREIGN: [(&[u8], &str, &str); 8] = [
    (b"#ROSBAG V", "a bag of ROS 1", "a bag of ROS 2 is expected; `rosbags-convert` makes one"),
    (b"PK\x03\x04", "a ZIP archive or a workbook of a spreadsheet", "the sheet saved as CSV is expected"),
    (b"\xd0\xcf\x11\xe0", "a workbook of a spreadsheet", "the sheet saved as CSV is expected"),
    (b"\x89HDF", "an HDF5 or MATLAB 7.3 file", "the table saved as CSV is expected"),
    (b"MATLAB 5.0", "a MATLAB file", "the table saved as CSV is expected"),
    (b"\x1f\x8b", "a gzip archive", "the file unpacked is expected"),
    (b"\x28\xb5\x2f\xfd", "packed with Zstandard", "the file unpacked is expected; `zstd -d` does it"),
    (b"TDSm", "a TDMS file", "the table saved as CSV is expected"),
];

/// Refuses a file of a known format that is not supported.
pub(super) fn refuse(file: &Path, bytes: &[u8]) -> Result<(), Misread> {
    match FOREIGN.into_iter().find(|(start, ..)| bytes.starts_with(start)) {
        Some((_, found, accepted)) => Err(Place::file(file).bad(format!("the file is {found}"), accepted)),
        None => Ok(()),
    }
}
