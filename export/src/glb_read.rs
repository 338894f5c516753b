//! Reads and checks a `.glb` file of this program; parts that are returned have passed all checks.
//!
//! The checks cover the container and its JSON, the required attributes, finite positions within the stated bounds,
//! unit normals, indices in range, one weld id per part, and the rotation from z-up to y-up.

use glam::{DVec3, Vec3};
use gltf::accessor::{DataType, Dimensions, Iter};
use gltf::{Document, Glb, Primitive, Semantic};
use sdf_bake::Mesh;

use crate::glb::QUANTIZATION;

/// A part, or a piece of a surface, read from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadPart {
    /// Name of its mesh.
    pub name: String,
    /// 0 for the base, else the weld's number.
    pub weld_id: u16,
    /// Name of its material.
    pub material: String,
    /// The solid, in metres, z up; vertices are split along creases.
    pub mesh: Mesh,
    /// One unit normal per vertex.
    pub normals: Vec<Vec3>,
}

/// Defect of a `.glb` file.
#[derive(Debug, thiserror::Error)]
pub enum GlbReadError {
    /// Damaged container or JSON.
    #[error("not a glTF 2.0 binary file: {0}")]
    Container(#[from] gltf::Error),
    /// The file has no mesh, or no binary chunk.
    #[error("the file holds no geometry")]
    NoGeometry,
    /// The root node does not rotate z-up into y-up.
    #[error(
        "the scene has no root node that turns z-up into y-up, so it is unknown whether positions are in metres \
        with z up"
    )]
    NotTurned,
    /// A required attribute is missing or has another type.
    #[error("mesh \"{mesh}\": {attribute} is missing, of another type, or reaches beyond the file")]
    Attribute {
        /// Name of the mesh.
        mesh: String,
        /// Name of the attribute.
        attribute: &'static str,
    },
    /// Values that contradict each other or the format.
    #[error("mesh \"{mesh}\": {fault}")]
    Values {
        /// Name of the mesh.
        mesh: String,
        /// Description of the contradiction.
        fault: &'static str,
    },
}

/// Reads and checks the parts of a file, in its order; pieces of one mesh are parts with the same name.
pub fn read_glb(bytes: &[u8]) -> Result<Vec<ReadPart>, GlbReadError> {
    let container = Glb::from_slice(bytes)?;
    let binary = container.bin.as_deref().ok_or(GlbReadError::NoGeometry)?;
    let file = document(&container.json)?;
    let turned = |node: gltf::Node<'_>| {
        let (_, [x, y, z, w], _) = node.transform().decomposed();
        glam::Quat::from_xyzw(x, y, z, w).mul_vec3(Vec3::Z).abs_diff_eq(Vec3::Y, 1e-6)
    };
    if !file.scenes().flat_map(|scene| scene.nodes()).all(turned) {
        return Err(GlbReadError::NotTurned);
    }
    let mut parts = Vec::new();
    for mesh in file.meshes() {
        let place = placement(&file, &mesh);
        for primitive in mesh.primitives() {
            parts.push(read_part(&mesh, &primitive, place, binary)?);
        }
    }
    if parts.is_empty() { Err(GlbReadError::NoGeometry) } else { Ok(parts) }
}

/// Parses and validates the JSON chunk.
///
/// The validation in gltf-json 1.4 looks up accessors before it checks their indices, and panics; so the indices are
/// checked first.
fn document(header: &[u8]) -> Result<Document, GlbReadError> {
    let mut root: gltf_json::Root = gltf_json::deserialize::from_slice(header).map_err(gltf::Error::Deserialize)?;
    for mesh in &root.meshes {
        let mut arrays = mesh.primitives.iter().flat_map(|primitive| primitive.attributes.values());
        if arrays.any(|array| array.value() >= root.accessors.len()) {
            let mesh = mesh.name.clone().unwrap_or_default();
            return Err(GlbReadError::Attribute { mesh, attribute: "an accessor" });
        }
    }
    // The crate refuses extensions that it does not implement itself; this one is read below.
    root.extensions_required.retain(|name| name != QUANTIZATION);
    Ok(Document::from_json(root)?)
}

/// Translation [m] and scale of a mesh's node, which place quantized positions in the part's frame.
type Placement = [DVec3; 2];

fn placement(file: &Document, mesh: &gltf::Mesh<'_>) -> Placement {
    let node = file.nodes().find(|node| node.mesh().is_some_and(|other| other.index() == mesh.index()));
    let (translation, _, scale) =
        node.map_or_else(|| ([0.0; 3], [0.0; 4], [1.0; 3]), |node| node.transform().decomposed());
    [translation, scale].map(|vector| Vec3::from(vector).as_dvec3())
}

