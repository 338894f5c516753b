//! Polygon file format: a text header that lists elements and their properties, then their rows (Turk 1994).
//!
//! Of all elements only `vertex` (x, y, z) and `face` (a list of vertex indices) are kept; the others are skipped. The
//! header's counts are compared with the bytes that follow before anything is allocated.

use glam::DVec3;

use super::{Format, ReadError, Surface, polygon};

mod body;
mod header;

use body::Body;
use header::{Element, Header, Kind};

/// True if the bytes start like a PLY file.
pub(super) fn looks_like(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

/// Rejects a file that is too short for the rows counted in its header. A header that is incomplete in `head` is left
/// to [`read`].
pub(super) fn check_length(head: &[u8], length: u64) -> Result<(), ReadError> {
    let Ok((header, rest)) = Header::parse(head) else { return Ok(()) };
    let room = length - (head.len() - rest.len()) as u64;
    header.elements.iter().try_for_each(|element| Body::new(header.encoding, rest).check_room(element, room))
}

pub(super) fn read(bytes: &[u8]) -> Result<Surface, ReadError> {
    let (header, rest) = Header::parse(bytes)?;
    let mut body = Body::new(header.encoding, rest);
    let mut surface = Surface { header: header.comments, ..Default::default() };
    let mut faces = Faces::default();
    for element in &header.elements {
        body.check_room(element, body.room())?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut body, &mut surface)?,
            "face" => read_faces(element, &mut body, &mut faces)?,
            name => {
                (0..element.rows()).try_for_each(|_| body.skip_row(element))?;
                surface.notes.push(format!("left out {} rows of element `{name}`", element.count));
            }
        }
    }
    faces.append_to(&mut surface)?;
    Ok(surface)
}

fn read_vertices(element: &Element, body: &mut Body, surface: &mut Surface) -> Result<(), ReadError> {
    let slots: Vec<Option<usize>> =
        element.properties.iter().map(|p| ["x", "y", "z"].iter().position(|axis| p.name == *axis)).collect();
    if (0..3).any(|axis| !slots.contains(&Some(axis))) {
        return Err(ReadError::malformed(Format::Ply, "element `vertex` needs the properties x, y and z"));
    }
    for _ in 0..element.count {
        let mut position = DVec3::ZERO;
        for (property, slot) in element.properties.iter().zip(&slots) {
            match (property.kind, slot) {
                (Kind::Scalar(scalar), Some(axis)) => position[*axis] = body.scalar(scalar)?,
                _ => body.skip(property.kind)?,
            }
        }
        surface.mesh.positions.push(position);
    }
    Ok(())
}

/// Vertex indices of all faces, stored until the vertices are known.
#[derive(Default)]
struct Faces {
    indices: Vec<f64>,
    arities: Vec<usize>,
}

fn read_faces(element: &Element, body: &mut Body, faces: &mut Faces) -> Result<(), ReadError> {
    let is_corners = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
    if !element.properties.iter().any(|p| is_corners(&p.name)) {
        return Err(ReadError::malformed(Format::Ply, "element `face` needs the list `vertex_indices`"));
    }
    for _ in 0..element.count {
        for property in &element.properties {
            match property.kind {
                Kind::List { count, item } if is_corners(&property.name) => {
                    let arity = body.list_length(count, item)?;
                    for _ in 0..arity {
                        faces.indices.push(body.scalar(item)?);
                    }
                    faces.arities.push(arity);
                }
                kind => body.skip(kind)?,
            }
        }
    }
    Ok(())
}

impl Faces {
    fn append_to(self, surface: &mut Surface) -> Result<(), ReadError> {
        let vertices = surface.mesh.positions.len();
        if let Some(vertex) = surface.mesh.positions.iter().position(|p| !p.is_finite()) {
            let position = surface.mesh.positions[vertex];
            return Err(ReadError::NonFinite { place: format!("vertex {vertex}"), position });
        }
        let in_range = |index: f64| index >= 0.0 && index < vertices as f64 && index.fract() == 0.0;
        if let Some(bad) = self.indices.iter().find(|&&index| !in_range(index)) {
            let reason = format!("a face names vertex {bad}, and there are {vertices}, counted from 0");
            return Err(ReadError::malformed(Format::Ply, reason));
        }
        let mut rest = self.indices.as_slice();
        for arity in self.arities {
            let (face, after) = rest.split_at(arity);
            rest = after;
            polygon::append_face(surface, Format::Ply, face.iter().map(|&index| index as u32))?;
        }
        Ok(())
    }
}
