//! Checks of the welded surface as one mesh: closed, with the weld ids of the ground truth and the volume of the field.

use std::collections::BTreeSet;

use glam::DVec3;
use sdf_bake::{Merged, Mesh};

use crate::asset::{AssetFields, Check, SURFACE_FILE, Welds};
use export::glb_read::ReadPart;

/// Greatest |φ| of the trilinear field at a vertex [voxels]; extraction allows 0.6 on edges and corners.
const OFF_FIELD: f64 = 0.61;
/// Greatest difference between the volumes of mesh and field, over the mesh's area [voxels]. It is mostly below 0.03; a
/// real part of 1 m at voxels of 8 mm, whose walls are thinner than a voxel and partly missing from the mesh, has 0.15.
const OFF_VOLUME: f64 = 0.2;

pub(super) fn check(pieces: &[ReadPart], fields: &AssetFields, truth: Option<&Welds>) -> Vec<Check> {
    let mut surface = Mesh::default();
    pieces.iter().for_each(|piece| surface.append(&piece.mesh));
    let mut checks = vec![check_distance(&surface, fields), check_volume(&surface, fields), check_manifold(&surface)];
    if let Some(truth) = truth {
        let stated: BTreeSet<u16> = truth.welds.iter().map(|weld| weld.id).chain([0]).collect();
        let found: BTreeSet<u16> = pieces.iter().map(|piece| piece.weld_id).collect();
        let rule = "its pieces have the weld ids of the truth";
        checks.push(Check::new(SURFACE_FILE, rule, found == stated, format!("{found:?}, stated {stated:?}")));
    }
    checks
}

fn check_manifold(surface: &Mesh) -> Check {
    let Merged { uneven_edges: edges, flat_triangles: flat } = Merged::of(surface);
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
