//! The welded surface as one mesh: closed, with the ids of the truth and the volume of the field.

use std::collections::{BTreeSet, HashMap};

use glam::DVec3;
use sdf_bake::Mesh;

use crate::asset::{AssetFields, Check, SURFACE_FILE, Welds};
use export::glb_read::ReadPart;

/// Largest |φ| of the trilinear field at a vertex [voxels]: on sharp edges and corners, which interpolation rounds off,
/// extraction allows 0.6.
const OFF_FIELD: f64 = 0.61;
/// Largest difference between the volumes of mesh and field, over the mesh's area [voxels]. Mostly it is below 0.03; a
/// real part of 1 m at voxels of 8 mm, whose walls are thinner than a voxel and partly absent from the mesh, has 0.15.
const OFF_VOLUME: f64 = 0.2;

pub(super) fn check(pieces: &[ReadPart], fields: &AssetFields, truth: Option<&Welds>) -> Vec<Check> {
    let mut surface = Mesh::default();
    pieces.iter().for_each(|piece| surface.append(&piece.mesh));
    let mut checks = vec![check_distance(&surface, fields), check_volume(&surface, fields), check_manifold(&surface)];
    if let Some(truth) = truth {
        let told: BTreeSet<u16> = truth.welds.iter().map(|weld| weld.id).chain([0]).collect();
        let found: BTreeSet<u16> = pieces.iter().map(|piece| piece.weld_id).collect();
        let rule = "its pieces have the weld ids of the truth";
        checks.push(Check::new(SURFACE_FILE, rule, found == told, format!("{found:?}, told {told:?}")));
    }
    checks
}

/// A surface in which vertices in one place are one.
struct Merged<'a> {
    surface: &'a Mesh,
    /// The place of each vertex.
    places: Vec<u32>,
}

impl<'a> Merged<'a> {
    fn of(surface: &'a Mesh) -> Self {
        let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(surface.positions.len());
        let mut place = |position: &DVec3| {
            let next = known.len() as u32;
            *known.entry(position.to_array().map(|x| (x + 0.0).to_bits())).or_insert(next)
        };
        Self { surface, places: surface.positions.iter().map(&mut place).collect() }
    }

    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.surface.triangles.iter().map(|corners| corners.map(|corner| self.places[corner as usize]))
    }

    /// Edges that are not passed exactly once each way.
    fn open_or_crowded_edges(&self) -> usize {
        let mut passes: HashMap<(u32, u32), [u32; 2]> = HashMap::new();
        for [a, b, c] in self.triangles() {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                passes.entry((from.min(to), from.max(to))).or_default()[usize::from(from > to)] += 1;
            }
        }
        passes.values().filter(|ways| **ways != [1, 1]).count()
    }

    /// Triangles without area.
    fn flat_triangles(&self) -> usize {
        (0..self.surface.triangles.len()).filter(|&t| self.surface.doubled_area_normal(t) == DVec3::ZERO).count()
    }
}

fn check_manifold(surface: &Mesh) -> Check {
    let merged = Merged::of(surface);
    let (edges, flat) = (merged.open_or_crowded_edges(), merged.flat_triangles());
    let rule = "is closed once equal positions are merged, two triangles an edge, each with an area";
    let found = format!("{edges} edges without exactly two triangles, {flat} triangles without area");
    Check::new(SURFACE_FILE, rule, edges == 0 && flat == 0, found)
}

fn check_distance(surface: &Mesh, fields: &AssetFields) -> Check {
    let off = |place: &DVec3| f64::from(fields.welded.sample(*place)).abs() / fields.welded.voxel;
    let worst = surface.positions.iter().map(off).fold(0.0, f64::max);
    let rule = format!("its vertices lie within {OFF_FIELD} voxels of phi = 0");
    Check::new(SURFACE_FILE, rule, worst <= OFF_FIELD, format!("at most {worst:.3} voxels off"))
}

fn check_volume(surface: &Mesh, fields: &AssetFields) -> Check {
    let apart = (surface.volume() - fields.welded.volume()) / (surface.area() * fields.welded.voxel);
    let rule = format!("its volume is that of phi within {OFF_VOLUME} voxels over its area");
    Check::new(SURFACE_FILE, rule, apart.abs() <= OFF_VOLUME, format!("{apart:+.4} voxels"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners of a tetrahedron, its triangles with vertices of their own.
    fn tetrahedron(corners: [DVec3; 4]) -> Mesh {
        let sides = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let positions = sides.iter().flatten().map(|&corner| corners[corner]).collect();
        Mesh { positions, triangles: (0..4).map(|side| [3 * side, 3 * side + 1, 3 * side + 2]).collect() }
    }

    #[test]
    fn a_surface_is_closed_only_if_its_merged_edges_have_two_triangles() {
        let [a, b] = [DVec3::ZERO, DVec3::Z];
        let one = tetrahedron([a, DVec3::X, DVec3::Y, b]);
        assert!(check_manifold(&one).passed, "a closed surface whose triangles share no vertex");
        let mut open = one.clone();
        open.triangles.pop();
        assert!(!check_manifold(&open).passed, "an open one");
        let mut crowded = one.clone();
        crowded.append(&tetrahedron([a, -DVec3::X, -DVec3::Y, b]));
        let found = check_manifold(&crowded);
        assert!(!found.passed, "two bodies that share an edge, which has four triangles");
        let mut flapped = one;
        let [p, q, r] = [0, 1, 2].map(|corner| flapped.positions[corner]);
        let first = flapped.positions.len() as u32;
        flapped.positions.extend([p, q, r, p, r, q]);
        flapped.triangles.extend([[first, first + 1, first + 2], [first + 3, first + 4, first + 5]]);
        assert!(!check_manifold(&flapped).passed, "a fold of two triangles on a face");
    }

    #[test]
    fn a_triangle_without_area_is_found() {
        let mut surface = tetrahedron([DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]);
        surface.positions[0] = 0.5 * (surface.positions[1] + surface.positions[2]);
        assert!(!check_manifold(&surface).passed);
        assert_eq!(Merged::of(&surface).flat_triangles(), 1);
    }
}
