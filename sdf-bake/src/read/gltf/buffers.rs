//! The binary data of a glTF file: its own chunk, data URIs, or files beside it.

use std::path::{Component, Path, PathBuf};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::Document;
use gltf::buffer::Source;

use super::malformed;
use crate::read::ReadError;

/// The bytes of each buffer, at least as many as announced.
pub(super) fn load(
    document: &Document,
    mut blob: Option<Vec<u8>>,
    folder: Option<&Path>,
) -> Result<Vec<Vec<u8>>, ReadError> {
    let mut buffers = Vec::new();
    for buffer in document.buffers() {
        let data = match buffer.source() {
            Source::Bin => blob.take().ok_or_else(|| malformed("the binary chunk is missing"))?,
            Source::Uri(uri) => load_uri(uri, folder)?,
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

fn load_uri(uri: &str, folder: Option<&Path>) -> Result<Vec<u8>, ReadError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let (_, base64) = data.split_once(";base64,").ok_or_else(|| malformed("a data URI is not base64"))?;
        return BASE64_STANDARD.decode(base64).map_err(|error| malformed(format!("a data URI: {error}")));
    }
    let relative = PathBuf::from(percent_decoded(uri));
    let beside = relative.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let Some(folder) = folder.filter(|_| beside && !uri.contains(':')) else {
        return Err(malformed(format!(
            "the buffer `{uri}` is not looked for; files beside the .gltf and data URIs are accepted"
        )));
    };
    let path = folder.join(relative);
    std::fs::read(&path).map_err(|source| ReadError::Io { path, source })
}

/// `%20` and its like as bytes; what is no escape stays.
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
