//! The welded surface as one mesh: closed, close to part and beads, with the part's sharp edges and manifold3d's
//! volume.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use export::glb_read::{ReadPart, read_glb};
use export::manifold::added_volume_in_glb;
use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::clean::clean;
use sdf_bake::query::MeshQuery;
use weldgen::topology::{EdgeNeighbour, Topology};

use crate::outside::python;
use crate::program::{bracket, robofin, run};

/// Number of voxels along the bracket's longest side.
const RESOLUTION: &str = "160";

/// Greatest distance of a sharp edge of the part from the surface [voxels], found on the rims of the bracket's round
/// holes.
const ALONG_EDGES: f64 = 0.2;

/// Greatest distance of a vertex from part and bead [voxels]. With 96 voxels across it is 0.32 where a rib's foot ends
/// beside a hole, with 160 it is 0.15.
const OFF_SURFACE: f64 = 0.35;

fn parts(file: &Path) -> Vec<ReadPart> {
    read_glb(&fs::read(file).expect("a GLB")).expect("what we write can be read")
}

/// Returns the end points of the mesh's edges sharper than 60°.
fn sharp_edges(mesh: &Mesh) -> Vec<[DVec3; 2]> {
    let across = Topology::new(mesh).across;
    let of_face = |(face, edges): (usize, &[EdgeNeighbour; 3])| {
        let corners = mesh.corners(face);
        let edge = move |i: usize, across: EdgeNeighbour| match across {
            EdgeNeighbour::Face { turn, .. } if turn > 1.05 => Some([corners[i], corners[(i + 1) % 3]]),
            _ => None,
        };
        [0, 1, 2].map(|i| edge(i, edges[i])).into_iter().flatten().collect::<Vec<_>>()
    };
    across.iter().enumerate().flat_map(of_face).collect()
}

/// Counts the edges that do not have exactly one triangle on each side, after merging equal positions.
fn open_or_crowded_edges(surface: &Mesh) -> usize {
    let place = |vertex: u32| surface.positions[vertex as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut passes: HashMap<[[u64; 3]; 2], u32> = HashMap::new();
    for &[a, b, c] in &surface.triangles {
        for ends in [[a, b], [b, c], [c, a]].map(|ends| ends.map(place)) {
            *passes.entry(ends).or_default() += 1;
        }
    }
    passes.iter().filter(|&(&[from, to], &uses)| uses != 1 || passes.get(&[to, from]) != Some(&1)).count()
}

/// Reads the mesh of an asset's `surface.glb`.
fn whole_surface(asset: &Path) -> Mesh {
    let mut surface = Mesh::default();
    parts(&asset.join("surface.glb")).iter().for_each(|piece| surface.append(&piece.mesh));
    surface
}

/// Asserts a closed manifold, after merging equal positions of the file.
fn assert_manifold(surface: &Mesh) {
    assert_eq!(open_or_crowded_edges(surface), 0, "edges without exactly two triangles");
    let flat = (0..surface.triangles.len()).filter(|&t| surface.doubled_area_normal(t).length() == 0.0).count();
    assert_eq!(flat, 0, "triangles without area");
}

#[test]
fn a_fillet_on_a_part_with_its_faces_on_lattice_planes_leaves_a_manifold() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (resolution, width) in [("160", "10"), ("200", "8")] {
        let asset = folder.path().join(resolution);
        let flags = ["--seed", "1", "--usd", "off", "--place", "seam", "--resolution", resolution, "--width-mm", width];
        run(robofin(["weld"]).arg(bracket()).args(flags).arg("--out").arg(&asset)).succeeds();
        assert_manifold(&whole_surface(&asset));
    }
}

#[test]
fn it_is_closed_lies_on_part_and_bead_and_keeps_sharp_edges() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = folder.path().join("asset");
    let flags = ["--seed", "7", "--usd", "off", "--resolution", RESOLUTION, "--length-mm", "40", "--width-mm", "10"];
    run(robofin(["weld"]).arg(bracket()).args(flags).arg("--out").arg(&asset)).succeeds();
    let [part, bead] = &parts(&asset.join("welded.glb"))[..] else { panic!("one part and one bead") };
    let pieces = parts(&asset.join("surface.glb"));
    assert_eq!(pieces.iter().map(|piece| piece.weld_id).collect::<Vec<_>>(), [0, 1]);
    let surface = whole_surface(&asset);
    assert_manifold(&surface);

    let (part, _) = clean(part.mesh.clone()).expect("a mesh");
    let bead = clean(bead.mesh.clone()).expect("a mesh").0;
    let voxel = (part.bounds().map(|(low, high)| (high - low).max_element())).expect("a box") / 160.0;
    let near = [MeshQuery::new(&part), MeshQuery::new(&bead)];
    let apart = |p: &DVec3| near[0].closest(*p).distance.min(near[1].closest(*p).distance);
    let off: Vec<f64> = surface.positions.iter().map(|p| apart(p) / voxel).collect();
    let worst = off.iter().copied().fold(0.0, f64::max);
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    println!("vertices are {mean:.4} voxels off on average, at most {worst:.3}");
    assert!(worst < OFF_SURFACE && mean < 0.01, "{mean} on average, at most {worst} voxels off");

    let query = MeshQuery::new(&surface);
    let edges = sharp_edges(&part);
    let along = |[a, b]: &[DVec3; 2]| [0.2, 0.5, 0.8].map(|t| a.lerp(*b, t));
    let clear = |p: &DVec3| near[1].closest(*p).distance > 3.0 * voxel;
    let kept: Vec<f64> =
        edges.iter().flat_map(along).filter(clear).map(|p| query.closest(p).distance / voxel).collect();
    let lost = kept.iter().copied().fold(0.0, f64::max);
    println!("{} places on sharp edges, at most {lost:.4} voxels off", kept.len());
    assert!(kept.len() > 20 && lost < ALONG_EDGES, "an edge is {lost} voxels off");
    check_volume(&asset, &part, &surface);
}

/// Compares the volume with that of manifold3d's union.
fn check_volume(asset: &Path, part: &Mesh, surface: &Mesh) {
    let Some(python) = python("the welded surface's volume by manifold3d") else { return };
    let union = added_volume_in_glb(&asset.join("welded.glb"), &python).expect("both are solids");
    let apart = surface.volume() / (union.part + union.added) - 1.0;
    println!("volume {:+.4} % from manifold3d's", 100.0 * apart);
    assert!(apart.abs() < 5e-4, "{apart}");
    assert!((part.volume() / union.part - 1.0).abs() < 1e-6);
}

#[test]
fn weld_ids_part_it_where_the_bead_begins() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = folder.path().join("asset");
    let flags = ["--seed", "7", "--usd", "off", "--resolution", "96", "--length-mm", "40", "--width-mm", "10"];
    run(robofin(["weld"]).arg(bracket()).args(flags).arg("--out").arg(&asset)).succeeds();
    let [part, bead] = &parts(&asset.join("welded.glb"))[..] else { panic!("one part and one bead") };
    let near: HashMap<u16, MeshQuery> =
        [part, bead].map(|part| (part.weld_id, MeshQuery::new(&part.mesh))).into_iter().collect();
    let voxel = part.mesh.bounds().map(|(low, high)| (high - low).max_element()).expect("a box") / 96.0;
    for piece in parts(&asset.join("surface.glb")) {
        let own = &near[&piece.weld_id];
        let off = piece.mesh.positions.iter().map(|p| own.closest(*p).distance / voxel).fold(0.0, f64::max);
        assert!(off < OFF_SURFACE, "a vertex of weld id {} is {off} voxels from it", piece.weld_id);
    }
}
