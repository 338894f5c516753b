//! Reads from untrusted bytes: every access is checked, and errors state its purpose.

use bytemuck::Pod;

use super::error::NvdbError;

/// A view of untrusted bytes.
#[derive(Clone, Copy)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(super) fn len(self) -> u64 {
        self.0.len() as u64
    }

    /// Returns `count` bytes from `at` on.
    pub(super) fn slice(self, what: &'static str, at: u64, count: u64) -> Result<&'a [u8], NvdbError> {
        let end = at.saturating_add(count);
        if end > self.len() {
            return Err(NvdbError::Truncated { what, at, end, length: self.len() });
        }
        Ok(&self.0[at as usize..end as usize])
    }

    /// Reads a plain struct at `at`, whatever its alignment.
    pub(super) fn get<T: Pod>(self, what: &'static str, at: u64) -> Result<T, NvdbError> {
        self.slice(what, at, size_of::<T>() as u64).map(bytemuck::pod_read_unaligned)
    }
}
