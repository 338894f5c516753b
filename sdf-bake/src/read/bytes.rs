//! All bytes that determine a mesh.

use std::collections::BTreeMap;
use std::path::Path;

use super::{Format, MeshFile, ReadError, Unit, UnitChoice, announced, detect_format, gltf, parse, unit};
use files::input::{self, MOST_MESH_BYTES};

/// Files that a `.gltf` names as its buffers, by the name used there.
pub(super) type SiblingFiles = BTreeMap<String, Vec<u8>>;

/// An unparsed mesh file in memory, with the buffers beside a `.gltf`.
///
/// Parsing uses nothing else. So two files give the same mesh if these bytes, [`MeshBytes::format`] and, for
/// [`UnitChoice::Auto`], [`MeshBytes::unit_in_name`] are equal. Materials and textures are never opened.
#[derive(Clone, Debug)]
pub struct MeshBytes {
    name: String,
    format: Format,
    bytes: Vec<u8>,
    beside: SiblingFiles,
}

impl MeshBytes {
    /// Reads a mesh file and the buffers that it names.
    ///
    /// # Errors
    /// A file that cannot be read, content of no known format, or a glTF that names a buffer in another folder.
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        let name = path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        let bytes = input::read_checked(path, (MOST_MESH_BYTES, announced::HEAD), |head, length| {
            announced::check(head, length, &name)
        })?;
        let format = detect_format(&bytes, &name)?;
        let beside = match (format, path.parent()) {
            (Format::Gltf, Some(folder)) => gltf::load_beside(&bytes, folder)?,
            _ => SiblingFiles::new(),
        };
        Ok(Self { name, format, bytes, beside })
    }

    /// Parses the mesh.
    ///
    /// # Errors
    /// Any fault that the format's reader finds.
    pub fn parse(&self, unit: UnitChoice) -> Result<MeshFile, ReadError> {
        parse(&self.bytes, self.format, unit, &super::Surroundings { name: &self.name, beside: &self.beside })
    }

    /// File name without folder.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Format, from the content or otherwise from the extension.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Buffers beside a `.gltf`, ordered by the names used there.
    pub fn buffers(&self) -> impl Iterator<Item = &[u8]> {
        self.beside.values().map(Vec::as_slice)
    }

    /// Unit stated in the file name, which [`UnitChoice::Auto`] follows.
    pub fn unit_in_name(&self) -> Option<Unit> {
        unit::stated(&self.name)
    }
}