fn read_part(
    mesh: &gltf::Mesh<'_>,
    primitive: &Primitive<'_>,
    [translation, scale]: Placement,
    binary: &[u8],
) -> Result<ReadPart, GlbReadError> {
    let name = mesh.name().unwrap_or_default().to_owned();
    let missing = |attribute| GlbReadError::Attribute { mesh: name.clone(), attribute };
    let positions = vectors(primitive, &Semantic::Positions, binary).ok_or_else(|| missing("POSITION"))?;
    let normals = vectors(primitive, &Semantic::Normals, binary).ok_or_else(|| missing("NORMAL"))?;
    let weld_ids = weld_ids(primitive, binary).ok_or_else(|| missing("_WELD_ID"))?;
    let triangles = triangles(primitive, binary).ok_or_else(|| missing("indices"))?;
    let fault = fault_in_numbers(&positions, &normals, &triangles)
        .or_else(|| fault_in_weld_ids(&weld_ids, positions.len()))
        .or_else(|| fault_in_bounds(primitive, &positions))
        .or_else(|| (!(translation + scale).is_finite()).then_some("a position is not finite"));
    if let Some(fault) = fault {
        return Err(GlbReadError::Values { mesh: name, fault });
    }
    Ok(ReadPart {
        name,
        weld_id: weld_ids[0],
        material: primitive.material().name().unwrap_or_default().to_owned(),
        mesh: Mesh { positions: positions.iter().map(|p| translation + scale * p.as_dvec3()).collect(), triangles },
        normals,
    })
}

fn fault_in_numbers(positions: &[Vec3], normals: &[Vec3], triangles: &[[u32; 3]]) -> Option<&'static str> {
    let checks = [
        (positions.iter().all(|p| p.is_finite()), "a position is not finite"),
        (normals.len() == positions.len(), "there are not as many normals as positions"),
        (normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4), "a normal is not of unit length"),
        (!triangles.is_empty(), "there are no triangles"),
        (triangles.iter().flatten().all(|&v| (v as usize) < positions.len()), "an index is out of range"),
    ];
    checks.into_iter().find(|(good, _)| !good).map(|(_, fault)| fault)
}

fn fault_in_weld_ids(weld_ids: &[u16], vertices: usize) -> Option<&'static str> {
    let uniform = weld_ids.windows(2).all(|pair| pair[0] == pair[1]);
    let checks = [
        (weld_ids.len() == vertices, "there are not as many weld ids as positions"),
        (!weld_ids.is_empty() && uniform, "the weld id changes within the part"),
    ];
    checks.into_iter().find(|(good, _)| !good).map(|(_, fault)| fault)
}

fn fault_in_bounds(primitive: &Primitive<'_>, positions: &[Vec3]) -> Option<&'static str> {
    let stated = primitive.bounding_box();
    let low = positions.iter().copied().fold(Vec3::INFINITY, Vec3::min);
    let high = positions.iter().copied().fold(Vec3::NEG_INFINITY, Vec3::max);
    (stated.min != low.to_array() || stated.max != high.to_array())
        .then_some("the stated bounds are not the positions'")
}

fn vectors(primitive: &Primitive<'_>, semantic: &Semantic, binary: &[u8]) -> Option<Vec<Vec3>> {
    let accessor = primitive.get(semantic)?;
    let is_vector = accessor.dimensions() == Dimensions::Vec3;
    match (accessor.data_type(), semantic) {
        (DataType::U16, Semantic::Positions) => {
            let steps = array::<[u16; 3]>(is_vector && !accessor.normalized(), accessor, binary)?;
            Some(steps.into_iter().map(|step| Vec3::from(step.map(f32::from))).collect())
        }
        (DataType::I8, Semantic::Normals) => {
            let normals = array::<[i8; 3]>(is_vector && accessor.normalized(), accessor, binary)?;
            Some(normals.into_iter().map(|normal| Vec3::from(normal.map(f32::from)).normalize_or_zero()).collect())
        }
        (kind, _) => {
            let vectors = array::<[f32; 3]>(is_vector && kind == DataType::F32, accessor, binary)?;
            Some(vectors.into_iter().map(Vec3::from).collect())
        }
    }
}

fn weld_ids(primitive: &Primitive<'_>, binary: &[u8]) -> Option<Vec<u16>> {
    let accessor = primitive.get(&Semantic::Extras("WELD_ID".to_owned()))?;
    let typed = accessor.data_type() == DataType::U16 && accessor.dimensions() == Dimensions::Scalar;
    array(typed, accessor, binary)
}

fn triangles(primitive: &Primitive<'_>, binary: &[u8]) -> Option<Vec<[u32; 3]>> {
    let accessor = primitive.indices()?;
    let typed = accessor.data_type() == DataType::U32 && accessor.dimensions() == Dimensions::Scalar;
    let indices = array::<u32>(typed, accessor, binary)?;
    let (triangles, rest) = indices.as_chunks::<3>();
    rest.is_empty().then(|| triangles.to_vec())
}

/// Returns the values of an accessor, if it has the requested type and lies within the file.
fn array<T: gltf::accessor::Item>(typed: bool, accessor: gltf::Accessor<'_>, binary: &[u8]) -> Option<Vec<T>> {
    let view = accessor.view().filter(|_| typed && accessor.count() > 0 && accessor.sparse().is_none())?;
    let stride = view.stride().unwrap_or(accessor.size());
    let needed =
        accessor.offset().checked_add(stride.checked_mul(accessor.count() - 1)?)?.checked_add(accessor.size())?;
    let end = view.offset().checked_add(view.length())?;
    let whole = needed <= view.length() && end <= binary.len() && stride >= accessor.size();
    let values = Iter::new(accessor, |_| whole.then_some(binary))?;
    Some(values.collect())
}
