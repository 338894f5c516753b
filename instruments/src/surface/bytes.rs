//! Sequential reading of a file's bytes, with bounds checks.

/// A read position in the bytes of a file. Errors give the position and the number of missing bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    /// Starts at the first byte.
    pub(super) fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// Moves to a byte of the file.
    pub(super) fn seek(&mut self, byte: usize) -> Result<(), String> {
        if byte > self.all.len() {
            return Err(format!("an offset of {byte} bytes in {}", self.all.len()));
        }
        self.at = byte;
        Ok(())
    }

    /// Position of the next byte.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// The remaining bytes.
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.all[self.at..]
    }

    /// The next bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let taken = self.rest().get(..count).ok_or_else(|| {
            format!("byte {}: {count} bytes are needed and {} are left", self.at, self.all.len() - self.at)
        })?;
        self.at += count;
        Ok(taken)
    }

    /// Bytes up to the next zero, which is skipped.
    pub(super) fn until_zero(&mut self) -> Result<&'a [u8], String> {
        let end = self.rest().iter().position(|&c| c == 0);
        let end = end.ok_or_else(|| format!("byte {}: text without an end", self.at))?;
        let text = self.take(end)?;
        self.at += 1;
        Ok(text)
    }

    /// Text of a fixed length in UTF-8 or otherwise Latin-1, padded with zeros or spaces.
    pub(super) fn text(&mut self, count: usize) -> Result<String, String> {
        let bytes = self.take(count)?;
        let end = bytes.iter().position(|&c| c == 0).unwrap_or(count);
        let text = match std::str::from_utf8(&bytes[..end]) {
            Ok(text) => text.to_owned(),
            Err(_) => bytes[..end].iter().map(|&c| char::from(c)).collect(),
        };
        Ok(text.trim().to_owned())
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let bytes = self.take(N)?;
        Ok(*bytes.first_chunk().unwrap_or(&[0; N]))
    }

    pub(super) fn u8(&mut self) -> Result<u8, String> {
        Ok(self.array::<1>()?[0])
    }

    pub(super) fn i16(&mut self) -> Result<i16, String> {
        self.array().map(i16::from_le_bytes)
    }

    pub(super) fn u16(&mut self) -> Result<u16, String> {
        self.array().map(u16::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Result<i32, String> {
        self.array().map(i32::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn f32(&mut self) -> Result<f32, String> {
        self.array().map(f32::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Result<f64, String> {
        self.array().map(f64::from_le_bytes)
    }
}
