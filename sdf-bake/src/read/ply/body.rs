//! The rows of a PLY file, ASCII or binary, as a stream of numbers.

use super::header::{Element, Encoding, Kind, Scalar};
use super::{Format, ReadError};
use files::input::quoted;

pub(super) struct Body<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl<'a> Body<'a> {
    pub(super) fn new(encoding: Encoding, rest: &'a [u8]) -> Self {
        Self { encoding, rest }
    }

    /// Number of remaining bytes.
    pub(super) fn room(&self) -> u64 {
        self.rest.len() as u64
    }

    /// Rejects an element whose rows cannot fit into this number of bytes.
    pub(super) fn check_room(&self, element: &Element, room: u64) -> Result<(), ReadError> {
        let smallest: usize = element.properties.iter().map(|p| self.smallest(p.kind)).sum();
        let needed = element.count.saturating_mul(smallest as u64);
        // The last number of an ASCII file needs no space after it.
        if needed <= room + 1 {
            return Ok(());
        }
        Err(ReadError::Truncated {
            format: Format::Ply,
            announced: format!("{} rows of element `{}`", element.count, element.name),
            found: format!("{room} bytes are left for them"),
        })
    }

    /// Least number of bytes of a property.
    fn smallest(&self, kind: Kind) -> usize {
        match (self.encoding, kind) {
            (Encoding::Ascii, _) => 2,
            (_, Kind::Scalar(scalar)) => scalar.size(),
            (_, Kind::List { count, .. }) => count.size(),
        }
    }

    /// Reads the next number.
    pub(super) fn scalar(&mut self, scalar: Scalar) -> Result<f64, ReadError> {
        if self.encoding == Encoding::Ascii {
            return self.word();
        }
        let size = scalar.size();
        let (number, rest) = self.rest.split_at_checked(size).ok_or_else(cut_off)?;
        self.rest = rest;
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(number);
        if self.encoding == Encoding::BigEndian {
            bytes[..size].reverse();
        }
        let [a, b, c, d, ..] = bytes;
        Ok(match scalar {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(bytes),
        })
    }

    fn word(&mut self) -> Result<f64, ReadError> {
        let start = self.rest.trim_ascii_start();
        let end = start.iter().position(u8::is_ascii_whitespace).unwrap_or(start.len());
        let (word, rest) = start.split_at(end);
        self.rest = rest;
        if word.is_empty() {
            return Err(cut_off());
        }
        let text = String::from_utf8_lossy(word);
        text.parse().map_err(|_| {
            ReadError::malformed(Format::Ply, format!("{} stands where a number is expected", quoted(&text)))
        })
    }

    /// Reads the length of a list, and compares it with the remaining bytes.
    pub(super) fn list_length(&mut self, count: Scalar, item: Scalar) -> Result<usize, ReadError> {
        let length = self.scalar(count)?;
        let size = if self.encoding == Encoding::Ascii { 2 } else { item.size() };
        let room = (self.rest.len() + 1) / size;
        if length >= 0.0 && length <= room as f64 && length.fract() == 0.0 {
            return Ok(length as usize);
        }
        Err(ReadError::Truncated {
            format: Format::Ply,
            announced: format!("a list of {length} numbers"),
            found: format!("{} bytes are left for it", self.rest.len()),
        })
    }

    pub(super) fn skip(&mut self, kind: Kind) -> Result<(), ReadError> {
        match kind {
            Kind::Scalar(scalar) => self.scalar(scalar).map(drop),
            Kind::List { count, item } => {
                let length = self.list_length(count, item)?;
                (0..length).try_for_each(|_| self.scalar(item).map(drop))
            }
        }
    }

    pub(super) fn skip_row(&mut self, element: &Element) -> Result<(), ReadError> {
        element.properties.iter().try_for_each(|p| self.skip(p.kind))
    }
}

fn cut_off() -> ReadError {
    ReadError::Truncated {
        format: Format::Ply,
        announced: "more rows in its header".into(),
        found: "the data ends before the last of them".into(),
    }
}
