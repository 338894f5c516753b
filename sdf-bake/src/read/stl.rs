//! Stereolithography files: three corners per triangle, without shared vertices.
//!
//! Binary: 80 bytes of header, the number of triangles, then 50 bytes each (3D Systems 1989). Many binary files start
//! with the word `solid`, so the length is tested before that word. File normals are ignored; the order of the corners
//! is used.

use glam::DVec3;

use super::{Format, ReadError, Surface};
use files::input::quoted_line;

const HEADER: usize = 80;
const PREFIX: usize = 84;
const RECORD: usize = 50;

/// True if the length equals the length that the header announces.
pub(super) fn is_binary_of_exact_length(bytes: &[u8]) -> bool {
    announced(bytes).is_some_and(|count| PREFIX as u64 + count * RECORD as u64 == bytes.len() as u64)
}

/// True if it starts like an ASCII file.
pub(super) fn looks_ascii(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let start = &start[..start.len().min(1000)];
    let has = |word: &[u8]| start.windows(word.len()).any(|w| w.eq_ignore_ascii_case(word));
    start.len() >= 5
        && start[..5].eq_ignore_ascii_case(b"solid")
        && (has(b"facet") || has(b"endsolid"))
        && start.iter().all(|&byte| byte != 0)
}

fn announced(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER..PREFIX)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().ok()?)))
}

/// Length that a binary header announces [bytes]; an error if the file is shorter.
pub(super) fn announced_length(head: &[u8], length: u64) -> Result<u64, ReadError> {
    let count = announced(head).ok_or_else(|| ReadError::Truncated {
        format: Format::Stl,
        announced: format!("a binary header of {PREFIX} bytes"),
        found: format!("the file has {length} bytes"),
    })?;
    let present = (length - PREFIX as u64) / RECORD as u64;
    if present < count {
        return Err(ReadError::Truncated {
            format: Format::Stl,
            announced: format!("{count} triangles"),
            found: format!("{length} bytes hold {present} of them"),
        });
    }
    Ok(PREFIX as u64 + count * RECORD as u64)
}

pub(super) fn read(bytes: &[u8]) -> Result<Surface, ReadError> {
    if !is_binary_of_exact_length(bytes) && looks_ascii(bytes) {
        return read_ascii(&String::from_utf8_lossy(bytes));
    }
    let count = (announced_length(bytes, bytes.len() as u64)? as usize - PREFIX) / RECORD;
    let body = &bytes[PREFIX..];
    let mut surface = Surface { header: String::from_utf8_lossy(&bytes[..HEADER]).into_owned(), ..Default::default() };
    let extra = body.len() - count * RECORD;
    if extra > 0 {
        surface.notes.push(format!("left out {extra} bytes after the last triangle"));
    }
    for record in body.chunks_exact(RECORD).take(count) {
        let corner = |i: usize| DVec3::from_array([0, 1, 2].map(|axis| coordinate(record, 12 + 12 * i + 4 * axis)));
        push_triangle(&mut surface, [corner(0), corner(1), corner(2)])?;
    }
    Ok(surface)
}

fn coordinate(record: &[u8], at: usize) -> f64 {
    f64::from(f32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]))
}

fn push_triangle(surface: &mut Surface, corners: [DVec3; 3]) -> Result<(), ReadError> {
    let triangle = surface.mesh.triangles.len();
    if let Some(corner) = corners.iter().position(|p| !p.is_finite()) {
        let place = format!("vertex {} of triangle {triangle}", corner);
        return Err(ReadError::NonFinite { place, position: corners[corner] });
    }
    let first = u32::try_from(surface.mesh.positions.len())
        .ok()
        .filter(|&first| first < u32::MAX - 3)
        .ok_or_else(|| ReadError::malformed(Format::Stl, "more than 1.4 thousand million triangles"))?;
    surface.mesh.positions.extend(corners);
    surface.mesh.triangles.push([first, first + 1, first + 2]);
    Ok(())
}

fn read_ascii(text: &str) -> Result<Surface, ReadError> {
    let header = text.lines().next().unwrap_or("").to_string();
    let mut surface = Surface { header, ..Default::default() };
    let mut corners = Vec::with_capacity(3);
    let mut foreign: Vec<usize> = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let Some(keyword) = words.next().map(str::to_lowercase) else { continue };
        match keyword.as_str() {
            "vertex" => corners.push(ascii_position(words).ok_or_else(|| {
                let found = quoted_line(line);
                let reason = format!("line {}: {found} is not a vertex; `vertex x y z` is accepted", number + 1);
                ReadError::malformed(Format::Stl, reason)
            })?),
            "endloop" | "endfacet" if !corners.is_empty() => {
                let found = corners.len();
                let corners = std::mem::take(&mut corners).try_into().map_err(|_| {
                    let reason = format!("line {}: a facet ends with {found} vertices; 3 are accepted", number + 1);
                    ReadError::malformed(Format::Stl, reason)
                })?;
                push_triangle(&mut surface, corners)?;
            }
            "solid" | "facet" | "outer" | "endloop" | "endfacet" | "endsolid" => {}
            _ => foreign.push(number + 1),
        }
    }
    if let [first, ..] = foreign[..] {
        let note = format!("left out {} lines that are not STL, the first of them line {first}", foreign.len());
        surface.notes.push(note);
    }
    if !corners.is_empty() {
        return Err(ReadError::Truncated {
            format: Format::Stl,
            announced: "a facet".into(),
            found: "the text ends inside it".into(),
        });
    }
    Ok(surface)
}

fn ascii_position<'a>(mut words: impl Iterator<Item = &'a str>) -> Option<DVec3> {
    let mut coordinate = || words.next()?.parse::<f64>().ok();
    Some(DVec3::new(coordinate()?, coordinate()?, coordinate()?))
}
