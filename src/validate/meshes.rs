//! Checks of the glTF files: the bare part, the part with its beads, and the welded surface.

use sdf_bake::clean::clean;

use crate::asset::{Check, Meshes, SURFACE_FILE, WELDED_FILE, WORKPIECE_FILE};
use export::glb_read::ReadPart;

pub(super) fn check(meshes: &Meshes) -> Vec<Check> {
    let mut checks = Vec::new();
    for (file, part) in std::iter::once((WORKPIECE_FILE, &meshes.part))
        .chain(meshes.welded.iter().map(|part| (WELDED_FILE, part)))
        .chain(meshes.surface.iter().map(|piece| (SURFACE_FILE, piece)))
    {
        checks.push(check_numbers(file, part));
    }
    let same = meshes.welded.first().is_some_and(|base| base.weld_id == 0 && base.mesh == meshes.part.mesh);
    let found = if same { "identical" } else { "different" };
    checks.push(Check::new(WELDED_FILE, "its base is the part of workpiece.glb", same, found));
    for bead in meshes.beads() {
        let closed = clean(bead.mesh.clone()).is_ok_and(|(_, report)| report.is_watertight());
        let found = if closed { "every edge has two triangles" } else { "edges without two triangles" };
        checks.push(Check::new(WELDED_FILE, format!("{} is closed", bead.name), closed, found));
    }
    checks
}

fn check_numbers(file: &str, part: &ReadPart) -> Check {
    let finite = part.mesh.positions.iter().all(|p| p.is_finite());
    let unit = part.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3);
    let found = format!("{} vertices, {} triangles", part.mesh.positions.len(), part.mesh.triangles.len());
    Check::new(file, format!("{} has finite positions and unit normals", part.name), finite && unit, found)
}
