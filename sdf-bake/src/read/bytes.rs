//! All bytes that decide what is read from a mesh file.

use std::collections::BTreeMap;
use std::path::Path;

use super::{Format, MeshFile, ReadError, Unit, UnitChoice, announced, detect_format, gltf, parse, unit};
use files::input::{self, MOST_MESH_BYTES};

/// Files that a `.gltf` names as its buffers, by the name it gives them.
pub(super) type Beside = BTreeMap<String, Vec<u8>>;

/// A mesh file in memory, not parsed yet, with the buffers that lie beside a `.gltf`.
///
/// Parsing looks at nothing else, so these bytes, [`MeshBytes::format`] and, for [`UnitChoice::Auto`],
/// [`MeshBytes::unit_in_name`] tell whether two files give the same mesh. Materials and pictures are never opened.
#[derive(Clone, Debug)]
pub struct MeshBytes {
    name: String,
    format: Format,
    bytes: Vec<u8>,
    beside: Beside,
}

impl MeshBytes {
    /// Reads a mesh file and the buffers it names.
    ///
    /// # Errors
    /// A file that cannot be read, content of no known format, a glTF that names a buffer elsewhere.
    pub fn load(path: &Path) -> Result<Self, ReadError> {
        let name = path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        let bytes = input::read_checked(path, (MOST_MESH_BYTES, announced::HEAD), |head, length| {
            announced::check(head, length, &name)
        })?;
        let format = detect_format(&bytes, &name)?;
        let beside = match (format, path.parent()) {
            (Format::Gltf, Some(folder)) => gltf::load_beside(&bytes, folder)?,
            _ => Beside::new(),
        };
        Ok(Self { name, format, bytes, beside })
    }

    /// Parses the mesh.
    ///
    /// # Errors
    /// What the format's reader refuses.
    pub fn parse(&self, unit: UnitChoice) -> Result<MeshFile, ReadError> {
        parse(&self.bytes, self.format, unit, &super::Surroundings { name: &self.name, beside: &self.beside })
    }

    /// File name without its folder.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The format, from the content or else from the extension.
    pub fn format(&self) -> Format {
        self.format
    }

    /// The file itself.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The buffers beside a `.gltf`, ordered by the names it gives them.
    pub fn buffers(&self) -> impl Iterator<Item = &[u8]> {
        self.beside.values().map(Vec::as_slice)
    }

    /// The unit that the file name states, which [`UnitChoice::Auto`] follows.
    pub fn unit_in_name(&self) -> Option<Unit> {
        unit::stated(&self.name)
    }
}
