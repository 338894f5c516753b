//! The header: keys and values between markers.
//!
//! | key | value |
//! |---|---|
//! | 112 | byte order, `High -> Low` where the high byte comes first |
//! | 200, 202 | name and unit of a channel |
//! | 210 | `EXPLIZIT` where values stand in a file, `IMPLIZIT` where they are a start and a step |
//! | 211, 213, 214 | file, `BLOCK` or `CHANNEL`, and type of the numbers |
//! | 220, 221, 222 | number of values, place of the first from 1, bytes before it |
//! | 240, 241 | offset and factor, or start and step |

use std::path::Path;

use crate::log::text::lines;
use crate::log::unit;
use crate::misread::{Misread, Place};

/// Content of a header.
#[derive(Default)]
pub(super) struct Header {
    pub(super) is_big: bool,
    pub(super) channels: Vec<Channel>,
}

/// One channel.
pub(super) struct Channel {
    /// Line of its beginning.
    pub(super) line: u64,
    pub(super) name: String,
    pub(super) unit: Option<String>,
    pub(super) count: usize,
    pub(super) offset: f64,
    pub(super) factor: f64,
    pub(super) storage: Storage,
}

/// Storage of the values.
pub(super) enum Storage {
    /// Not stored: the values are a start and a step.
    Counted,
    /// In a file, from a position that counts from 1.
    File { name: String, number: Number, first: usize, is_block: bool },
}

/// Numerical type.
#[derive(Clone, Copy)]
pub(super) enum Number {
    Real64,
    Real32,
    Int32,
    Int16,
    Word16,
}

/// Keys and values of a section, with their lines.
type Keys<'a> = Vec<(u64, u32, &'a str)>;

impl Header {
    pub(super) fn read(file: &Path, text: &str) -> Result<Self, Misread> {
        let mut header = Self::default();
        let mut section: Option<(u64, Keys)> = None;
        for (number, line) in lines(text) {
            let line = line.trim();
            match line {
                "#BEGINGLOBALHEADER" | "#BEGINCHANNELHEADER" => section = Some((number, Vec::new())),
                "#ENDGLOBALHEADER" => {
                    let keys = section.take().map_or(Vec::new(), |(_, keys)| keys);
                    header.is_big = keys.iter().any(|(_, key, value)| *key == 112 && value.starts_with("High"));
                }
                "#ENDCHANNELHEADER" => {
                    if let Some((start, keys)) = section.take() {
                        header.channels.push(Channel::of(file, start, &keys)?);
                    }
                }
                _ => {
                    let key =
                        line.split_once(',').and_then(|(key, value)| Some((key.trim().parse().ok()?, value.trim())));
                    if let (Some((_, keys)), Some((key, value))) = (&mut section, key) {
                        keys.push((number, key, value));
                    }
                }
            }
        }
        match section {
            Some((start, _)) => {
                Err(Place::line(file, start).bad("a section without its end", "a complete header is expected"))
            }
            None => Ok(header),
        }
    }

    /// Number of channels that are interleaved in a file.
    pub(super) fn channels_in(&self, wanted: &str) -> usize {
        let is_there = |channel: &&Channel| matches!(&channel.storage, Storage::File { name, is_block: true, .. } if name == wanted);
        self.channels.iter().filter(is_there).count()
    }
}

impl Channel {
    fn of(file: &Path, start: u64, keys: &Keys) -> Result<Self, Misread> {
        let find = |wanted: u32| keys.iter().find(|(_, key, _)| *key == wanted).copied();
        let text = |key: u32| find(key).map_or("", |(_, _, value)| value);
        let bad = |key: u32, accepted: &str| {
            let line = find(key).map_or(start, |(line, ..)| line);
            Place::line(file, line)
                .bad::<Misread>(format!("the key {key} is {}", files::input::quoted(text(key))), accepted)
        };
        let number = |key: u32, usual: f64| match text(key) {
            "" => Ok(usual),
            text => text
                .replace(',', ".")
                .parse()
                .ok()
                .filter(|v: &f64| v.is_finite())
                .ok_or_else(|| bad(key, "a number is expected")),
        };
        let whole = |key: u32| text(key).parse::<usize>().map_err(|_| bad(key, "a whole number is expected"));
        let storage = match text(210) {
            "IMPLIZIT" => Storage::Counted,
            "EXPLIZIT" => {
                let number = Number::of(text(214))
                    .ok_or_else(|| bad(214, "REAL64, REAL32, INT32, INT16 or WORD16 is accepted"))?;
                if !matches!(text(213), "BLOCK" | "CHANNEL") {
                    return Err(bad(213, "BLOCK or CHANNEL is accepted"));
                }
                if !matches!(text(222), "" | "0") {
                    return Err(bad(222, "a file of values without a header of its own is accepted"));
                }
                Storage::File { name: text(211).to_owned(), number, first: whole(221)?, is_block: text(213) == "BLOCK" }
            }
            _ => return Err(bad(210, "IMPLIZIT or EXPLIZIT is accepted")),
        };
        let (count, offset, factor) = (whole(220)?, number(240, 0.0)?, number(241, 1.0)?);
        let (name, unit) = (text(200).to_owned(), unit::of_cell(text(202)));
        Ok(Self { line: start, name, unit, count, offset, factor, storage })
    }
}

impl Number {
    fn of(name: &str) -> Option<Self> {
        match name {
            "REAL64" => Some(Self::Real64),
            "REAL32" => Some(Self::Real32),
            "INT32" => Some(Self::Int32),
            "INT16" => Some(Self::Int16),
            "WORD16" => Some(Self::Word16),
            _ => None,
        }
    }

    /// Size of a number [bytes].
    pub(super) fn size(self) -> usize {
        match self {
            Self::Real64 => 8,
            Self::Real32 | Self::Int32 => 4,
            Self::Int16 | Self::Word16 => 2,
        }
    }

    /// Decodes the number at the start of `bytes`, which must be long enough.
    pub(super) fn read(self, bytes: &[u8], is_big: bool) -> f64 {
        let mut own = [0; 8];
        let size = self.size();
        own[..size].copy_from_slice(&bytes[..size]);
        if is_big {
            own[..size].reverse();
        }
        let [a, b, c, d, ..] = own;
        match self {
            Self::Real64 => f64::from_le_bytes(own),
            Self::Real32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::Int32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::Int16 => f64::from(i16::from_le_bytes([a, b])),
            Self::Word16 => f64::from(u16::from_le_bytes([a, b])),
        }
    }
}
