//! Surface of a welded workpiece, in pieces by weld id, at full and at reduced resolution.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::DVec3;
use meshopt::SimplifyOptions;
use rayon::prelude::*;
use sdf_bake::query::MeshQuery;
use sdf_bake::{BrickGrid, Mesh};
use serde_json::{Map, Value};

use crate::glb::{GlbMaterial, GlbPart, GlbWriteError, write_quantized_glb, write_surface_glb};

/// Name of the mesh in glTF files.
const SURFACE_NAME: &str = "surface";
/// Least distance of a triangle's centre outside the bare part for weld metal [voxels].
const OFF_PART: f32 = 0.1;
/// Mean error of the first simplification [tolerances], and its factor after two attempts that are too far off.
const FIRST_ERROR: f64 = 0.4;
const NEXT_ERROR: f64 = 0.5;
/// Greatest number of attempts; if all fail, the surface is returned unchanged.
const ATTEMPTS: i32 = 8;

/// A closed surface in pieces by weld id. Positions along the borders of pieces have the same bits, so the surface is
/// closed once equal positions are merged.
#[derive(Clone, Debug, PartialEq)]
pub struct WeldedSurface {
    /// Pieces [m], by weld id; 0 is base metal.
    pub pieces: BTreeMap<u16, Mesh>,
}

impl WeldedSurface {
    /// Extracts the surface of a welded workpiece.
    ///
    /// A triangle belongs to the weld that labels its centre if that lies outside the bare part, `target`.
    pub fn of(welded: &BrickGrid, target: &BrickGrid) -> Self {
        let surface = welded.surface_mesh();
        let off_part = OFF_PART * welded.voxel as f32;
        let id = |triangle: usize| {
            let [a, b, c] = surface.corners(triangle);
            let middle = (a + b + c) / 3.0;
            let label = welded.label(middle);
            if label != 0 && target.sample(middle) > off_part { label } else { 0 }
        };
        let ids: Vec<u16> = (0..surface.triangles.len()).into_par_iter().map(id).collect();
        let mut triangles: BTreeMap<u16, Vec<[u32; 3]>> = BTreeMap::new();
        for (id, &corners) in ids.into_iter().zip(&surface.triangles) {
            triangles.entry(id).or_default().push(corners);
        }
        let piece = |(id, triangles): (u16, Vec<[u32; 3]>)| (id, compact(&surface, &triangles));
        Self { pieces: triangles.into_iter().map(piece).collect() }
    }

    /// Returns all pieces as one mesh, with equal positions merged.
    pub fn whole(&self) -> Mesh {
        let (mut whole, mut known) = (Mesh::default(), HashMap::new());
        for piece in self.pieces.values() {
            let mut place = |p: &DVec3| {
                *known.entry(key(p)).or_insert_with(|| {
                    whole.positions.push(*p);
                    whole.positions.len() as u32 - 1
                })
            };
            let places: Vec<u32> = piece.positions.iter().map(&mut place).collect();
            whole.triangles.extend(piece.triangles.iter().map(|corners| corners.map(|corner| places[corner as usize])));
        }
        whole
    }

