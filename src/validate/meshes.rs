//! The glTF files: the bare part, the part with its beads, and the surface of the whole.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use files::input::{self, MOST_MESH_BYTES};
use glam::DVec3;
use sdf_bake::clean::clean;

use super::Check;
use crate::asset::{SURFACE_FILE, WELDED_FILE, WORKPIECE_FILE};
use export::glb_read::{ReadPart, read_glb};

/// What the glTF files hold.
pub(super) struct Meshes {
    /// The bare part.
    pub(super) part: ReadPart,
    /// The welded workpiece: the part, then one bead for each weld.
    pub(super) welded: Vec<ReadPart>,
    /// The pieces of the welded surface, one for each weld id.
    pub(super) surface: Vec<ReadPart>,
}

impl Meshes {
    pub(super) fn open(folder: &Path) -> Result<Self> {
        let read = |name: &str| -> Result<Vec<ReadPart>> {
            let bytes = input::read(&folder.join(name), MOST_MESH_BYTES).with_context(|| name.to_owned())?;
            read_glb(&bytes).with_context(|| name.to_owned())
        };
        let part = read(WORKPIECE_FILE)?.into_iter().next().context("workpiece.glb holds no mesh")?;
        let welded = read(WELDED_FILE)?;
        ensure!(
            welded.len() >= 2,
            "welded.glb holds {} meshes; the part and at least one bead are expected",
            welded.len()
        );
        let surface = read(SURFACE_FILE).context(
            "the welded surface; an asset of an earlier version lacks it and is made anew by `robofin weld`",
        )?;
        Ok(Self { part, welded, surface })
    }

    /// Box around all meshes of the welded workpiece [m].
    pub(super) fn welded_bounds(&self) -> Option<(DVec3, DVec3)> {
        let boxes = self.welded.iter().filter_map(|part| part.mesh.bounds());
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The beads with their weld ids.
    pub(super) fn beads(&self) -> impl Iterator<Item = &ReadPart> {
        self.welded.iter().filter(|part| part.weld_id != 0)
    }
}

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
