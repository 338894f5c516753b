//! The zero set as a closed triangle mesh with sharp edges.
//!
//! Dual: each piece of the surface in a cell is a vertex (`cell.rs`), placed where the tangent planes that the voxels know
//! meet (`place.rs`); each lattice edge with a sign change is a quad between the four cells around it. Every edge of
//! the mesh is where a piece passes through a face of a cell, so it has two quads. One piece that passes twice through a
//! face into a piece that does the same would give an edge four; turning the pairs of that face splits both pieces
//! (after Wenger 2013, "Isosurfaces", ch. 3). The mesh is a closed, oriented manifold whatever the values are.

mod cell;
mod cells;
mod place;

use glam::IVec3;
use rayon::prelude::*;

use crate::grid::BrickGrid;
use crate::mesh::Mesh;
use cell::edge_ends;
use cells::{CellMap, Corner};

impl BrickGrid {
    /// The surface {φ = 0} as a closed manifold mesh with outward triangles; sharp edges and corners are kept.
    ///
    /// Vertices and triangles are in the order of the bricks' coordinates, whatever the number of threads. Walls
    /// and gaps thinner than a voxel may be absent.
    pub fn surface_mesh(&self) -> Mesh {
        let map = CellMap::of(self);
        let vertices = map.vertices(self);
        let quads: Vec<[u32; 3]> =
            map.bricks().par_iter().flat_map_iter(|brick| brick_triangles(&map, brick, &vertices)).collect();
        Mesh { positions: vertices.into_iter().map(|vertex| vertex.at).collect(), triangles: quads }
    }

    /// Area of {φ = 0} [m²]: that of [`BrickGrid::surface_mesh`]. Second order in the voxel size; exact where the surface
    /// is made of planes.
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

/// Two triangles of a quad: along the sharp edge if it runs from corner to corner, else along the shorter diagonal.
fn split([a, b, c, d]: [u32; 4], vertices: &[Corner]) -> [[u32; 3]; 2] {
    let at = |vertex: u32| vertices[vertex as usize];
    let sharp = |p: u32, q: u32| at(p).sharp && at(q).sharp;
    let length = |p: u32, q: u32| at(p).at.distance_squared(at(q).at);
    let first = match (sharp(a, c), sharp(b, d)) {
        (true, false) => true,
        (false, true) => false,
        _ => length(a, c) <= length(b, d),
    };
    if first { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
}
