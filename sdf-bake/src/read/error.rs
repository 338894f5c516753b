//! Errors of reading a mesh file.

use std::path::PathBuf;

use glam::DVec3;

use super::Format;
use files::input::InputError;

/// Reason why a mesh file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("cannot read {path}: {source}")]
    Io {
        /// Requested file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Not a regular file, or one that is too large.
    #[error(transparent)]
    Input(InputError),
    /// An empty file.
    #[error("{name} is empty; an OBJ, STL, PLY, GLB or glTF mesh is accepted")]
    Empty {
        /// File name.
        name: String,
    },
    /// Neither content nor extension identifies the format.
    #[error("{name} is not recognised: neither its content nor its extension is that of OBJ, STL, PLY, GLB or glTF")]
    UnknownFormat {
        /// File name.
        name: String,
    },
    /// The file violates its format.
    #[error("{format} file: {reason}")]
    Malformed {
        /// Format the file was read as.
        format: Format,
        /// Fault found, and what is accepted.
        reason: String,
    },
    /// The file ends before its announced length.
    #[error("{format} file is cut off: it announces {announced}, {found}")]
    Truncated {
        /// Format the file was read as.
        format: Format,
        /// Announced contents.
        announced: String,
        /// Actual contents.
        found: String,
    },
    /// A coordinate is infinite or not a number.
    #[error("{place} is ({}, {}, {}): coordinates must be finite numbers", position.x, position.y, position.z)]
    NonFinite {
        /// Vertex, counted from 0, or line, counted from 1.
        place: String,
        /// The position as read.
        position: DVec3,
    },
    /// Points, lines or nothing, but no surface.
    #[error(
        "{format} file has {vertices} vertices and no faces{left_out}: a surface of triangles or polygons is needed"
    )]
    NoFaces {
        /// Format the file was read as.
        format: Format,
        /// Number of vertices found.
        vertices: usize,
        /// Ignored parts of the file, in brackets; empty if none.
        left_out: String,
    },
}

impl From<InputError> for ReadError {
    fn from(error: InputError) -> Self {
        match error {
            InputError::Io { path, source } => Self::Io { path, source },
            other => Self::Input(other),
        }
    }
}

impl ReadError {
    pub(super) fn malformed(format: Format, reason: impl Into<String>) -> Self {
        Self::Malformed { format, reason: reason.into() }
    }
}
