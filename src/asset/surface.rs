//! Surface of the welded workpiece as one mesh, and the files that follow from it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use files::input::{self, MOST_MESH_BYTES};

use super::SURFACE_FILE;
use super::check::{Check, Opened, Validation};
use super::exporter::{Content, Exporter};
use super::meshes::GLB;
use export::models::{MODEL_FILES, Reference};
use export::surface::WeldedSurface;

/// Exporter of `surface.glb`: the surface, in pieces by weld id.
pub(super) struct Surface;
/// Exporter of a row of [`MODEL_FILES`]: mass, light meshes, robot models.
pub(super) struct Model<const ROW: usize>;

impl Exporter for Surface {
    const FILE: &'static str = SURFACE_FILE;
    const MEDIA_TYPE: &'static str = GLB;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        fs::write(place, content.surface.write_glb()?).with_context(|| SURFACE_FILE.to_owned())
    }
}

impl<const ROW: usize> Exporter for Model<ROW> {
    const FILE: &'static str = MODEL_FILES[ROW].file;
    const MEDIA_TYPE: &'static str = MODEL_FILES[ROW].media_type;
    const ALWAYS: bool = false;

    fn write(content: &Content<'_>, place: &Path) -> Result<()> {
        match &content.models {
            Some(models) if content.extras.models || !MODEL_FILES[ROW].slow => {
                Ok(fs::write(place, (MODEL_FILES[ROW].write)(models)?)?)
            }
            _ => Ok(()),
        }
    }

    fn check(opened: &Opened<'_>, found: &mut Validation) -> Result<()> {
        let (Some(meshes), Some(fields)) = (&opened.meshes, &opened.fields) else { return Ok(()) };
        if opened.manifest.files.contains_key(Self::FILE) {
            let pieces = meshes.surface.iter().map(|piece| (piece.weld_id, piece.mesh.clone())).collect();
            let reference = Reference { surface: WeldedSurface { pieces }, voxel: fields.welded.voxel };
            let bytes = input::read(&opened.folder.join(Self::FILE), MOST_MESH_BYTES).map_err(|e| e.to_string());
            let result = bytes.and_then(|bytes| (MODEL_FILES[ROW].check)(&bytes, &reference));
            let passed = result.is_ok();
            let figures = result.unwrap_or_else(|fault| fault);
            found.checks.push(Check::new(Self::FILE, "agrees with surface.glb", passed, figures));
        }
        Ok(())
    }
}
