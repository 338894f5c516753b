//! E57 files (ASTM E2807): clouds of points in metres, all scans of a file in its common frame.

use std::io::Cursor;

use e57::{CartesianCoordinate, E57Reader};
use glam::DVec3;

use super::bytes::Bytes;
use super::{Format, MOST_PIXELS, Source, Surface, cloud};
use crate::misread::{Misread, Place};

/// First bytes.
const MAGIC: &[u8] = b"ASTM-E57";
/// Offset of the length of the XML description in the header.
const XML_LENGTH: usize = 32;
/// Maximum number of points per byte of the file: one bit per coordinate, in three axes, is the useful minimum.
const MOST_POINTS_PER_BYTE: usize = 3;
const ACCEPTED: &str = "an E57 file (ASTM E2807) with Cartesian or spherical points is expected";

/// E57 files.
pub(super) struct E57;

impl Format for E57 {
    fn name(&self) -> &'static str {
        "E57"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["e57"]
    }

    fn recognises(&self, source: &Source) -> bool {
        source.bytes.starts_with(MAGIC)
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let bad = |found: String| Place::file(source.file).bad::<Misread>(found, ACCEPTED);
        let (points, notes) = points(source.bytes).map_err(bad)?;
        cloud::mapped(self.name(), &points, source, notes)
    }
}

/// Points [m] of all scans.
fn points(bytes: &[u8]) -> Result<(Vec<DVec3>, Vec<String>), String> {
    let mut header = Bytes::new(bytes);
    header.seek(XML_LENGTH)?;
    let length = u64::from(header.u32()?) | u64::from(header.u32()?) << 32;
    if length > bytes.len() as u64 {
        return Err(format!("a description of {length} bytes in {} bytes", bytes.len()));
    }
    let mut reader = E57Reader::new(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let scans = reader.pointclouds();
    let most = bytes.len().saturating_mul(MOST_POINTS_PER_BYTE).min(MOST_PIXELS);
    let (mut points, mut invalid) = (Vec::new(), 0_usize);
    for scan in &scans {
        let found = reader.pointcloud_simple(scan).map_err(|error| error.to_string())?;
        for point in found {
            match point.map_err(|error| error.to_string())?.cartesian {
                CartesianCoordinate::Valid { x, y, z } if x.is_finite() && y.is_finite() => {
                    points.push(DVec3::new(x, y, z));
                }
                _ => invalid += 1,
            }
            if points.len() + invalid > most {
                return Err(format!("more than {most} points in {} bytes", bytes.len()));
            }
        }
    }
    let mut notes = vec![format!("E57 file: {} points in m, of {} scans", points.len(), scans.len())];
    if invalid > 0 {
        notes.push(format!("{invalid} points are said to be invalid and are left out"));
    }
    Ok((points, notes))
}
