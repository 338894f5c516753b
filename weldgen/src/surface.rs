//! A part prepared for welds: data shared by all proposals on it.

use std::sync::{Arc, Mutex, OnceLock};

use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::bake::WindingTree;
use sdf_bake::query::MeshQuery;

use crate::seam::{Seam, find_seams};
use crate::strata::ExposureField;
use crate::topology::Topology;

/// A part with its topology, areas and winding numbers; built once, used for any number of welds.
pub struct Surface<'a> {
    /// The part.
    pub part: &'a Mesh,
    /// Closest-point and ray queries on it.
    pub query: &'a MeshQuery,
    /// Its edges.
    pub topology: Topology,
    /// Cumulative sum of the triangles' areas [m²].
    pub(crate) areas: Vec<f64>,
    pub(crate) winding: WindingTree,
    /// Exposure fields measured so far, with their reach [m].
    fields: Mutex<Vec<(f64, Arc<ExposureField>)>>,
    seams: OnceLock<Vec<Seam>>,
}

impl<'a> Surface<'a> {
    /// Prepares a part; `query` must belong to the same mesh.
    pub fn new(part: &'a Mesh, query: &'a MeshQuery) -> Self {
        let (topology, areas) = (Topology::new(part), running_areas(part));
        Self {
            part,
            query,
            topology,
            areas,
            winding: WindingTree::new(part),
            fields: Mutex::default(),
            seams: OnceLock::new(),
        }
    }

    /// Exposure over the whole part for a reach [m]; measured once.
    pub fn exposure_field(&self, reach: f64) -> Arc<ExposureField> {
        let known =
            |fields: &[(f64, Arc<ExposureField>)]| fields.iter().find(|(r, _)| *r == reach).map(|f| f.1.clone());
        let lock = || self.fields.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(field) = known(&lock()) {
            return field;
        }
        // Computed without the lock: the rays run on several threads, which may call this function.
        let field = Arc::new(ExposureField::measure(self, reach));
        lock().push((reach, field.clone()));
        field
    }

    /// Concave edges where a fillet weld can run; found once.
    pub fn seams(&self) -> &[Seam] {
        self.seams.get_or_init(|| find_seams(self.part, &self.topology))
    }

    /// Returns the triangle at a cumulative share of the area, in [0, 1), and barycentric coordinates that are uniform
    /// over it for uniform inputs.
    pub(crate) fn place_at(&self, share: f64, [root, along]: [f64; 2]) -> (u32, [f64; 3]) {
        let face = self.areas.partition_point(|sum| *sum <= share * self.area()).min(self.areas.len() - 1);
        // The square root makes the density uniform (Osada et al. 2002).
        let root = root.sqrt();
        (face as u32, [1.0 - root, root * (1.0 - along), root * along])
    }

    /// True if the winding number at a point just above the surface is that of open space.
    ///
    /// It is 1 above a face inside another body and -1 in a body that is turned inside out; above an open sheet it can
    /// be as low as -1/2.
    pub(crate) fn is_open_space(&self, above: DVec3) -> bool {
        (-0.75..0.5).contains(&self.winding.winding_number(above))
    }

    /// Surface area [m²] of the triangles with positive area.
    pub fn area(&self) -> f64 {
        self.areas.last().copied().unwrap_or(0.0)
    }
}

fn running_areas(part: &Mesh) -> Vec<f64> {
    let area = |t: usize| Some(0.5 * part.doubled_area_normal(t).length()).filter(|a| a.is_finite()).unwrap_or(0.0);
    let add = |sum: &mut f64, t: usize| {
        *sum += area(t);
        Some(*sum)
    };
    (0..part.triangles.len()).scan(0.0, add).collect()
}
