//! The zero set as a closed triangle mesh with sharp edges.
//!
//! Dual: each piece of the surface in a cell is a vertex (`cell.rs`), placed where the tangent planes that the voxels know
//! meet (`place.rs`); each lattice edge with a sign change is a quad between the four cells around it. Every edge of
//! the mesh is where a piece passes through a face of a cell, so it has two quads. One piece that passes twice through a
//! face into a piece that does the same would give an edge four; turning the pairs of that face splits both pieces
//! (after Wenger 2013, "Isosurfaces", ch. 3). The mesh is a closed, oriented manifold whatever the values are.

mod around;
mod cell;
mod cells;
mod place;

use glam::IVec3;
use rayon::prelude::*;

use crate::grid::BrickGrid;
use crate::mesh::Mesh;
use cell::edge_ends;
use cells::{CellMap, Corner};
use place::Shape;

impl BrickGrid {
    /// The surface {φ = 0} as a closed manifold mesh with outward triangles; sharp edges and corners are kept.
    ///
    /// Vertices and triangles are in the order of the bricks' coordinates, whatever the number of threads. Walls
    /// and gaps thinner than a voxel may be absent. Where baking closed a hole for the sign only, the surface is where φ
    /// jumps.
    pub fn surface_mesh(&self) -> Mesh {
        let map = CellMap::of(self);
        let vertices = map.vertices(self);
        let triangles =
            map.bricks().par_iter().flat_map_iter(|brick| brick_triangles(&map, brick, &vertices)).collect();
        Mesh { positions: vertices.into_iter().map(|vertex| vertex.at).collect(), triangles }
    }

    /// Area of {φ = 0} [m²]: that of [`BrickGrid::surface_mesh`]. Second order in the voxel size on smooth parts; next to
    /// sharp edges thin triangles may fold and add to it (`docs/fields.md` has figures).
    pub fn area(&self) -> f64 {
        self.surface_mesh().area()
    }
}

/// Triangles of the lattice edges that start at the voxels of a brick.
fn brick_triangles(map: &CellMap, brick: &cells::Brick, vertices: &[Corner]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for cell in &brick.cells {
        let voxel = brick.voxel(cell);
        for axis in 0..3 {
            let edge = 4 * axis;
            if !cell.signs.is_crossed(edge) {
                continue;
            }
            let mut quad = around(map, voxel, axis);
            if !cell.signs.is_inside(edge_ends(edge).0) {
                quad.reverse();
            }
            triangles.extend(split(quad, vertices));
        }
    }
    triangles
}

/// Vertices of the four cells around the edge from `voxel` along an axis, counter-clockwise against that axis.
fn around(map: &CellMap, voxel: IVec3, axis: usize) -> [u32; 4] {
    let (u, v) = (IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]);
    [(0, 0), (1, 0), (1, 1), (0, 1)]
        .map(|(i, j)| map.vertex(voxel - u * i - v * j, 4 * axis + 2 * i as usize + j as usize))
}

/// Two triangles of a quad. At an outer edge the diagonal that stands out is on the surface, at an inner one that which
/// lies deeper; elsewhere the shorter is taken.
fn split([a, b, c, d]: [u32; 4], vertices: &[Corner]) -> [[u32; 3]; 2] {
    let [p, q, r, s] = [a, b, c, d].map(|vertex| vertices[vertex as usize].at);
    let shapes = [a, b, c, d].map(|vertex| vertices[vertex as usize].shape);
    let first_stands_out = (r - p).cross(s - q).dot((p + r) - (q + s)) > 0.0;
    let first = match (shapes.contains(&Shape::Outer), shapes.contains(&Shape::Inner)) {
        (true, false) => first_stands_out,
        (false, true) => !first_stands_out,
        _ => p.distance_squared(r) <= q.distance_squared(s),
    };
    if first { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}
