//! Small meshes and files made in the tests.
#![allow(dead_code, reason = "each test program uses some of them")]

use glam::DVec3;
use sdf_bake::Mesh;

/// Corners of each triangle of [`cube`].
pub(crate) const CUBE: [[u32; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

/// A cube with outward triangles; the bits of i give the position of corner i.
pub(crate) fn cube(low: DVec3, side: f64) -> Mesh {
    let bit = |i: u32, axis: u32| f64::from(i >> axis & 1);
    Mesh {
        positions: (0..8).map(|i| low + side * DVec3::new(bit(i, 0), bit(i, 1), bit(i, 2))).collect(),
        triangles: CUBE.to_vec(),
    }
}

pub(crate) fn obj(mesh: &Mesh) -> String {
    let vertices = mesh.positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    vertices.chain(faces).collect()
}

pub(crate) fn stl_binary(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = b"solid written as binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for t in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        let numbers = mesh.corners(t).into_iter().flat_map(|p| p.as_vec3().to_array());
        bytes.extend(numbers.flat_map(f32::to_le_bytes));
        bytes.extend([0; 2]);
    }
    bytes
}

pub(crate) fn stl_ascii(mesh: &Mesh) -> String {
    let mut text = String::from("solid part\n");
    for t in 0..mesh.triangles.len() {
        text += " facet normal 0 0 0\n  outer loop\n";
        mesh.corners(t).iter().for_each(|p| text += &format!("   vertex {:e} {} {}\n", p.x, p.y, p.z));
        text += "  endloop\n endfacet\n";
    }
    text + "endsolid part\n"
}

/// A PLY file with an extra vertex property, an extra element, and triangles or quads.
pub(crate) fn ply(mesh: &Mesh, encoding: &str, faces: &[Vec<u32>]) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat {encoding} 1.0\ncomment made by a test\nelement vertex {}\nproperty float x\nproperty double y\n\
         property float z\nproperty uchar red\nelement tag 2\nproperty list uchar short w\nelement face {}\n\
         property list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        faces.len()
    )
    .into_bytes();
    let mut put = |text: String, mut number: Vec<u8>| match encoding {
        "ascii" => bytes.extend(format!("{text}\n").bytes()),
        "binary_big_endian" => {
            number.reverse();
            bytes.extend(number);
        }
        _ => bytes.extend(number),
    };
    for p in &mesh.positions {
        put(p.x.to_string(), (p.x as f32).to_le_bytes().to_vec());
        put(p.y.to_string(), p.y.to_le_bytes().to_vec());
        put(p.z.to_string(), (p.z as f32).to_le_bytes().to_vec());
        put("200".into(), vec![200]);
    }
    for _ in 0..2 {
        put("1".into(), vec![1]);
        put("-7".into(), (-7i16).to_le_bytes().to_vec());
    }
    for face in faces {
        put(face.len().to_string(), vec![face.len() as u8]);
        face.iter().for_each(|&v| put(v.to_string(), v.to_le_bytes().to_vec()));
    }
    bytes
}

/// Positions as 32-bit floats, then indices as 16-bit integers.
pub(crate) fn gltf_buffer(positions: &[DVec3], indices: &[u32]) -> Vec<u8> {
    let numbers = positions.iter().flat_map(|p| p.as_vec3().to_array()).flat_map(f32::to_le_bytes);
    let mut bytes: Vec<u8> = numbers.chain(indices.iter().flat_map(|&i| (i as u16).to_le_bytes())).collect();
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

/// JSON of a glTF with one primitive; `buffer` holds the buffer's fields besides the length, `node` the root's fields.
pub(crate) fn gltf_json(positions: usize, indices: usize, buffer: &str, primitive: &str, node: &str) -> String {
    let split = 12 * positions;
    let length = (split + 2 * indices).next_multiple_of(4);
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{{node}"children":[1]}},{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}{primitive}}}]}}],"buffers":[{{{buffer}"byteLength":{length}}}],
"bufferViews":[{{"buffer":0,"byteLength":{split}}},{{"buffer":0,"byteOffset":{split},"byteLength":{}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{positions},"type":"VEC3","min":[0,0,0],"max":[1,1,1]}},
{{"bufferView":1,"componentType":5123,"count":{indices},"type":"SCALAR"}}]}}"#,
        2 * indices
    )
}

pub(crate) fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut bytes = b"glTF".to_vec();
    bytes.extend([2, length as u32, json.len() as u32].into_iter().flat_map(u32::to_le_bytes));
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

/// A cube of 1 m as `.glb`.
pub(crate) fn cube_glb(node: &str) -> Vec<u8> {
    let mesh = cube(DVec3::ZERO, 1.0);
    let indices: Vec<u32> = mesh.triangles.concat();
    glb(&gltf_json(8, 36, "", r#","indices":1"#, node), &gltf_buffer(&mesh.positions, &indices))
}
