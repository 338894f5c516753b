//! Writes a welded workpiece as binary glTF 2.0 (`.glb`).
//!
//! The file has one mesh and one node per part, under a root node that rotates the z-up frame into glTF's y-up. The
//! stored positions are in the part's frame, in metres. Every vertex has `_WELD_ID` (0 for the base, else the weld's
//! number) as an unsigned short. The same parts give the same bytes.

mod quantized;

use glam::Vec3;
use gltf_json::accessor::{ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Stride, Target};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::Semantic;
use gltf_json::scene::UnitQuaternion;
use gltf_json::validation::{Checked, USize64};
use gltf_json::{self as json, Index};
use sdf_bake::Mesh;
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Map, Value};

use super::shading::{CREASE_ANGLE, ShadedMesh, shade};

pub use quantized::write_quantized_glb;
pub(crate) use quantized::{QUANTIZATION, QUANTIZATION_STEPS};

/// Program and version, written into files.
pub const GENERATOR: &str = concat!("RoboFin ", env!("CARGO_PKG_VERSION"));

/// Rotation from z-up to y-up: minus 90 degrees about x, as the quaternion (x, y, z, w).
const Z_UP_TO_Y_UP: [f32; 4] = [-std::f32::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2];

/// Material of a part; it sets the appearance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum GlbMaterial {
    /// The CAD part: bare steel.
    Base,
    /// Weld metal, tinted so that it stands out.
    Weld,
}

/// One named solid of the workpiece.
#[derive(Clone, Copy, Debug)]
pub struct GlbPart<'a> {
    /// Name of the mesh and its node: `base`, `weld-1`, ...
    pub name: &'a str,
    /// The solid, in metres, z up.
    pub mesh: &'a Mesh,
    /// 0 for the base, else the weld's number.
    pub weld_id: u16,
    /// Material, which sets the appearance.
    pub material: GlbMaterial,
}

