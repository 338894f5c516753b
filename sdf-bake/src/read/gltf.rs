//! Reads glTF 2.0, parsed by the `gltf` crate, with bounds-checked access to the buffers.
//!
//! All triangle primitives of the default scene are combined under their nodes' transforms.

use std::borrow::Cow;
use std::path::Path;

use ::gltf as gltf_crate;
use glam::{DMat4, DVec3, Vec4};
use gltf_crate::mesh::Mode;
use gltf_crate::{Document, Gltf, Node, Semantic};

use super::bytes::SiblingFiles;
use super::{Format, ReadError, Surface};
use files::input::without_content;

mod accessor;
mod buffers;

/// Greatest depth of a scene; a deeper one is treated as a cycle.
const MAX_DEPTH: usize = 256;
/// Number of triangles of a scene accepted in any case, plus one per byte of the file, because instances can multiply a
/// small file.
const FREE_TRIANGLES: usize = 4_000_000;

pub(super) fn read(bytes: &[u8], beside: &SiblingFiles) -> Result<Surface, ReadError> {
    let Gltf { document, blob } = open(bytes)?;
    let buffers = buffers::gather(&document, blob.as_deref(), beside)?;
    let most_triangles = FREE_TRIANGLES + bytes.len() + buffers.iter().map(|buffer| buffer.len()).sum::<usize>();
    let seen = vec![false; document.nodes().len()];
    let mut scene = SceneReader { buffers, surface: Surface::default(), seen, most_triangles };
    for node in roots(&document) {
        scene.visit(&node, DMat4::IDENTITY, 0)?;
    }
    Ok(scene.surface)
}

/// Loads the files beside a glTF that it names as its buffers.
pub(super) fn load_beside(bytes: &[u8], folder: &Path) -> Result<SiblingFiles, ReadError> {
    buffers::load_beside(&open(bytes)?.document, folder)
}

fn open(bytes: &[u8]) -> Result<Gltf, ReadError> {
    if bytes.starts_with(b"glTF") {
        announced_length(bytes, bytes.len() as u64)?;
    }
    let invalid = |error| malformed(format!("not valid glTF 2.0: {}", describe(&error)));
    let Gltf { document, blob } = Gltf::from_slice_without_validation(bytes).map_err(invalid)?;
    let root = document.into_json();
    check_position_accessors(&root)?;
    Ok(Gltf { document: Document::from_json(root).map_err(invalid)?, blob })
}

pub(super) fn malformed(reason: impl Into<String>) -> ReadError {
    ReadError::malformed(Format::Gltf, reason)
}

/// Length that the header of a `.glb` announces [bytes]; it must fit the file, otherwise the `gltf` crate underflows.
pub(super) fn announced_length(head: &[u8], file: u64) -> Result<u64, ReadError> {
    let header = head.get(8..12).map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])));
    match header {
        Some(length) if length <= file && length >= 20 => Ok(length),
        Some(length) if length < 20 => {
            Err(malformed(format!("the header says {length} bytes; at least 20 are needed")))
        }
        other => Err(ReadError::Truncated {
            format: Format::Gltf,
            announced: other.map_or("a header of 12 bytes".into(), |length| format!("{length} bytes")),
            found: format!("the file has {file}"),
        }),
    }
}

/// Checks that POSITION accessors exist, because the crate's validation reads their bounds before it checks that.
fn check_position_accessors(root: &gltf_crate::json::Root) -> Result<(), ReadError> {
    let accessors = root.accessors.len();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    match primitives.flat_map(|p| p.attributes.values()).find(|index| index.value() >= accessors) {
        Some(index) => Err(malformed(format!("a primitive names accessor {index}, and there are {accessors}"))),
        None => Ok(()),
    }
}

fn describe(error: &gltf_crate::Error) -> String {
    match error {
        gltf_crate::Error::Validation(list) => {
            list.first().map_or("invalid".into(), |(path, error)| format!("{path}: {error}"))
        }
        other => without_content(&other.to_string()),
    }
}

fn roots(document: &Document) -> Vec<Node<'_>> {
    match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => scene.nodes().collect(),
        None => {
            let mut is_child = vec![false; document.nodes().len()];
            document.nodes().flat_map(|node| node.children()).for_each(|child| is_child[child.index()] = true);
            document.nodes().filter(|node| !is_child[node.index()]).collect()
        }
    }
}

struct SceneReader<'a> {
    buffers: Vec<Cow<'a, [u8]>>,
    surface: Surface,
    seen: Vec<bool>,
    most_triangles: usize,
}

impl SceneReader<'_> {
    fn visit(&mut self, node: &Node, parent: DMat4, depth: usize) -> Result<(), ReadError> {
        if std::mem::replace(&mut self.seen[node.index()], true) || depth > MAX_DEPTH {
            return Err(malformed(format!("node {} has two parents, or nodes are nested too deeply", node.index())));
        }
        let columns = node.transform().matrix().map(|column| Vec4::from_array(column).as_dvec4());
        let local = DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]);
        let world = parent * local;
        if let Some(mesh) = node.mesh() {
            for primitive in mesh.primitives() {
                self.add_primitive(&primitive, world)?;
            }
        }
        node.children().try_for_each(|child| self.visit(&child, world, depth + 1))
    }

    fn add_primitive(&mut self, primitive: &gltf_crate::Primitive, world: DMat4) -> Result<(), ReadError> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.surface.notes.push(format!("left out a primitive of mode {mode:?}"));
            return Ok(());
        }
        let accessor = primitive.get(&Semantic::Positions).ok_or_else(|| malformed("a primitive has no POSITION"))?;
        let positions = accessor::positions(&accessor, &self.buffers)?;
        let corners = match primitive.indices() {
            Some(accessor) => accessor::indices(&accessor, &self.buffers)?,
            None => (0..positions.len() as u32).collect(),
        };
        if let Some(bad) = corners.iter().find(|&&corner| corner as usize >= positions.len()) {
            return Err(malformed(format!("an index names vertex {bad}, and the primitive has {}", positions.len())));
        }
        self.append(&positions, &assemble(mode, &corners), world)
    }

    fn append(&mut self, positions: &[DVec3], triangles: &[[u32; 3]], world: DMat4) -> Result<(), ReadError> {
        let mesh = &mut self.surface.mesh;
        let total = mesh.triangles.len() + triangles.len();
        if total > self.most_triangles || mesh.positions.len() + positions.len() > 3 * self.most_triangles {
            let most = self.most_triangles;
            return Err(malformed(format!(
                "instances make more than the {most} triangles that a file of its size may"
            )));
        }
        let offset = mesh.positions.len() as u32;
        mesh.positions.extend(positions.iter().map(|&p| world.transform_point3(p)));
        let mirrored = world.determinant() < 0.0;
        mesh.triangles.extend(triangles.iter().map(|&[a, b, c]| {
            let corners = if mirrored { [a, c, b] } else { [a, b, c] };
            corners.map(|corner| corner + offset)
        }));
        Ok(())
    }
}

/// Triangles of a list, strip or fan, all with the orientation of the first.
fn assemble(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] };
            corners.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => corners.windows(2).skip(1).map(|w| [corners[0], w[0], w[1]]).collect(),
        _ => corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
