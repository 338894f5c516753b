//! Gives every vertex a unique position.
//!
//! A vertex may lie outside its cell, on an edge or corner of the surface, or on the cell's border, where a face of the
//! part is a plane of the lattice. Several vertices may then have one position, and three may lie on one line; merged
//! by position, the mesh would not be a manifold. So the first vertex keeps the position, and the others move to their
//! homes: positions well within their cells, where no two vertices meet. The quad of four home vertices in the four
//! cells around a lattice edge has a diagonal that gives two triangles of nonzero area: seen along the edge the
//! vertices are in four different quadrants, and a line through one of them and its two neighbours misses the fourth.

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::around::CellSurroundings;
use super::cells::{CellMap, Corner};
use super::triangles::{Quad, Split};
use crate::grid::{BRICK_SIDE, BrickGrid, cell_corner};

/// Distance of homes from the borders of their cells [voxels], if single precision allows it.
const INSET: f64 = 1e-3;
/// [`INSET`] in units in the last place of single precision; two homes then differ after rounding.
const INSET_STEPS: f64 = 4.0;
/// Greatest inset [voxels]; above it the voxels are too small for coordinates in single precision.
const LARGEST_INSET: f64 = 0.125;

/// Distance of homes from the borders of their cells [voxels].
///
/// It is also the depth inside the surface from which a lattice point counts as inside. Otherwise rounding would put a
/// face of the part that is a plane of the lattice on different sides from point to point. A mesh in single precision
/// has errors of half a unit in the last place.
pub(super) fn inset(grid: &BrickGrid) -> f64 {
    let bricks = grid.origin.abs().max((grid.origin + grid.dims).abs()).max_element();
    // Units in the last place are at most 2⁻²³ of the coordinate.
    let step = f64::from(bricks) * BRICK_SIDE as f64 * f64::from(f32::EPSILON);
    INSET.max(INSET_STEPS * step).min(LARGEST_INSET)
}

/// Moves vertices home until no two coincide and no quad requires a triangle of zero area.
pub(super) fn settle(vertices: &mut [Corner], quads: &[Quad], map: &CellMap, split: &Split) {
    let mut settling = Settling { vertices, map, inset: split.inset, claims: Claims::default() };
    for vertex in settling.farthest_first() {
        if settling.is_home(vertex) {
            continue;
        }
        if settling.near(vertex).is_empty() { settling.claim(vertex) } else { settling.send_home(vertex) }
    }
    loop {
        let of = |quad: &Quad| quad.map(|vertex| settling.vertices[vertex as usize]);
        let flat: Vec<Quad> = quads.par_iter().filter(|quad| split.is_flat(of(quad))).copied().collect();
        let away: Vec<u32> = flat.iter().filter_map(|quad| settling.farthest_from_home(quad)).collect();
        if away.is_empty() {
            return;
        }
        away.into_iter().for_each(|vertex| settling.send_home(vertex));
    }
}

struct Settling<'a> {
    vertices: &'a mut [Corner],
    map: &'a CellMap,
    inset: f64,
    claims: Claims,
}

/// Vertices that keep a position outside their homes, by the cell that contains it.
#[derive(Default)]
struct Claims {
    /// Last vertex in each cell, as its index in `chain`.
    last: HashMap<IVec3, usize>,
    /// A vertex and the index of the previous one in its cell.
    chain: Vec<(u32, Option<usize>)>,
}

impl Claims {
    fn add(&mut self, cell: IVec3, vertex: u32) {
        let before = self.last.insert(cell, self.chain.len());
        self.chain.push((vertex, before));
    }

    fn within(&self, cell: IVec3) -> impl Iterator<Item = u32> {
        let link = |place: usize| (place, self.chain[place]);
        let first = self.last.get(&cell).map(|&place| link(place));
        std::iter::successors(first, move |(_, (_, before))| before.map(link)).map(|(_, (vertex, _))| vertex)
    }
}

