//! Clutter from meshes: things of other people's shapes on the table and on the workpiece.

use std::collections::BTreeMap;

use glam::{DQuat, DVec2, DVec3};
use random::Stream;
use sdf_bake::nvdb::{self, BricksError, Codec, NvdbError, WriteError};
use sdf_bake::{BakeError, BakeOptions, BrickGrid, Mesh, bake};
use thiserror::Error;

use crate::clutter::{ObstacleDraw, ObstacleShape, Places, below};
use crate::scene::{NoSurface, Scene, Seeds};

/// Distance between voxels [radii of the mesh].
const VOXEL: f64 = 1.0 / 40.0;
/// Truncation distance [voxels]; far enough for a small thing on the lattice of a workpiece.
const BAND: f64 = 6.0;
/// Greatest number of meshes beside the workpiece.
const MOST_BESIDE: usize = 4;
/// Share of the placements with a mesh on the workpiece.
const ON_TOP: f64 = 0.25;

/// A mesh as a distance field of radius 1 about the middle of its box.
#[derive(Clone, Debug)]
pub struct ClutterMesh(BrickGrid);

/// A file holds no baked mesh.
#[derive(Debug, Error)]
pub enum NoClutterMesh {
    /// It is no NanoVDB file.
    #[error(transparent)]
    File(#[from] NvdbError),
    /// It holds no distance field.
    #[error(transparent)]
    Field(#[from] BricksError),
}

/// Meshes by their place in the list of a set.
pub type ClutterMeshes = BTreeMap<usize, ClutterMesh>;

impl ClutterMesh {
    /// Bakes a cleaned mesh, z up. Its size does not matter: sizes are drawn.
    ///
    /// # Errors
    /// [`BakeError`] if it is empty or its inside is ambiguous.
    pub fn of(mesh: &Mesh) -> Result<Self, BakeError> {
        let (low, high) = mesh.bounds().unwrap_or_default();
        let (middle, radius) = (low.midpoint(high), 0.5 * low.distance(high));
        let positions = mesh.positions.iter().map(|vertex| (*vertex - middle) / radius).collect();
        let unit = Mesh { positions, ..mesh.clone() };
        let options = BakeOptions { band_voxels: BAND, ..BakeOptions::with_voxel(VOXEL) };
        Ok(Self(bake(&unit, &options)?.0))
    }

    /// Returns it as a NanoVDB file.
    ///
    /// # Errors
    /// [`WriteError`] if it is too large for the format.
    pub fn to_nvdb(&self) -> Result<Vec<u8>, WriteError> {
        nvdb::write_field(&self.0, Codec::None)
    }

    /// Reads what [`Self::to_nvdb`] returned.
    ///
    /// # Errors
    /// [`NoClutterMesh`] for other bytes.
    pub fn from_nvdb(bytes: &[u8]) -> Result<Self, NoClutterMesh> {
        Ok(Self(nvdb::read(bytes)?.to_field()?))
    }

    /// Signed distance at a point [radii], truncated.
    pub(crate) fn distance(&self, point: DVec3) -> f64 {
        f64::from(self.0.sample(point))
    }
}

/// Half the height of a mesh's box relative to half its diagonal, by which it stands on the table.
pub fn standing_height(mesh: &Mesh) -> f64 {
    let (low, high) = mesh.bounds().unwrap_or_default();
    (high.z - low.z) / low.distance(high)
}

impl Scene {
    /// The same scene with further things around the workpiece: up to four beside it, in some placements one on it. Each
    /// is one of `heights` meshes, given by [`standing_height`].
    ///
    /// # Errors
    /// If the field has no surface.
    pub fn with_meshes(mut self, part: &BrickGrid, seeds: &Seeds, heights: &[f64]) -> Result<Self, NoSurface> {
        if heights.is_empty() {
            return Ok(self);
        }
        let stream = &mut Stream::of(seeds.placement, "clutter meshes");
        let places = Places::of(part, &self.placement)?;
        let beside = 1 + stream.below(MOST_BESIDE);
        self.obstacles.extend((0..beside).map(|_| places.mesh_beside(heights, stream)));
        if stream.happens(ON_TOP) {
            let pose = self.placement.pose();
            self.obstacles.extend(places.mesh_on_top(|above| below(part, &pose, above), heights, stream));
        }
        Ok(self)
    }
}

impl Places {
    /// A mesh that stands on the table, turned by any angle.
    fn mesh_beside(&self, heights: &[f64], stream: &mut Stream) -> ObstacleDraw {
        let radius = self.reach() * stream.ratio_between([0.12, 0.6]);
        let mesh = stream.below(heights.len());
        let place = self.outside(radius, stream).extend(self.table + radius * heights[mesh]);
        ObstacleDraw::of_mesh((mesh, radius), place, stream)
    }

    /// A small mesh on the workpiece, if `down` from the drawn place meets it.
    fn mesh_on_top(
        &self,
        down: impl Fn(DVec3) -> Option<DVec3>,
        heights: &[f64],
        stream: &mut Stream,
    ) -> Option<ObstacleDraw> {
        let radius = self.reach() * stream.ratio_between([0.08, 0.2]);
        let mesh = stream.below(heights.len());
        let share = DVec2::new(stream.between([0.15, 0.85]), stream.between([0.15, 0.85]));
        let foot = down(self.above(share))?;
        Some(ObstacleDraw::of_mesh((mesh, radius), foot + DVec3::Z * (radius * heights[mesh]), stream))
    }
}

impl ObstacleDraw {
    fn of_mesh((mesh, radius): (usize, f64), position_m: DVec3, stream: &mut Stream) -> Self {
        let turn = DQuat::from_rotation_z(stream.between([0.0, std::f64::consts::TAU]));
        let body = (ObstacleShape::Mesh, DVec3::new(radius, 0.0, 0.0));
        Self { mesh: Some(mesh), ..Self::of(body, turn, position_m, stream) }
    }
}

#[cfg(test)]
mod tests {
    use render::VisibleObject;

    use super::*;
    use crate::{SceneFiles, Shape, View};

    /// A square pyramid of height 2 on a base of side 2, off the origin.
    fn pyramid() -> Mesh {
        let corners = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 2.0, 0.0], [0.0, 2.0, 0.0], [1.0, 1.0, 2.0]];
        let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
        Mesh { positions: corners.map(|corner| DVec3::from_array(corner) + 5.0).to_vec(), triangles }
    }

