//! Converts the bytes of a mesh file to a [`Mesh`] in metres, z up.
//!
//! Formats: OBJ, STL (ASCII and binary), PLY (ASCII and binary) and glTF (`.glb`, `.gltf`). The format is detected from
//! the content first and from the extension second. Polygons become triangles without overlap, including concave
//! polygons. Only glTF defines the up axis; the other formats are assumed to be z up. No input makes a reader panic, or
//! allocate more than a small multiple of the file's size.
//!
//! Reading repairs nothing: the result is passed to [`crate::clean`], which reports each change.

use std::fmt;
use std::path::Path;

use glam::DVec3;
use serde::Serialize;

use crate::Mesh;

mod announced;
mod bytes;
mod error;
mod gltf;
mod obj;
mod ply;
mod polygon;
mod stl;
mod unit;

pub use bytes::MeshBytes;
use bytes::SiblingFiles;
pub use error::ReadError;
pub use unit::{Unit, UnitChoice};

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Stereolithography, ASCII or binary.
    Stl,
    /// Polygon file format, ASCII or binary.
    Ply,
    /// glTF 2.0, `.glb` or `.gltf`.
    Gltf,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Obj => "OBJ",
            Self::Stl => "STL",
            Self::Ply => "PLY",
            Self::Gltf => "glTF",
        })
    }
}

/// A mesh as read, with the assumptions made.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// The surface in metres, z up; vertices and faces as in the file.
    pub mesh: Mesh,
    /// Format the bytes were read as.
    pub format: Format,
    /// Length of one file unit.
    pub unit: Unit,
    /// Sentence on the unit, its reason, and how to override it.
    pub unit_reason: String,
    /// True if the unit is guessed from the size.
    pub unit_assumed: bool,
    /// True if the unit is guessed from a size near the limit between two units.
    pub unit_doubtful: bool,
    /// Sentences on parts that were ignored or read leniently.
    pub notes: Vec<String>,
}

/// A file's surface in its own units and axes.
#[derive(Default)]
struct Surface {
    mesh: Mesh,
    /// Header or comments, which may name a unit.
    header: String,
    notes: Vec<String>,
    /// Quads that are not flat.
    bent_quads: usize,
}

/// Reads a mesh file; buffers of a `.gltf` are read from the same folder.
pub fn read_mesh(path: &Path, unit: UnitChoice) -> Result<MeshFile, ReadError> {
    MeshBytes::load(path)?.parse(unit)
}

/// Reads a mesh from memory.
///
/// `name` is the file name, which may state the unit. External buffers of a `.gltf` are rejected.
pub fn parse_mesh(bytes: &[u8], format: Format, unit: UnitChoice, name: &str) -> Result<MeshFile, ReadError> {
    parse(bytes, format, unit, &Surroundings { name, beside: &SiblingFiles::new() })
}

/// Inputs to a mesh besides its file's content.
struct Surroundings<'a> {
    /// File name.
    name: &'a str,
    /// Buffers of a `.gltf`.
    beside: &'a SiblingFiles,
}

fn parse(bytes: &[u8], format: Format, choice: UnitChoice, around: &Surroundings) -> Result<MeshFile, ReadError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(ReadError::Empty { name: around.name.into() });
    }
    let Surface { mut mesh, header, mut notes, bent_quads } = match format {
        Format::Obj => obj::read(bytes)?,
        Format::Stl => stl::read(bytes)?,
        Format::Ply => ply::read(bytes)?,
        Format::Gltf => gltf::read(bytes, around.beside)?,
    };
    if bent_quads > 0 {
        let count = if bent_quads == 1 { "1 quad is".into() } else { format!("{bent_quads} quads are") };
        notes.push(format!("{count} not flat: split into four triangles around the mean of the corners"));
    }
    check_finite(&mesh)?;
    if mesh.triangles.is_empty() {
        let left_out = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join("; ")) };
        return Err(ReadError::NoFaces { format, vertices: mesh.positions.len(), left_out });
    }
    let longest = mesh.bounds().map_or(0.0, |(low, high)| (high - low).max_element());
    let decision = unit::decide(choice, &unit::Evidence { format, name: around.name, header: &header, longest });
    let scale = decision.unit.metres();
    for (vertex, position) in mesh.positions.iter_mut().enumerate() {
        let axes = if format == Format::Gltf { y_up_to_z_up(*position) } else { *position };
        *position = axes * scale;
        check_position(vertex, *position)?;
    }
    Ok(MeshFile {
        mesh,
        format,
        unit: decision.unit,
        unit_reason: decision.reason,
        unit_assumed: decision.assumed,
        unit_doubtful: decision.doubtful,
        notes,
    })
}

/// Converts glTF's axes (y up, z towards the viewer) to z up.
fn y_up_to_z_up(p: DVec3) -> DVec3 {
    DVec3::new(p.x, -p.z, p.y)
}

fn check_finite(mesh: &Mesh) -> Result<(), ReadError> {
    mesh.positions.iter().enumerate().try_for_each(|(vertex, &position)| check_position(vertex, position))
}

/// Checks a position; squares of coordinates must also be finite, because lengths use them.
fn check_position(vertex: usize, position: DVec3) -> Result<(), ReadError> {
    if position.length_squared().is_finite() {
        return Ok(());
    }
    Err(ReadError::NonFinite { place: format!("vertex {vertex}"), position })
}

/// Detects the format: by content if that is unambiguous, otherwise by extension.
fn detect_format(bytes: &[u8], name: &str) -> Result<Format, ReadError> {
    let text = bytes.trim_ascii_start();
    if text.is_empty() {
        return Err(ReadError::Empty { name: name.into() });
    }
    let by_content = [
        (Format::Gltf, text.starts_with(b"glTF") || text.starts_with(b"{")),
        (Format::Ply, ply::looks_like(bytes)),
        (Format::Stl, stl::is_binary_of_exact_length(bytes) || stl::looks_ascii(bytes)),
        (Format::Obj, obj::looks_like(bytes)),
    ];
    if let Some(&(format, _)) = by_content.iter().find(|(_, certain)| *certain) {
        return Ok(format);
    }
    let extension = Path::new(name).extension().map(|e| e.to_string_lossy().to_lowercase());
    match extension.as_deref() {
        Some("obj") => Ok(Format::Obj),
        Some("stl") => Ok(Format::Stl),
        Some("ply") => Ok(Format::Ply),
        Some("glb" | "gltf") => Ok(Format::Gltf),
        _ => Err(ReadError::UnknownFormat { name: name.into() }),
    }
}
