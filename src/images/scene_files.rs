//! Files that the scenes of a set use: the picture of the surroundings, the meshes among the clutter.

use std::path::Path;

use anyhow::{Context, Result, anyhow, ensure};
use files::folder::write_file;
use files::input::{self, MOST_MESH_BYTES};
use perception::{ClutterMesh, Scene, SceneFiles, Seeds, environment_map, standing_height};
use sdf_bake::BrickGrid;
use sdf_bake::read::UnitChoice;
use serde::{Deserialize, Serialize};

use super::{FIELDS_FOLDER, ImageSet};
use crate::cache::find_meshes;
use crate::part::{Part, sha256};

/// A picture by path and content.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnvironmentFile {
    /// Path as given.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
}

/// A folder of meshes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClutterFolder {
    /// Path as given.
    pub folder: String,
    /// Its meshes, by path.
    pub meshes: Vec<ClutterFile>,
    /// Reasons why other meshes are left out, each with its path.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
}

/// A mesh by path and content.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClutterFile {
    /// Path.
    pub file: String,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Height at which it stands, as in [`standing_height`].
    pub height: f64,
}

impl EnvironmentFile {
    /// Reads and checks a picture.
    ///
    /// # Errors
    /// If it cannot be read, or is no equirectangular picture in the Radiance format.
    pub fn of(file: &Path) -> Result<Self> {
        let bytes = input::read(file, MOST_MESH_BYTES)?;
        environment_map(&bytes).with_context(|| format!("--environment {}", file.display()))?;
        Ok(Self { file: file.display().to_string(), sha256: sha256(&bytes) })
    }
}

impl ClutterFolder {
    /// Reads and checks all meshes below a folder; those that are open, unreadable or ambiguous are left out.
    ///
    /// # Errors
    /// If none is left.
    pub fn of(folder: &Path) -> Result<Self> {
        let (mut meshes, mut left_out) = (Vec::new(), Vec::new());
        for (path, fault) in find_meshes(&[folder.to_owned()])? {
            let file = fault.map_or_else(|| ClutterFile::of(&path), |fault| Err(anyhow!(fault)));
            match file.with_context(|| path.display().to_string()) {
                Ok(file) => meshes.push(file),
                Err(why) => left_out.push(format!("{why:#}")),
            }
        }
        ensure!(!meshes.is_empty(), "--clutter: no mesh can be used: {}", left_out.join("; "));
        Ok(Self { folder: folder.display().to_string(), meshes, left_out })
    }
}

impl ClutterFile {
    fn of(path: &Path) -> Result<Self> {
        let part = Part::load(path, UnitChoice::Auto)?;
        let open = part.cleaning.boundary_edges;
        ensure!(open == 0, "{open} boundary edges, and a closed mesh is accepted");
        ClutterMesh::of(&part.mesh)?;
        let height = standing_height(&part.mesh);
        Ok(Self { file: path.display().to_string(), sha256: part.source.sha256, height })
    }

    /// Reads the mesh as it was baked into a folder, or bakes it there.
    fn mesh(&self, folder: &Path) -> Result<ClutterMesh> {
        let kept = folder.join(format!("clutter-{}.nvdb", self.sha256));
        if kept.is_file() {
            return Ok(ClutterMesh::from_nvdb(&input::read(&kept, MOST_MESH_BYTES)?)?);
        }
        let part = Part::load(Path::new(&self.file), UnitChoice::Auto)?;
        ensure!(part.source.sha256 == self.sha256, "{}: not the mesh that the set was started with", self.file);
        let mesh = ClutterMesh::of(&part.mesh)?;
        write_file(&kept, &mesh.to_nvdb()?)?;
        Ok(mesh)
    }
}

impl ImageSet {
    /// Draws a scene of a part, and reads the files that it uses.
    ///
    /// # Errors
    /// If the part has no surface, or a file cannot be read or has changed.
    pub fn scene(&self, part: &BrickGrid, seeds: &Seeds) -> Result<(Scene, SceneFiles)> {
        let mut scene = Scene::draw(part, seeds, self.recipe.size, &self.recipe.looks)?;
        let mut files = SceneFiles::default();
        if let Some(EnvironmentFile { file, sha256: expected }) = &self.recipe.environment {
            let bytes = input::read(Path::new(file), MOST_MESH_BYTES)?;
            ensure!(sha256(&bytes) == *expected, "{file}: not the picture that the set was started with");
            files.environment = Some(environment_map(&bytes)?);
            scene = scene.surrounded(seeds);
        }
        if let Some(ClutterFolder { meshes, .. }) = &self.recipe.clutter {
            let heights: Vec<f64> = meshes.iter().map(|mesh| mesh.height).collect();
            scene = scene.with_meshes(part, seeds, &heights)?;
            for mesh in scene.obstacles.iter().filter_map(|thing| thing.mesh) {
                files.meshes.insert(mesh, meshes[mesh].mesh(&self.folder().join(FIELDS_FOLDER))?);
            }
        }
        Ok((scene, files))
    }
}