    #[test]
    fn a_mesh_is_centred_scaled_and_stands_on_its_box() {
        let mesh = ClutterMesh::of(&pyramid()).unwrap();
        // Half the diagonal of a box of side 2 is √3, so its half height is 1 / √3.
        let half = 1.0 / 3f64.sqrt();
        assert!((standing_height(&pyramid()) - half).abs() < 1e-12);
        assert!(mesh.distance(DVec3::new(0.0, 0.0, -half)).abs() < 0.01);
        assert!(mesh.distance(DVec3::ZERO) < 0.0 && mesh.distance(DVec3::new(half, half, half)) > 0.0);
        let kept = ClutterMesh::from_nvdb(&mesh.to_nvdb().unwrap()).unwrap();
        let points = (0..500).map(|i| DVec3::new(0.011, -0.007, 0.003) * f64::from(i - 250));
        assert!(points.into_iter().all(|point| kept.distance(point) == mesh.distance(point)));
        assert!(ClutterMesh::from_nvdb(b"no").is_err());
        let mut open = pyramid();
        open.triangles.truncate(1);
        assert!(ClutterMesh::of(&open).is_err());
        assert!(ClutterMesh::of(&Mesh::default()).is_err());
    }

    #[test]
    fn meshes_stand_on_the_table_and_are_seen_beside_the_other_things() {
        let part = Shape::Panel.field(2e-3);
        let heights = [standing_height(&pyramid())];
        let files = SceneFiles { meshes: [(0, ClutterMesh::of(&pyramid()).unwrap())].into(), ..SceneFiles::default() };
        let mut seen = 0;
        for placement in 0..12 {
            let seeds = Seeds { placement, image: 3 };
            let plain = Scene::draw(&part, &seeds, (96, 72), &[]).unwrap();
            assert_eq!(plain.clone().with_meshes(&part, &seeds, &[]), Ok(plain.clone()));
            let scene = plain.with_meshes(&part, &seeds, &heights).unwrap();
            let foot = |thing: &ObstacleDraw| thing.position_m.z - thing.size_m.x * heights[0];
            assert!(scene.obstacles.iter().all(|thing| foot(thing) > scene.placement.table_m - 1e-12));
            let (_, frame) = View::of(&part, &scene, (96, 72), &files).unwrap();
            seen += frame.buffers.seen.iter().filter(|seen| **seen == VisibleObject::Obstacle).count();
        }
        assert!(seen > 300, "{seen}");
    }
}
