//! STL, PLY and OBJ surfaces as scans: sampled from above at the trial's pixels.

use glam::{DVec2, DVec3};
use sdf_bake::HeightMap;
use sdf_bake::read::{Format as MeshFormat, UnitChoice, parse_mesh};

use super::window::Extent;
use super::{Format, Source, Surface};
use crate::misread::{Misread, Place};

/// First bytes of a PLY file.
const PLY: &[u8] = b"ply";
/// Number of bytes in which a text STL must name its first facet.
const HEAD: usize = 1000;
/// Tolerance for points on an edge to count as inside [share of a triangle].
const ON_EDGE: f64 = 1e-9;

/// STL, PLY and OBJ surfaces.
pub(super) struct Mesh;

impl Format for Mesh {
    fn name(&self) -> &'static str {
        "mesh"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["stl", "ply", "obj"]
    }

    fn recognises(&self, source: &Source) -> bool {
        mesh_format(source).is_some()
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        read(source, mesh_format(source).unwrap_or(MeshFormat::Stl))
    }
}

/// The format of a mesh by its content; by its file name for binary STL and OBJ, which have no signature; `None` for
/// anything else.
fn mesh_format(source: &Source) -> Option<MeshFormat> {
    let named = |extension: &str| source.file.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
    if source.bytes.starts_with(PLY) || named("ply") {
        return Some(MeshFormat::Ply);
    }
    if named("obj") || source.bytes.starts_with(b"mtllib ") || source.bytes.starts_with(b"v ") {
        return Some(MeshFormat::Obj);
    }
    let is_text =
        source.bytes.starts_with(b"solid ") && source.bytes.windows(5).take(HEAD).any(|word| word == b"facet");
    (named("stl") || is_text || has_length_of_stl(source.bytes)).then_some(MeshFormat::Stl)
}

/// True if the file length matches the number of triangles of a binary STL.
fn has_length_of_stl(bytes: &[u8]) -> bool {
    let count = bytes.get(80..84).and_then(|count| count.first_chunk()).map(|count| u32::from_le_bytes(*count));
    count.is_some_and(|count| count > 0 && bytes.len() as u64 == 84 + 50 * u64::from(count))
}

/// Heights of a mesh in millimetres at the pixels of the window: the topmost point at each, missing without a surface.
fn read(source: &Source, format: MeshFormat) -> Result<Surface, Misread> {
    let place = || Place::file(source.file);
    let accepted = "an STL or PLY surface in mm is expected, or an OBJ";
    let found = parse_mesh(source.bytes, format, UnitChoice::Millimetre, &source.file.to_string_lossy());
    let found = found.map_err(|error| place().bad::<Misread>(error.to_string(), accepted))?;
    let positions = &found.mesh.positions;
    let extent = Extent::of(positions.iter().map(|point| point.truncate()), found.mesh.triangles.len() / 2);
    let pixels = extent.pixels(source)?;
    let mut map = HeightMap { pixels, heights: vec![f64::NAN; pixels.len()] };
    for triangle in &found.mesh.triangles {
        cover(&mut map, triangle.map(|corner| positions[corner as usize]));
    }
    if map.missing() == map.heights.len() {
        return Err(extent.beside(source));
    }
    let mut notes = vec![format!("a surface of {} triangles, looked at from above, in mm", found.mesh.triangles.len())];
    notes.extend(found.notes);
    Ok(Surface::on(Mesh.name(), map, notes))
}

/// Raises the pixels under a triangle to its height.
fn cover(map: &mut HeightMap, corners: [DVec3; 3]) {
    let pixels = map.pixels;
    let [a, b, c] = corners.map(|corner| pixels.coordinates(corner.truncate()));
    let doubled_area = (b - a).perp_dot(c - a);
    let low = a.min(b).min(c).ceil().max(DVec2::ZERO);
    let high = a.max(b).max(c).floor().min(DVec2::new(pixels.nx as f64 - 1.0, pixels.ny as f64 - 1.0));
    if doubled_area == 0.0 || !low.cmple(high).all() {
        return;
    }
    for j in low.y as usize..=high.y as usize {
        for i in low.x as usize..=high.x as usize {
            let at = DVec2::new(i as f64, j as f64);
            let shares = [(b, c), (c, a), (a, b)].map(|(p, q)| (p - at).perp_dot(q - at) / doubled_area);
            if shares.iter().all(|share| *share >= -ON_EDGE) {
                let height = shares.iter().zip(corners).map(|(share, corner)| share * corner.z).sum::<f64>();
                let pixel = &mut map.heights[j * pixels.nx + i];
                *pixel = pixel.max(height);
            }
        }
    }
}