/// Reason why a workpiece cannot be written as glTF.
#[derive(Debug, thiserror::Error)]
pub enum GlbWriteError {
    /// There are no parts; a glTF file without geometry is not valid.
    #[error("no parts to write: a glTF file needs at least one")]
    NoParts,
    /// A part has no triangles.
    #[error("part \"{part}\" has no triangle with three different corners in single precision")]
    NoTriangles {
        /// Name of the part.
        part: String,
    },
    /// A triangle has an index beyond the vertices.
    #[error("part \"{part}\": triangle {triangle} uses a vertex beyond the {vertices} there are")]
    IndexOutOfRange {
        /// Name of the part.
        part: String,
        /// Index of the triangle.
        triangle: usize,
        /// Number of vertices.
        vertices: usize,
    },
    /// A coordinate is NaN, infinite, or beyond single precision.
    #[error("part \"{part}\": vertex {vertex} is not a finite single-precision position")]
    NotFinite {
        /// Name of the part.
        part: String,
        /// Index of the vertex.
        vertex: usize,
    },
    /// The geometry exceeds the container's 32-bit lengths.
    #[error("{bytes} bytes of geometry do not fit into one .glb file (4 GiB)")]
    TooLarge {
        /// Size of the geometry [bytes].
        bytes: usize,
    },
    /// The JSON chunk cannot be serialised.
    #[error("glTF header: {0}")]
    Json(#[from] serde_json::Error),
}

/// Writes the parts as one `.glb` file.
///
/// `extras` is written to `asset.extras`; the entries `unit`, `up` and `weld_ids` of this writer replace entries of the
/// same name.
pub fn write_glb(parts: &[GlbPart<'_>], extras: Map<String, Value>) -> Result<Vec<u8>, GlbWriteError> {
    if parts.is_empty() {
        return Err(GlbWriteError::NoParts);
    }
    let mut file = Glb::default();
    let materials = file.push_materials(parts);
    let mut children = Vec::with_capacity(parts.len());
    for part in parts {
        let primitive = file.push_primitive(part, &materials)?;
        let extras = to_raw_value(&serde_json::json!({ "weld_id": part.weld_id }))?;
        children.push(file.push_mesh(part.name, vec![primitive], Some(extras)));
    }
    file.push_scene(children);
    file.finish(asset_extras(parts, extras)?)
}

/// Writes the pieces of one surface as one mesh of a `.glb` file, with a primitive for each piece.
///
/// Positions along the borders of the pieces are kept, so a closed surface is closed again once equal positions are
/// merged.
pub fn write_surface_glb(name: &str, pieces: &[GlbPart<'_>]) -> Result<Vec<u8>, GlbWriteError> {
    if pieces.is_empty() {
        return Err(GlbWriteError::NoParts);
    }
    let mut file = Glb::default();
    let materials = file.push_materials(pieces);
    let primitives = pieces.iter().map(|piece| file.push_primitive(piece, &materials)).collect::<Result<_, _>>()?;
    let node = file.push_mesh(name, primitives, None);
    file.push_scene(vec![node]);
    file.finish(asset_extras(pieces, Map::new())?)
}

fn check(part: &GlbPart<'_>) -> Result<(), GlbWriteError> {
    let name = || part.name.to_owned();
    let vertices = part.mesh.positions.len();
    if let Some(vertex) = part.mesh.positions.iter().position(|p| !p.as_vec3().is_finite()) {
        return Err(GlbWriteError::NotFinite { part: name(), vertex });
    }
    if let Some(triangle) = part.mesh.triangles.iter().position(|t| t.iter().any(|&v| v as usize >= vertices)) {
        return Err(GlbWriteError::IndexOutOfRange { part: name(), triangle, vertices });
    }
    Ok(())
}

fn asset_extras(parts: &[GlbPart<'_>], mut extras: Map<String, Value>) -> Result<Box<RawValue>, serde_json::Error> {
    let mut weld_ids: Vec<u16> = parts.iter().map(|part| part.weld_id).filter(|&id| id != 0).collect();
    weld_ids.sort_unstable();
    weld_ids.dedup();
    extras.insert("unit".to_owned(), "m".into());
    extras.insert("up".to_owned(), "z, turned to y by the root node".into());
    extras.insert("weld_ids".to_owned(), weld_ids.into());
    to_raw_value(&extras)
}

/// A file under construction: its JSON chunk and its binary chunk.
#[derive(Default)]
struct Glb {
    root: json::Root,
    bytes: Vec<u8>,
}

/// One array of the binary chunk, as its accessor describes it.
struct Array<'a> {
    bytes: &'a [u8],
    stride: Option<usize>,
    target: Target,
    count: usize,
    component: ComponentType,
    kind: Type,
    normalized: bool,
    bounds: Option<[Value; 2]>,
}

impl Glb {
    /// Adds the materials used, base first.
    fn push_materials(&mut self, parts: &[GlbPart<'_>]) -> Vec<(GlbMaterial, Index<json::Material>)> {
        let kinds = [GlbMaterial::Base, GlbMaterial::Weld];
        let used = kinds.into_iter().filter(|kind| parts.iter().any(|part| part.material == *kind));
        used.map(|kind| (kind, self.root.push(material(kind)))).collect()
    }

    fn push_primitive(
        &mut self,
        part: &GlbPart<'_>,
        materials: &Materials,
    ) -> Result<json::mesh::Primitive, GlbWriteError> {
        check(part)?;
        let shaded: ShadedMesh = shade(part.mesh, CREASE_ANGLE);
        if shaded.triangles.is_empty() {
            return Err(GlbWriteError::NoTriangles { part: part.name.to_owned() });
        }
        let position = self.push_vectors(&shaded.positions, true);
        let normal = self.push_vectors(&shaded.normals, false);
        let weld_id = self.push_weld_ids(part.weld_id, shaded.positions.len());
        let indices = self.push_indices(&shaded.triangles);
        Ok(primitive([position, normal, weld_id, indices], part.material, materials))
    }

    fn push_indices(&mut self, triangles: &[[u32; 3]]) -> Index<json::Accessor> {
        self.push_array(Array {
            bytes: bytemuck::cast_slice(triangles),
            stride: None,
            target: Target::ElementArrayBuffer,
            count: 3 * triangles.len(),
            component: ComponentType::U32,
            kind: Type::Scalar,
            normalized: false,
            bounds: None,
        })
    }

    /// Adds a mesh and its node.
    fn push_mesh(
        &mut self,
        name: &str,
        primitives: Vec<json::mesh::Primitive>,
        extras: Option<Box<RawValue>>,
    ) -> Index<json::Node> {
        let name = Some(name.to_owned());
        let mesh = json::Mesh { extensions: None, extras: None, name: name.clone(), primitives, weights: None };
        let mesh = Some(self.root.push(mesh));
        self.root.push(json::Node { mesh, name, extras, ..Default::default() })
    }

    fn push_vectors(&mut self, vectors: &[[f32; 3]], bounded: bool) -> Index<json::Accessor> {
        let far = [Vec3::INFINITY, Vec3::NEG_INFINITY];
        let grow = |[low, high]: [Vec3; 2], v: &[f32; 3]| [low.min(Vec3::from(*v)), high.max(Vec3::from(*v))];
        let bounds = bounded.then(|| vectors.iter().fold(far, grow).map(|corner| corner.to_array().to_vec().into()));
        self.push_array(Array {
            bytes: bytemuck::cast_slice(vectors),
            stride: None,
            target: Target::ArrayBuffer,
            count: vectors.len(),
            component: ComponentType::F32,
            kind: Type::Vec3,
            normalized: false,
            bounds,
        })
    }

    /// Adds the weld id of each vertex. Vertex attributes start at multiples of four bytes, so two bytes of padding
    /// follow each unsigned short.
    fn push_weld_ids(&mut self, weld_id: u16, count: usize) -> Index<json::Accessor> {
        self.push_array(Array {
            bytes: &u32::from(weld_id).to_le_bytes().repeat(count),
            stride: Some(4),
            target: Target::ArrayBuffer,
            count,
            component: ComponentType::U16,
            kind: Type::Scalar,
            normalized: false,
            bounds: Some([vec![weld_id].into(), vec![weld_id].into()]),
        })
    }

    fn push_array(&mut self, array: Array<'_>) -> Index<json::Accessor> {
        let view = self.root.push(json::buffer::View {
            buffer: Index::new(0),
            byte_length: USize64::from(array.bytes.len()),
            byte_offset: Some(USize64::from(self.bytes.len())),
            byte_stride: array.stride.map(Stride),
            name: None,
            target: Some(Checked::Valid(array.target)),
            extensions: None,
            extras: None,
        });
        self.bytes.extend_from_slice(array.bytes);
        let [min, max] = array.bounds.map_or([None, None], |bounds| bounds.map(Some));
        self.root.push(json::Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(array.count),
            component_type: Checked::Valid(GenericComponentType(array.component)),
            type_: Checked::Valid(array.kind),
            min,
            max,
            name: None,
            normalized: array.normalized,
            sparse: None,
            extensions: None,
            extras: None,
        })
    }

    fn push_scene(&mut self, children: Vec<Index<json::Node>>) {
        let turned = self.root.push(json::Node {
            children: Some(children),
            name: Some("workpiece".to_owned()),
            rotation: Some(UnitQuaternion(Z_UP_TO_Y_UP)),
            ..Default::default()
        });
        let scene = json::Scene { extensions: None, extras: None, name: None, nodes: vec![turned] };
        self.root.scene = Some(self.root.push(scene));
    }

    fn finish(mut self, extras: Box<RawValue>) -> Result<Vec<u8>, GlbWriteError> {
        let bytes = self.bytes.len();
        self.root.asset.generator = Some(GENERATOR.to_owned());
        self.root.asset.extras = Some(extras);
        self.root.push(json::Buffer {
            byte_length: USize64::from(bytes),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let header = json::serialize::to_vec(&self.root)?;
        if u32::try_from(header.len() + bytes + 64).is_err() {
            return Err(GlbWriteError::TooLarge { bytes });
        }
        let container = gltf::binary::Glb {
            header: gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 },
            json: header.into(),
            bin: Some(self.bytes.into()),
        };
        container.to_vec().map_err(|_| GlbWriteError::TooLarge { bytes })
    }
}

/// Materials of a file, with their indices.
type Materials = [(GlbMaterial, Index<json::Material>)];

/// Returns a primitive of triangles from its arrays: positions, normals, weld ids and indices.
fn primitive(
    [position, normal, weld_id, indices]: [Index<json::Accessor>; 4],
    material: GlbMaterial,
    materials: &Materials,
) -> json::mesh::Primitive {
    let attributes = [
        (Semantic::Positions, position),
        (Semantic::Normals, normal),
        (Semantic::Extras("WELD_ID".to_owned()), weld_id),
    ];
    json::mesh::Primitive {
        attributes: attributes.into_iter().map(|(name, array)| (Checked::Valid(name), array)).collect(),
        extensions: None,
        extras: None,
        indices: Some(indices),
        material: materials.iter().find(|(kind, _)| *kind == material).map(|&(_, index)| index),
        mode: Checked::Valid(json::mesh::Mode::Triangles),
        targets: None,
    }
}

fn material(kind: GlbMaterial) -> json::Material {
    let (name, color, metallic, roughness) = match kind {
        GlbMaterial::Base => ("base", [0.56, 0.58, 0.60, 1.0], 0.7, 0.45),
        GlbMaterial::Weld => ("weld", [0.76, 0.50, 0.20, 1.0], 0.7, 0.35),
    };
    json::Material {
        name: Some(name.to_owned()),
        pbr_metallic_roughness: PbrMetallicRoughness {
            base_color_factor: PbrBaseColorFactor(color),
            metallic_factor: StrengthFactor(metallic),
            roughness_factor: StrengthFactor(roughness),
            ..Default::default()
        },
        ..Default::default()
    }
}