impl Settling<'_> {
    fn is_home(&self, vertex: u32) -> bool {
        let corner = &self.vertices[vertex as usize];
        corner.away() <= -0.5 * self.inset
    }

    /// Vertices outside their homes, in descending order of the distance to their homes.
    fn farthest_first(&self) -> Vec<u32> {
        let way = |vertex: &u32| {
            let corner = &self.vertices[*vertex as usize];
            corner.at.distance_squared(corner.at_home())
        };
        let mut away: Vec<u32> = (0..self.vertices.len() as u32).filter(|&vertex| !self.is_home(vertex)).collect();
        away.sort_by(|a, b| way(b).total_cmp(&way(a)));
        away
    }

    /// Reserves a position outside home.
    fn claim(&mut self, vertex: u32) {
        self.claims.add(self.vertices[vertex as usize].at.floor().as_ivec3(), vertex);
    }

    /// Moves a vertex home, and any vertex that obstructs it there.
    fn send_home(&mut self, vertex: u32) {
        let mut away = vec![vertex];
        while let Some(vertex) = away.pop() {
            if self.is_home(vertex) {
                continue;
            }
            let corner = &mut self.vertices[vertex as usize];
            corner.at = corner.at_home();
            away.extend(self.near(vertex));
        }
    }

    /// Vertices at home or with reserved positions that are closer to a vertex than homes are to each other.
    fn near(&self, vertex: u32) -> Vec<u32> {
        let reach = 0.5 * self.inset;
        let at = self.vertices[vertex as usize].at;
        let [low, high] = [at - reach, at + reach].map(|corner| corner.floor().as_ivec3());
        let mut near = Vec::new();
        for i in 0..8 {
            let step = cell_corner(i);
            if step.cmpgt(high - low).any() {
                continue;
            }
            let residents = self.map.vertices_of(low + step).filter(|&resident| self.is_home(resident));
            let all = residents.chain(self.claims.within(low + step)).filter(|&other| other != vertex);
            near.extend(all.filter(|&other| (self.vertices[other as usize].at - at).abs().max_element() < reach));
        }
        near
    }

    /// Vertex of a quad that is farthest outside its cell; `None` if all are at home.
    fn farthest_from_home(&self, quad: &Quad) -> Option<u32> {
        let away = |vertex: &u32| self.vertices[*vertex as usize].away();
        let not_home = quad.iter().copied().filter(|&vertex| !self.is_home(vertex));
        not_home.max_by(|a, b| away(a).total_cmp(&away(b)))
    }
}

/// Separates the homes of a cell's vertices if two coincide: moves them onto φ = 0, and from there towards the centres
/// of their pieces, as little as necessary. Centres of two pieces are at least 0.3 voxels apart, so two homes move less
/// than 2 insets / 0.3 of that distance.
pub(super) fn keep_apart(vertices: &mut [Corner], middles: &[DVec3], around: &CellSurroundings) {
    let inset = around.known.inset;
    let are_apart = |homes: &[DVec3]| {
        (0..homes.len()).all(|i| homes[..i].iter().all(|home| (*home - homes[i]).abs().max_element() >= inset))
    };
    let homes: Vec<DVec3> = vertices.iter().map(|vertex| vertex.home.as_dvec3()).collect();
    if are_apart(&homes) {
        return;
    }
    let within = |at: DVec3| at.clamp(DVec3::splat(inset), DVec3::splat(1.0 - inset));
    let on_zero: Vec<DVec3> = homes.iter().map(|&home| within(around.onto_zero(home))).collect();
    let towards =
        |share: f64| on_zero.iter().zip(middles).map(move |(home, middle)| home.lerp(*middle, share)).collect();
    let steps = (1.0 / inset).ceil() as u32;
    let shares = (0..=steps).map(|step| f64::from(step) / f64::from(steps));
    let apart = shares.map(towards).find(|homes: &Vec<DVec3>| are_apart(homes)).expect("middles of pieces are apart");
    for (vertex, home) in vertices.iter_mut().zip(apart) {
        vertex.home = home.as_vec3();
        if vertex.away() <= -0.5 * inset {
            vertex.at = vertex.at_home();
        }
    }
}
