//! Extracts the zero set as a closed triangle mesh with sharp edges.
//!
//! The method is dual: each piece of the surface in a cell is a vertex (`cell.rs`), placed where the tangent planes of
//! the voxels meet (`place.rs`); each lattice edge with a sign change is a quad between the four cells around it. Every
//! edge of the mesh corresponds to a piece that passes through a face of a cell, so it has two quads. If one piece
//! passes twice through a face into a piece that does the same, an edge would have four; exchanging the pairs of that
//! face splits both pieces (after Wenger 2013, "Isosurfaces", ch. 3). No two vertices coincide (`settle.rs`), so the
//! mesh is a closed, oriented manifold for any values, both as it is and once equal positions are merged.

mod around;
mod cell;
mod cells;
mod place;
mod settle;
mod triangles;

use glam::DVec3;
use rayon::prelude::*;

use crate::grid::BrickGrid;
use crate::mesh::Mesh;
use cells::{Brick, CellMap};
use triangles::{Split, quads, split};

impl BrickGrid {
    /// The surface {φ = 0} as a closed manifold mesh with outward triangles; sharp edges and corners are kept.
    ///
    /// In single precision as well, no two vertices coincide and no triangle has zero area, if a voxel is at least 32
    /// units in the last place of the largest coordinate. Vertices and triangles are in the order of the bricks'
    /// coordinates, for any number of threads. Walls and gaps thinner than a voxel may be missing. Where baking closed
    /// a hole for the sign only, the surface is at the jump of φ.
    pub fn surface_mesh(&self) -> Mesh {
        let split = Split { voxel: self.voxel, inset: settle::inset(self) };
        let map = CellMap::of(self, split.inset);
        let mut vertices = map.vertices(self, split.inset);
        let quads: Vec<_> = map.bricks().par_iter().flat_map_iter(|brick| quads(&map, brick)).collect();
        settle::settle(&mut vertices, &quads, &map, &split);
        let triangles = quads.par_iter().flat_map_iter(|&quad| split.triangles(quad, &vertices)).collect();
        Mesh { positions: vertices.into_iter().map(|vertex| vertex.at * self.voxel).collect(), triangles }
    }

    /// Sums `of` over the triangles of [`BrickGrid::surface_mesh`] before any vertex is moved home, given their corners
    /// [voxels], in the order of the bricks' coordinates.
    pub(crate) fn surface_sums(&self, of: impl Fn([DVec3; 3]) -> [f64; 2] + Sync) -> [f64; 2] {
        let inset = settle::inset(self);
        let map = CellMap::of(self, inset);
        let vertices = map.vertices(self, inset);
        let add = |sum: [f64; 2], more: [f64; 2]| [sum[0] + more[0], sum[1] + more[1]];
        let of_brick = |brick: &Brick| {
            let triangles =
                quads(&map, brick).into_iter().flat_map(|quad| split(quad.map(|vertex| vertices[vertex as usize])));
            triangles.map(&of).fold([0.0; 2], add)
        };
        let sums: Vec<[f64; 2]> = map.bricks().par_iter().map(of_brick).collect();
        sums.into_iter().fold([0.0; 2], add)
    }

    /// Area of {φ = 0} [m²]: that of [`BrickGrid::surface_mesh`]. Second order in the voxel size on smooth parts; next
    /// to sharp edges thin triangles may fold and increase it (`docs/fields.md` has figures).
    pub fn area(&self) -> f64 {
        self.surface_mesh().area()
    }
}
