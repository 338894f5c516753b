//! Objects of Gwyddion files: named values, which may be nested objects.

use std::collections::BTreeMap;

use files::input::quoted;

use super::bytes::Bytes;

/// Maximum depth of nested objects; channels are three deep.
const MOST_DEPTH: usize = 16;

/// A named list of named values.
pub(super) struct Object<'a> {
    /// Values by their names.
    pub(super) items: BTreeMap<&'a str, Value<'a>>,
}

/// A value of an object.
pub(super) enum Value<'a> {
    Integer(i32),
    Number(f64),
    Text(&'a str),
    /// Little-endian numbers of 64 bits.
    Numbers(&'a [u8]),
    Object(Object<'a>),
    /// A type that no height map needs.
    Other,
}

impl<'a> Object<'a> {
    /// The object at the start of `bytes`.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self, String> {
        Self::next(&mut Bytes::new(bytes), 0)
    }

    fn next(bytes: &mut Bytes<'a>, depth: usize) -> Result<Self, String> {
        if depth > MOST_DEPTH {
            return Err(format!("byte {}: objects {MOST_DEPTH} deep", bytes.position()));
        }
        bytes.until_zero()?;
        let size = bytes.u32()? as usize;
        let mut inside = Bytes::new(bytes.take(size)?);
        let mut items = BTreeMap::new();
        while !inside.rest().is_empty() {
            let name = std::str::from_utf8(inside.until_zero()?).unwrap_or_default();
            items.insert(name, Value::next(&mut inside, depth)?);
        }
        Ok(Self { items })
    }

    /// The value with this name.
    pub(super) fn get(&self, name: &str) -> Option<&Value<'a>> {
        self.items.get(name)
    }

    /// The object with this name.
    pub(super) fn object(&self, name: &str) -> Option<&Object<'a>> {
        match self.get(name)? {
            Value::Object(object) => Some(object),
            _ => None,
        }
    }

    /// The text with this name.
    pub(super) fn text(&self, name: &str) -> Option<&'a str> {
        match self.get(name)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }
}

impl<'a> Value<'a> {
    fn next(bytes: &mut Bytes<'a>, depth: usize) -> Result<Self, String> {
        let place = bytes.position();
        let kind = bytes.u8()?;
        let mut array = |size: usize| -> Result<&'a [u8], String> {
            let count = bytes.u32()? as usize;
            bytes.take(count.checked_mul(size).ok_or("a list without end")?)
        };
        Ok(match kind {
            b'D' => Self::Numbers(array(8)?),
            b'C' => array(1).map(|_| Self::Other)?,
            b'I' => array(4).map(|_| Self::Other)?,
            b'Q' => array(8).map(|_| Self::Other)?,
            b'b' | b'c' => bytes.take(1).map(|_| Self::Other)?,
            b'q' => bytes.take(8).map(|_| Self::Other)?,
            b'i' => Self::Integer(bytes.i32()?),
            b'd' => Self::Number(bytes.f64()?),
            b's' => Self::Text(std::str::from_utf8(bytes.until_zero()?).unwrap_or_default()),
            b'o' => Self::Object(Object::next(bytes, depth + 1)?),
            b'S' | b'O' => {
                for _ in 0..bytes.u32()? {
                    match kind {
                        b'S' => bytes.until_zero().map(|_| ())?,
                        _ => Object::next(bytes, depth + 1).map(|_| ())?,
                    }
                }
                Self::Other
            }
            other => {
                let shown = quoted(&char::from(other).to_string());
                return Err(format!("byte {place} of an object: a value of type {shown}"));
            }
        })
    }
}
