//! Members of zip files, read only up to their maximum length.

use std::io::{Cursor, Read};

use files::input::quoted_near;
use zip::ZipArchive;

/// First bytes of a zip.
pub(super) const MAGIC: &[u8] = b"PK\x03\x04";
/// Maximum number of bytes of an XML description.
pub(super) const MOST_XML: u64 = 16 << 20;

/// A zip in memory.
pub(super) struct Archive<'a> {
    zip: ZipArchive<Cursor<&'a [u8]>>,
    /// Names of members that error messages may repeat.
    known: &'static [&'static str],
}

impl<'a> Archive<'a> {
    /// Opens a zip, which may follow other bytes.
    ///
    /// # Errors
    /// A description of the fault.
    pub(super) fn open(bytes: &'a [u8], known: &'static [&'static str]) -> Result<Self, String> {
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(|error| format!("not a readable zip: {error}"))?;
        Ok(Self { zip, known })
    }

    /// Names of the members that are valid UTF-8.
    pub(super) fn names(&self) -> impl Iterator<Item = String> {
        self.zip.file_names().filter_map(|name| Some(name.ok()?.into_owned()))
    }

    /// True if there is a member with this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.zip.index_for_name(name).is_some()
    }

    /// A member's name in the form that an error may repeat.
    pub(super) fn shown(&self, name: &str) -> String {
        quoted_near(name, self.known.iter().copied()).trim_matches('"').to_owned()
    }

    /// The bytes of a member, at most one more than `most`.
    ///
    /// # Errors
    /// A description of the fault.
    pub(super) fn member(&mut self, name: &str, most: u64) -> Result<Vec<u8>, String> {
        let shown = self.shown(name);
        let bad = |error: String| format!("member {shown}: {error}");
        let file = self.zip.by_name(name).map_err(|error| bad(error.to_string()))?;
        let mut bytes = Vec::new();
        file.take(most + 1).read_to_end(&mut bytes).map_err(|error| bad(error.to_string()))?;
        Ok(bytes)
    }

    /// A member that must be text in UTF-8.
    ///
    /// # Errors
    /// A description of the fault.
    pub(super) fn text(&mut self, name: &str) -> Result<String, String> {
        let mut bytes = self.member(name, MOST_XML)?;
        if bytes.starts_with(&[0xef, 0xbb, 0xbf]) {
            bytes.drain(..3);
        }
        String::from_utf8(bytes).map_err(|_| format!("{} is not UTF-8", self.shown(name)))
    }
}
