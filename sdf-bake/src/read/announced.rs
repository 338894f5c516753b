//! Compares the length that the header of a mesh file announces with the file's before the rest is read.

use super::{Format, ReadError, gltf, obj, ply, stl};

/// Number of first bytes that are examined: the longest headers are those of PLY files with many comments.
pub(super) const HEAD: usize = 1 << 16;
/// Accepted number of bytes beyond the announced length, which are ignored; at least as many as announced are also
/// accepted.
const PADDING: u64 = 1 << 16;

/// Rejects a file that is shorter than its header announces, or more than twice as long.
pub(super) fn check(head: &[u8], length: u64, name: &str) -> Result<(), ReadError> {
    if head.trim_ascii().is_empty() {
        // The parser reports this case more precisely.
        return Ok(());
    }
    let is_stl = || name.to_lowercase().ends_with(".stl") && !stl::looks_ascii(head) && !obj::looks_like(head);
    let (format, announced) = match () {
        () if head.starts_with(b"glTF") => (Format::Gltf, gltf::announced_length(head, length)?),
        () if ply::looks_like(head) => return ply::check_length(head, length),
        () if is_stl() => (Format::Stl, stl::announced_length(head, length)?),
        () => return Ok(()),
    };
    if length > 2 * announced + PADDING {
        let reason = format!("its header announces {announced} bytes, and the file has {length}");
        return Err(ReadError::malformed(format, reason));
    }
    Ok(())
}
