//! Encoding of messages: plain CDR of the OMG's Common Object Request Broker Architecture, 9.3, after an RTPS header of
//! four bytes with the byte order.

/// Reads a message from its start.
pub(super) struct Cdr<'a> {
    /// Bytes after the four of the header; alignment counts from there.
    body: &'a [u8],
    at: usize,
    is_little: bool,
}

impl<'a> Cdr<'a> {
    /// Starts a message; the error describes an unsupported header.
    pub(super) fn new(data: &'a [u8]) -> Result<Self, String> {
        match data {
            [0, order @ (0 | 1), _, _, body @ ..] => Ok(Self { body, at: 0, is_little: *order == 1 }),
            [a, b, _, _, ..] => Err(format!("the encoding {a:#04x} {b:#04x}, which is not plain CDR")),
            _ => Err(format!("{} bytes", data.len())),
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let start = self.at.next_multiple_of(N);
        let bytes = self.body.get(start..start + N).and_then(|bytes| bytes.try_into().ok());
        self.at = start + N;
        bytes.ok_or_else(|| format!("it ends after {} bytes", self.body.len()))
    }

    pub(super) fn u32(&mut self) -> Result<u32, String> {
        let bytes = self.take()?;
        Ok(if self.is_little { u32::from_le_bytes(bytes) } else { u32::from_be_bytes(bytes) })
    }

    pub(super) fn f32(&mut self) -> Result<f32, String> {
        self.u32().map(f32::from_bits)
    }

    pub(super) fn f64(&mut self) -> Result<f64, String> {
        let bytes = self.take()?;
        Ok(if self.is_little { f64::from_le_bytes(bytes) } else { f64::from_be_bytes(bytes) })
    }

    pub(super) fn string(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        let bytes = self.at.checked_add(length).and_then(|end| self.body.get(self.at..end));
        let bytes = bytes.ok_or_else(|| format!("a text of {length} bytes"))?;
        self.at += length;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        String::from_utf8(text.to_vec()).map_err(|_| "a text that is not UTF-8".to_owned())
    }

    /// Reads the length of a list whose elements have at least `least` bytes each.
    pub(super) fn length(&mut self, least: usize) -> Result<usize, String> {
        let length = self.u32()? as usize;
        match length.checked_mul(least).is_some_and(|bytes| bytes <= self.body.len().saturating_sub(self.at)) {
            true => Ok(length),
            false => Err(format!("a list of {length} in {} bytes", self.body.len())),
        }
    }

    pub(super) fn numbers(&mut self, is_wide: bool) -> Result<Vec<f64>, String> {
        let length = self.length(if is_wide { 8 } else { 4 })?;
        (0..length).map(|_| if is_wide { self.f64() } else { self.f32().map(f64::from) }).collect()
    }

    /// Checks that only padding is left.
    pub(super) fn finish(self) -> Result<(), String> {
        match self.body.len().saturating_sub(self.at) {
            0..8 => Ok(()),
            rest => Err(format!("{rest} bytes behind its end")),
        }
    }
}
