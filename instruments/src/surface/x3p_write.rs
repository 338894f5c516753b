//! Writing of X3P files (ISO 25178-72): heights as 64-bit numbers in metres, NaN for missing ones.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use md5::{Digest, Md5};
use zip::write::SimpleFileOptions;
use zip::{DateTime, ZipWriter};

use super::Surface;
use super::write::{MapWriteError, pitch_of};

/// Zip member with the heights.
const HEIGHTS: &str = "bindata/data.bin";

/// The bytes of a file.
///
/// # Errors
/// [`MapWriteError`] without a pitch.
pub(super) fn write(surface: &Surface) -> Result<Vec<u8>, MapWriteError> {
    let heights: Vec<u8> = surface.heights.iter().flat_map(|height| height.to_le_bytes()).collect();
    let description = description(surface, &checksum(&heights))?;
    let sums = format!("{} *main.xml\n", checksum(description.as_bytes()).to_lowercase());
    let members = [("main.xml", description.as_bytes()), (HEIGHTS, &heights), ("md5checksum.hex", sums.as_bytes())];
    zipped(&members).map_err(|error| MapWriteError::Zip(error.to_string()))
}

/// A zip of members without time stamps.
fn zipped(members: &[(&str, &[u8])]) -> Result<Vec<u8>, zip::result::ZipError> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().last_modified_time(DateTime::default());
    for (name, bytes) in members {
        zip.start_file(*name, options)?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

/// MD5 in upper-case hexadecimal digits.
fn checksum(bytes: &[u8]) -> String {
    Md5::digest(bytes).iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02X}");
        text
    })
}

/// The `main.xml`; dates, which the schema requires, are the first of January 1970.
fn description(surface: &Surface, checksum: &str) -> Result<String, MapWriteError> {
    let pitch = pitch_of(surface)?;
    let origin = surface.origin.unwrap_or_default();
    let axis = |name: &str, increment: f64, offset: f64| {
        format!(
            "<{name}><AxisType>I</AxisType><DataType>D</DataType><Increment>{increment:e}</Increment>\
             <Offset>{offset:e}</Offset></{name}>"
        )
    };
    Ok(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"no\"?>\n\
         <p:ISO5436_2 xmlns:p=\"http://www.opengps.eu/2008/ISO5436_2\">\n\
         <Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>{cx}{cy}\
         <CZ><AxisType>A</AxisType><DataType>D</DataType><Increment>1</Increment><Offset>0</Offset></CZ>\
         </Axes></Record1>\n\
         <Record2><Date>1970-01-01T00:00:00Z</Date><Instrument><Manufacturer>RoboFin</Manufacturer>\
         <Model>not available</Model><Serial>not available</Serial><Version>not available</Version></Instrument>\
         <CalibrationDate>1970-01-01T00:00:00Z</CalibrationDate><ProbingSystem><Type>Software</Type>\
         <Identification>not available</Identification></ProbingSystem><Comment>RoboFin</Comment></Record2>\n\
         <Record3><MatrixDimension><SizeX>{nx}</SizeX><SizeY>{ny}</SizeY><SizeZ>1</SizeZ></MatrixDimension>\
         <DataLink><PointDataLink>{HEIGHTS}</PointDataLink><MD5ChecksumPointData>{checksum}</MD5ChecksumPointData>\
         </DataLink></Record3>\n\
         <Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>\n\
         </p:ISO5436_2>\n",
        cx = axis("CX", pitch.x, origin.x),
        cy = axis("CY", pitch.y, origin.y),
        nx = surface.nx,
        ny = surface.ny,
    ))
}
