//! TIFF images of one channel whose heights have a stated unit.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

use super::tiff_scale::Statement;
use super::{Format, Source, Surface, missing, shape};
use crate::misread::{Misread, Place};

const ACCEPTED: &str = "an image of one channel of heights whose ImageDescription states their unit is expected, \
                        as z_unit=um, and z_scale=0.01 where a step is not one unit";
/// Maximum compression ratio of TIFF's compressions.
const MOST_PACKED: usize = 1100;
/// Maximum number of bytes of a tag.
const MOST_TAG: usize = 1 << 20;

/// TIFF images.
pub(super) struct Tiff;

impl Format for Tiff {
    fn name(&self) -> &'static str {
        "TIFF"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["tif", "tiff"]
    }

    fn recognises(&self, source: &Source) -> bool {
        let marks: [&[u8]; 4] = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];
        marks.iter().any(|mark| source.bytes.starts_with(mark))
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        read(source.bytes).map_err(|found| Place::file(source.file).bad(found, ACCEPTED))
    }
}

fn read(bytes: &[u8]) -> Result<Surface, String> {
    let said = |error: tiff::TiffError| error.to_string();
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(said)?;
    let is_plain = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(said)?.unwrap_or(1) == 1;
    let mut decoder = decoder.with_limits(limits(bytes.len(), is_plain));
    let (width, height) = decoder.dimensions().map_err(said)?;
    let (nx, ny) = shape::checked(width.into(), height.into())?;
    let statement = Statement::of(&mut decoder)?;
    let orientation = decoder.find_tag_unsigned::<u16>(Tag::Orientation).map_err(said)?.unwrap_or(1);
    let mut heights = numbers(decoder.read_image().map_err(said)?)?;
    if heights.len() != nx * ny {
        return Err(format!("{} numbers for {nx} x {ny} pixels", heights.len()));
    }
    let mut notes = vec![format!("TIFF image: {nx} x {ny} pixels; {}", statement.said())];
    let strange = heights.iter_mut().filter(|height| !height.is_finite());
    let count = strange.map(|height| *height = f64::NAN).count();
    if count > 0 {
        notes.push(missing::said(count, "NaN or infinity"));
    }
    notes.extend(missing::clear(&mut heights, None));
    heights.iter_mut().for_each(|height| *height = *height * statement.step + statement.offset);
    match orientation {
        1 => heights = shape::turned(heights, nx),
        // The first row is at the bottom.
        4 => {}
        other => return Err(format!("an image with orientation {other}")),
    }
    Ok(Surface { format: Tiff.name(), nx, ny, pitch: statement.pitch, origin: None, heights, notes })
}

/// Maximum number of bytes of a decoded image, for a file of a length.
fn limits(length: usize, is_plain: bool) -> Limits {
    let mut limits = Limits::default();
    let most = if is_plain { length } else { length.saturating_mul(MOST_PACKED) };
    limits.decoding_buffer_size = most.min(super::MOST_PIXELS * 8);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    limits.ifd_value_size = MOST_TAG.min(length);
    limits
}

/// The numbers of an image.
fn numbers(image: DecodingResult) -> Result<Vec<f64>, String> {
    Ok(match image {
        DecodingResult::U8(_) => return Err("8 bits for each pixel, as in a photograph".to_owned()),
        DecodingResult::U16(numbers) => numbers.into_iter().map(f64::from).collect(),
        DecodingResult::U32(numbers) => numbers.into_iter().map(f64::from).collect(),
        DecodingResult::U64(numbers) => numbers.into_iter().map(|number| number as f64).collect(),
        DecodingResult::F16(numbers) => numbers.into_iter().map(|number| number.to_f64()).collect(),
        DecodingResult::F32(numbers) => numbers.into_iter().map(f64::from).collect(),
        DecodingResult::F64(numbers) => numbers,
        DecodingResult::I8(numbers) => numbers.into_iter().map(f64::from).collect(),
        DecodingResult::I16(numbers) => numbers.into_iter().map(f64::from).collect(),
        DecodingResult::I32(numbers) => numbers.into_iter().map(f64::from).collect(),
        DecodingResult::I64(numbers) => numbers.into_iter().map(|number| number as f64).collect(),
    })
}
