//! Surface of the welded workpiece as one mesh.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use sdf_bake::{BrickGrid, Mesh};

use super::SURFACE_FILE;
use super::exporter::{Content, Exporter};
use super::meshes::GLB;
use crate::workpiece::Workpiece;
use export::glb::{GlbMaterial, GlbPart, write_surface_glb};

/// Least distance of a triangle's centre outside the bare part for weld metal [voxels].
const OFF_PART: f32 = 0.1;

/// Exporter of `surface.glb`: the surface, in pieces by weld id.
pub(super) struct Surface;

impl Exporter for Surface {
    const FILE: &'static str = SURFACE_FILE;
    const MEDIA_TYPE: &'static str = GLB;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        let Workpiece { welded, target, .. } = content.workpiece;
        let pieces = pieces(&welded.surface_mesh(), welded, target);
        let parts: Vec<GlbPart<'_>> = pieces
            .iter()
            .map(|(&weld_id, mesh)| {
                let material = if weld_id == 0 { GlbMaterial::Base } else { GlbMaterial::Weld };
                GlbPart { name: SURFACE_NAME, mesh, weld_id, material }
            })
            .collect();
        let bytes = write_surface_glb(SURFACE_NAME, &parts)?;
        fs::write(place, bytes).with_context(|| SURFACE_FILE.to_owned())
    }
}

/// Name of the mesh.
const SURFACE_NAME: &str = "surface";

/// Splits the triangles by weld id; each piece has its own vertices.
fn pieces(surface: &Mesh, welded: &BrickGrid, target: &BrickGrid) -> BTreeMap<u16, Mesh> {
    let off_part = OFF_PART * welded.voxel as f32;
    let mut pieces: BTreeMap<u16, (Mesh, Vec<u32>)> = BTreeMap::new();
    for (triangle, corners) in surface.triangles.iter().enumerate() {
        let [a, b, c] = surface.corners(triangle);
        let middle = (a + b + c) / 3.0;
        let label = welded.label(middle);
        let id = if label != 0 && target.sample(middle) > off_part { label } else { 0 };
        let (piece, known) =
            pieces.entry(id).or_insert_with(|| (Mesh::default(), vec![u32::MAX; surface.positions.len()]));
        piece.triangles.push(corners.map(|vertex| {
            let place = &mut known[vertex as usize];
            if *place == u32::MAX {
                *place = piece.positions.len() as u32;
                piece.positions.push(surface.positions[vertex as usize]);
            }
            *place
        }));
    }
    pieces.into_iter().map(|(id, (piece, _))| (id, piece)).collect()
}
