//! Binary STL: triangles in single precision, without shared vertices, for programs that read no glTF.

use sdf_bake::Mesh;

use crate::glb::GENERATOR;

/// Length of the free text at the beginning of a file [bytes].
const HEADER: usize = 80;

/// Writes a mesh in metres; the format states no unit.
pub fn write_stl(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = format!("binary STL by {GENERATOR}, metres, z up").into_bytes();
    bytes.resize(HEADER, b' ');
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for triangle in 0..mesh.triangles.len() {
        let vectors = [mesh.normal(triangle)].into_iter().chain(mesh.corners(triangle));
        bytes.extend(vectors.flat_map(|vector| vector.as_vec3().to_array()).flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}
