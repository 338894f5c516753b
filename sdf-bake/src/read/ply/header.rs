//! The header of a PLY file.

use super::{Format, ReadError};
use files::input::{quoted, quoted_line};

/// Encoding of rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Length in a binary file [bytes].
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

impl Element {
    /// Number of rows that occupy bytes in the file.
    pub(super) fn rows(&self) -> u64 {
        if self.properties.is_empty() { 0 } else { self.count }
    }
}

#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    pub(super) comments: String,
}

impl Header {
    /// Splits a file into its header and its rows.
    pub(super) fn parse(bytes: &[u8]) -> Result<(Self, &[u8]), ReadError> {
        let mut encoding = None;
        let mut header = Self { encoding: Encoding::Ascii, elements: Vec::new(), comments: String::new() };
        let mut rest = bytes;
        loop {
            let end = rest.iter().position(|&b| b == b'\n').ok_or_else(|| ReadError::Truncated {
                format: Format::Ply,
                announced: "a header".into(),
                found: "`end_header` is missing".into(),
            })?;
            let line = String::from_utf8_lossy(&rest[..end]);
            rest = &rest[end + 1..];
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["end_header"] => break,
                ["format", name, ..] => encoding = Some(parse_encoding(name)?),
                ["comment" | "obj_info", ..] => {
                    header.comments.push_str(&line);
                    header.comments.push('\n');
                }
                _ => header.add(&words, &line)?,
            }
        }
        header.encoding = encoding.ok_or_else(|| {
            ReadError::malformed(Format::Ply, "the header has no line `format`; ascii or binary is accepted")
        })?;
        Ok((header, rest))
    }

    fn add(&mut self, words: &[&str], line: &str) -> Result<(), ReadError> {
        let bad =
            || ReadError::malformed(Format::Ply, format!("the header line {} is not understood", quoted_line(line)));
        let scalar = |name: &str| Scalar::parse(name).ok_or_else(bad);
        match *words {
            [] | ["ply"] => return Ok(()),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| bad())?;
                self.elements.push(Element { name: name.into(), count, properties: Vec::new() });
                return Ok(());
            }
            _ => {}
        }
        let (name, kind) = match *words {
            ["property", "list", count, item, name] => {
                (name, Kind::List { count: scalar(count)?, item: scalar(item)? })
            }
            ["property", kind, name] => (name, Kind::Scalar(scalar(kind)?)),
            _ => return Err(bad()),
        };
        let element = self.elements.last_mut().ok_or_else(bad)?;
        element.properties.push(Property { name: name.into(), kind });
        Ok(())
    }
}

fn parse_encoding(name: &str) -> Result<Encoding, ReadError> {
    match name {
        "ascii" => Ok(Encoding::Ascii),
        "binary_little_endian" => Ok(Encoding::LittleEndian),
        "binary_big_endian" => Ok(Encoding::BigEndian),
        other => Err(ReadError::malformed(
            Format::Ply,
            format!(
                "format {} is unknown; ascii, binary_little_endian or binary_big_endian is accepted",
                quoted(other)
            ),
        )),
    }
}
