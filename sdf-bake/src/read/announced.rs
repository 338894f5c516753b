//! The length that the head of a mesh file announces, compared with the file's before the rest is read.

use super::{Format, ReadError, gltf, obj, ply, stl};

/// First bytes of a file that are looked at: the longest headers are those of PLY files with many comments.
pub(super) const HEAD: usize = 1 << 16;
/// Bytes beyond what is announced that are read in any case, and then left out; more may be as many as are announced.
const PADDING: u64 = 1 << 16;

/// Refuses a file that is shorter than its head announces, or more than twice as long.
pub(super) fn check(head: &[u8], length: u64, name: &str) -> Result<(), ReadError> {
    if head.trim_ascii().is_empty() {
        // Said better once it is read.
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
