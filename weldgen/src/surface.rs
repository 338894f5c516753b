//! A part made ready for welds: what every proposal on it shares.

use sdf_bake::Mesh;
use sdf_bake::bake::WindingTree;
use sdf_bake::query::MeshQuery;

use crate::topology::Topology;

/// A part with its neighbourhoods, areas and winding numbers; built once, used for any number of welds.
pub struct Surface<'a> {
    /// The part.
    pub part: &'a Mesh,
    /// Closest points and rays on it.
    pub query: &'a MeshQuery,
    /// Its edges.
    pub topology: Topology,
    /// Running sum of the triangles' areas [m²].
    pub(crate) areas: Vec<f64>,
    pub(crate) winding: WindingTree,
}

impl<'a> Surface<'a> {
    /// Prepares a part; `query` must be of the same mesh.
    pub fn new(part: &'a Mesh, query: &'a MeshQuery) -> Self {
        let (topology, areas) = (Topology::new(part), running_areas(part));
        Self { part, query, topology, areas, winding: WindingTree::new(part) }
    }

    /// Surface area [m²] of the triangles that have one.
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