    /// Returns true if the triangles pass every edge as often in one direction as in the other, once equal positions
    /// are merged.
    pub fn is_closed(&self) -> bool {
        let mut passes: HashMap<(u32, u32), i32> = HashMap::new();
        for [a, b, c] in self.whole().triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *passes.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
            }
        }
        passes.values().all(|passes| *passes == 0)
    }

    /// Returns the number of triangles.
    pub fn triangles(&self) -> usize {
        self.pieces.values().map(|piece| piece.triangles.len()).sum()
    }

    /// Returns the surface as one piece, without weld ids.
    pub fn without_ids(&self) -> Self {
        Self { pieces: BTreeMap::from([(0, self.whole())]) }
    }

    /// Returns the surface with fewer triangles: none of its vertices lies farther than `tolerance` [m] from them, nor
    /// their middles from it. Their vertices are original ones in single precision; along borders of pieces all stay.
    /// A closed surface stays closed, but two of its sheets may come to touch along an edge.
    ///
    /// Edges collapse by quadric error metrics (Garland & Heckbert 1997, in meshoptimizer), whose error is a mean. Where
    /// the result is too far off, the original triangles are kept and the rest is done again, in the end with a smaller error.
    pub fn simplified(&self, tolerance: f64) -> Self {
        let single = self.in_single_precision();
        let full = MeshQuery::new(&single.whole());
        let mut kept: HashSet<[u64; 3]> = HashSet::new();
        for attempt in 0..ATTEMPTS {
            let error = FIRST_ERROR * NEXT_ERROR.powi(attempt / 2) * tolerance;
            let simplify = |(&id, piece): (&u16, &Mesh)| (id, simplify(piece, &kept, error as f32));
            let light = Self { pieces: single.pieces.par_iter().map(simplify).collect() };
            let faults = single.faults(&full, &light.whole(), tolerance);
            if faults.is_empty() {
                return light;
            }
            kept.extend(faults);
        }
        single
    }

    fn in_single_precision(&self) -> Self {
        let mut single = self.clone();
        for position in single.pieces.values_mut().flat_map(|piece| &mut piece.positions) {
            *position = position.as_vec3().as_dvec3();
        }
        single
    }

    /// Lists the positions where a light surface and this one, `full`, are farther than `tolerance` [m] apart, with the
    /// other corners of the triangles of this surface there.
    fn faults(&self, full: &MeshQuery, light: &Mesh, tolerance: f64) -> HashSet<[u64; 3]> {
        let query = MeshQuery::new(light);
        let is_off = |triangle: &usize| {
            let [a, b, c] = light.corners(*triangle);
            full.closest_within((a + b + c) / 3.0, tolerance).is_none()
        };
        let off: Vec<usize> = (0..light.triangles.len()).into_par_iter().filter(is_off).collect();
        let corners = off.into_iter().flat_map(|triangle| light.triangles[triangle]);
        let mut faults: HashSet<[u64; 3]> = corners.map(|vertex| key(&light.positions[vertex as usize])).collect();
        let vertices: Vec<&DVec3> = self.pieces.values().flat_map(|piece| &piece.positions).collect();
        let is_far = |p: &&DVec3| query.closest_within(**p, tolerance).is_none();
        faults.extend(vertices.into_par_iter().filter(is_far).map(key).collect::<Vec<_>>());
        if faults.is_empty() { faults } else { self.around(&faults) }
    }

    /// Returns the positions of all corners of the triangles that have a corner at one of `places`.
    fn around(&self, places: &HashSet<[u64; 3]>) -> HashSet<[u64; 3]> {
        let corners = |piece: &Mesh| {
            let keys: Vec<[u64; 3]> = piece.positions.iter().map(key).collect();
            let near: Vec<bool> = keys.iter().map(|key| places.contains(key)).collect();
            let touches = |corners: &&[u32; 3]| corners.iter().any(|&corner| near[corner as usize]);
            let touched = piece.triangles.iter().filter(touches).flatten();
            touched.map(|&corner| keys[corner as usize]).collect::<Vec<_>>()
        };
        self.pieces.values().flat_map(corners).collect()
    }

    /// Returns the greatest distance of a vertex of this surface from another surface [m]; `None` if it is more than
    /// `reach` [m].
    pub fn deviation_from(&self, other: &Self, reach: f64) -> Option<f64> {
        let query = MeshQuery::new(&other.whole());
        let vertices = self.pieces.values().flat_map(|piece| &piece.positions).collect::<Vec<_>>();
        let distance = |&vertex: &DVec3| query.closest_within(vertex, reach).map(|closest| closest.distance);
        vertices.into_par_iter().map(distance).try_reduce(|| 0.0, |a, b| Some(a.max(b)))
    }

    /// Writes the surface as glTF, with a primitive for each piece.
    ///
    /// # Errors
    /// If there are no triangles, or a number is beyond single precision.
    pub fn write_glb(&self) -> Result<Vec<u8>, GlbWriteError> {
        write_surface_glb(SURFACE_NAME, &self.parts())
    }

    /// Writes the surface as glTF with integer positions and normals; `extras` is written to `asset.extras`.
    ///
    /// # Errors
    /// If there are no triangles, or a number is beyond single precision.
    pub fn write_quantized_glb(&self, extras: Map<String, Value>) -> Result<Vec<u8>, GlbWriteError> {
        write_quantized_glb(SURFACE_NAME, &self.parts(), extras)
    }

    fn parts(&self) -> Vec<GlbPart<'_>> {
        let material = |weld_id: u16| if weld_id == 0 { GlbMaterial::Base } else { GlbMaterial::Weld };
        let part = |(&weld_id, mesh)| GlbPart { name: SURFACE_NAME, mesh, weld_id, material: material(weld_id) };
        self.pieces.iter().map(part).collect()
    }
}

/// Returns some triangles of a mesh with the vertices that they use, in the order of first use.
fn compact(mesh: &Mesh, triangles: &[[u32; 3]]) -> Mesh {
    let mut known = vec![u32::MAX; mesh.positions.len()];
    let mut part = Mesh::default();
    for corners in triangles {
        part.triangles.push(corners.map(|vertex| {
            let place = &mut known[vertex as usize];
            if *place == u32::MAX {
                *place = part.positions.len() as u32;
                part.positions.push(mesh.positions[vertex as usize]);
            }
            *place
        }));
    }
    part
}

/// Returns the bits of a position, the same for both zeros.
fn key(position: &DVec3) -> [u64; 3] {
    position.to_array().map(|x| (x + 0.0).to_bits())
}

/// Simplifies a piece with fixed borders, within a mean error [m]; vertices at the positions `kept` stay.
fn simplify(piece: &Mesh, kept: &HashSet<[u64; 3]>, error: f32) -> Mesh {
    let positions: Vec<[f32; 3]> = piece.positions.iter().map(|p| p.as_vec3().to_array()).collect();
    let kept: Vec<bool> = piece.positions.iter().map(|p| kept.contains(&key(p))).collect();
    let options = SimplifyOptions::LockBorder | SimplifyOptions::ErrorAbsolute;
    let indices = piece.triangles.as_flattened();
    let left = meshopt::simplify_with_locks_decoder(indices, &positions, &kept, 0, error, options, None);
    compact(piece, left.as_chunks::<3>().0)
}
