//! Meshes of an asset: writes and reads its glTF files.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use files::input::{self, MOST_MESH_BYTES};
use glam::DVec3;

use super::exporter::{Content, Exporter};
use super::{SURFACE_FILE, WELDED_FILE, WORKPIECE_FILE};
use export::glb::{GlbMaterial, GlbPart, write_glb};
use export::glb_read::{ReadPart, read_glb};

/// Exporter of `workpiece.glb`: the bare part.
pub(super) struct PartMesh;
/// Exporter of `welded.glb`: the bare part, and a closed bead for each weld.
pub(super) struct WeldedMeshes;

/// Media type of binary glTF.
pub(super) const GLB: &str = "model/gltf-binary";

impl Exporter for PartMesh {
    const FILE: &'static str = WORKPIECE_FILE;
    const MEDIA_TYPE: &'static str = GLB;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        Ok(fs::write(place, write_glb(&[base(content)], serde_json::Map::new())?)?)
    }
}

impl Exporter for WeldedMeshes {
    const FILE: &'static str = WELDED_FILE;
    const MEDIA_TYPE: &'static str = GLB;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        let welds = &content.workpiece.welds;
        let names: Vec<String> = welds.iter().map(|placed| format!("weld-{}", placed.id)).collect();
        let beads = welds.iter().zip(&names).map(|(placed, name)| GlbPart {
            name,
            mesh: &placed.weld.bead,
            weld_id: placed.id,
            material: GlbMaterial::Weld,
        });
        let parts: Vec<GlbPart<'_>> = std::iter::once(base(content)).chain(beads).collect();
        Ok(fs::write(place, write_glb(&parts, serde_json::Map::new())?)?)
    }
}

fn base<'a>(content: &Content<'a>) -> GlbPart<'a> {
    GlbPart { name: "base", mesh: &content.workpiece.part.mesh, weld_id: 0, material: GlbMaterial::Base }
}

/// Meshes of an asset, read from its glTF files.
pub struct Meshes {
    /// The bare part.
    pub part: ReadPart,
    /// Welded workpiece: the part, then one bead for each weld.
    pub welded: Vec<ReadPart>,
    /// Pieces of the welded surface, one for each weld id.
    pub surface: Vec<ReadPart>,
}

impl Meshes {
    /// Reads the meshes of an asset folder.
    ///
    /// # Errors
    /// If a file is missing or damaged, or lacks the part, a bead or the surface.
    pub fn open(folder: &Path) -> Result<Self> {
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
            "the welded surface; an asset of an earlier version lacks it and is made again by `robofin weld`",
        )?;
        Ok(Self { part, welded, surface })
    }

    /// Returns the bounding box of all meshes of the welded workpiece [m].
    pub fn welded_bounds(&self) -> Option<(DVec3, DVec3)> {
        let boxes = self.welded.iter().filter_map(|part| part.mesh.bounds());
        boxes.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Returns the beads with their weld ids.
    pub fn beads(&self) -> impl Iterator<Item = &ReadPart> {
        self.welded.iter().filter(|part| part.weld_id != 0)
    }
}
