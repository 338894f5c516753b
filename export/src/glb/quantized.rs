//! Surfaces with integer positions and normals, by the extension `KHR_mesh_quantization`.
//!
//! Positions are 16-bit steps of 1/65535 of the longest side of the bounding box; the mesh's node scales and moves them
//! back. The rounding moves a vertex by at most half a step along each axis. Normals have 8 bits a component.

use glam::DVec3;
use gltf_json::accessor::{ComponentType, Type};
use gltf_json::buffer::Target;
use gltf_json::mesh::Primitive;
use gltf_json::{self as json, Index};
use sdf_bake::Mesh;
use serde_json::{Map, Value};

use super::{Array, Glb, GlbPart, GlbWriteError, Materials, asset_extras, check, primitive};
use crate::shading::{CREASE_ANGLE, shade};

/// Name of the extension.
pub(crate) const QUANTIZATION: &str = "KHR_mesh_quantization";
/// Number of steps along the longest axis.
pub(crate) const QUANTIZATION_STEPS: f64 = 65_535.0;

/// The lattice of the stored positions: `low + step * (i, j, k)` [m].
struct Lattice {
    low: DVec3,
    step: f64,
}

/// Writes the pieces of one surface as one mesh of a `.glb` file with 16-bit positions, with a primitive for each piece.
///
/// Equal positions stay equal, so a closed surface is closed again once equal positions are merged. `extras` is written
/// to `asset.extras`, as in [`super::write_glb`].
///
/// # Errors
/// If there are no pieces or no triangles, or a number is beyond single precision.
pub fn write_quantized_glb(
    name: &str,
    pieces: &[GlbPart<'_>],
    extras: Map<String, Value>,
) -> Result<Vec<u8>, GlbWriteError> {
    pieces.iter().try_for_each(check)?;
    let lattice = Lattice::of(pieces).ok_or(GlbWriteError::NoParts)?;
    let mut file = Glb::default();
    let materials = file.push_materials(pieces);
    let primitives =
        pieces.iter().map(|piece| file.push_quantized(piece, &lattice, &materials)).collect::<Result<_, _>>()?;
    let node = file.push_mesh(name, primitives, None);
    let placed = &mut file.root.nodes[node.value()];
    placed.translation = Some(lattice.low.as_vec3().to_array());
    placed.scale = Some([lattice.step as f32; 3]);
    file.root.extensions_used.push(QUANTIZATION.to_owned());
    file.root.extensions_required.push(QUANTIZATION.to_owned());
    file.push_scene(vec![node]);
    file.finish(asset_extras(pieces, extras)?)
}

impl Lattice {
    fn of(pieces: &[GlbPart<'_>]) -> Option<Self> {
        let boxes = pieces.iter().filter_map(|piece| piece.mesh.bounds());
        let (low, high) = boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))?;
        // A surface of one point has no extent; any step then serves.
        let extent = (high - low).max_element();
        Some(Self { low, step: if extent > 0.0 { extent / QUANTIZATION_STEPS } else { 1.0 } })
    }

    /// Returns the mesh with positions counted in steps.
    fn snap(&self, mesh: &Mesh) -> Mesh {
        let snap =
            |p: &DVec3| ((*p - self.low) / self.step).round().clamp(DVec3::ZERO, DVec3::splat(QUANTIZATION_STEPS));
        Mesh { positions: mesh.positions.iter().map(snap).collect(), triangles: mesh.triangles.clone() }
    }
}

impl Glb {
    fn push_quantized(
        &mut self,
        part: &GlbPart<'_>,
        lattice: &Lattice,
        materials: &Materials,
    ) -> Result<Primitive, GlbWriteError> {
        let shaded = shade(&lattice.snap(part.mesh), CREASE_ANGLE);
        if shaded.triangles.is_empty() {
            return Err(GlbWriteError::NoTriangles { part: part.name.to_owned() });
        }
        // Every attribute starts at a multiple of four bytes, so a fourth component pads the three.
        let steps: Vec<[u16; 4]> =
            shaded.positions.iter().map(|p| [p[0] as u16, p[1] as u16, p[2] as u16, 0]).collect();
        let signed = |x: f32| (127.0 * x).round() as i8;
        let normals: Vec<[i8; 4]> =
            shaded.normals.iter().map(|n| [signed(n[0]), signed(n[1]), signed(n[2]), 0]).collect();
        let position = self.push_steps(&steps);
        let normal = self.push_array(Array {
            bytes: bytemuck::cast_slice(&normals),
            stride: Some(4),
            target: Target::ArrayBuffer,
            count: normals.len(),
            component: ComponentType::I8,
            kind: Type::Vec3,
            normalized: true,
            bounds: None,
        });
        let weld_id = self.push_weld_ids(part.weld_id, steps.len());
        let indices = self.push_indices(&shaded.triangles);
        Ok(primitive([position, normal, weld_id, indices], part.material, materials))
    }

    fn push_steps(&mut self, steps: &[[u16; 4]]) -> Index<json::Accessor> {
        let bound = |pick: fn(u16, u16) -> u16| {
            let corner = steps.iter().copied().reduce(|a, b| [0, 1, 2, 3].map(|axis| pick(a[axis], b[axis])));
            Value::from(corner.map_or_else(Vec::new, |corner| corner[..3].to_vec()))
        };
        self.push_array(Array {
            bytes: bytemuck::cast_slice(steps),
            stride: Some(8),
            target: Target::ArrayBuffer,
            count: steps.len(),
            component: ComponentType::U16,
            kind: Type::Vec3,
            normalized: false,
            bounds: Some([bound(u16::min), bound(u16::max)]),
        })
    }
}
