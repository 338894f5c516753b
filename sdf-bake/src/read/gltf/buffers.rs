//! The binary data of a glTF file: its own chunk, data URIs, or separate files.

use std::borrow::Cow;
use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::Document;
use gltf::buffer::Source;

use super::malformed;
use crate::read::ReadError;
use crate::read::bytes::SiblingFiles;
use files::input::{self, MOST_MESH_BYTES, measured};

/// Reads the files that a document names as its buffers, each once.
pub(super) fn load_beside(document: &Document, folder: &Path) -> Result<SiblingFiles, ReadError> {
    let mut beside = SiblingFiles::new();
    for buffer in document.buffers() {
        let Source::Uri(uri) = buffer.source() else { continue };
        if uri.starts_with("data:") || beside.contains_key(uri) {
            continue;
        }
        let relative = PathBuf::from(percent_decoded(uri));
        let stays = relative.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
        if !stays || uri.contains(':') {
            return Err(not_looked_for(uri));
        }
        let path = folder.join(relative);
        let real = path.canonicalize().ok().zip(folder_of(folder).canonicalize().ok());
        if real.is_some_and(|(file, folder)| !file.starts_with(folder)) {
            return Err(not_looked_for(uri));
        }
        let bytes = input::read(&path, MOST_MESH_BYTES)?;
        beside.insert(uri.to_owned(), bytes);
    }
    Ok(beside)
}

/// Folder to open; `.` for a relative file, whose folder is empty.
fn folder_of(folder: &Path) -> &Path {
    if folder.as_os_str().is_empty() { Path::new(".") } else { folder }
}

/// Returns the bytes of each buffer, at least as many as announced.
pub(super) fn gather<'a>(
    document: &Document,
    mut blob: Option<&'a [u8]>,
    beside: &'a SiblingFiles,
) -> Result<Vec<Cow<'a, [u8]>>, ReadError> {
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let data: Cow<[u8]> = match buffer.source() {
            Source::Bin => blob.take().ok_or_else(|| malformed("the binary chunk is missing"))?.into(),
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => from_data_uri(data)?.into(),
                None => beside.get(uri).ok_or_else(|| not_looked_for(uri))?.into(),
            },
        };
        if data.len() < buffer.length() {
            return Err(ReadError::Truncated {
                format: crate::read::Format::Gltf,
                announced: format!("{} bytes in buffer {}", buffer.length(), buffer.index()),
                found: format!("{} are there", data.len()),
            });
        }
        buffers.push(data);
    }
    Ok(buffers)
}

fn from_data_uri(data: &str) -> Result<Vec<u8>, ReadError> {
    let (_, base64) = data.split_once(";base64,").ok_or_else(|| malformed("a data URI is not base64"))?;
    BASE64_STANDARD.decode(base64).map_err(|error| malformed(format!("a data URI: {error}")))
}

fn not_looked_for(uri: &str) -> ReadError {
    malformed(format!("the buffer {} is not read; files beside the .gltf and data URIs are accepted", measured(uri)))
}

/// Decodes escapes such as `%20`; other text is unchanged.
fn percent_decoded(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&first, after)) = rest.split_first() {
        let escape = after.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        let code = escape.filter(|_| first == b'%').and_then(|hex| u8::from_str_radix(hex, 16).ok());
        bytes.push(code.unwrap_or(first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
