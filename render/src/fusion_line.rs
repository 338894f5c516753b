//! Distance from the fusion lines, where weld metal meets base metal on the surface.
//!
//! ```text
//!    ────────╮ ╭────────     the points of a line lie between neighbouring voxels of weld and base metal; nodes
//!    base  × │w│ ×  base     around them know their nearest point (vector distance transform, Danielsson 1980)
//! ```

use glam::{DVec3, IVec3, Vec3};
use sdf_bake::BrickGrid;

use super::lanes::integer;
use super::scene::FIRST_OBSTACLE;

/// Greatest distance that is known [m].
const REACH: f32 = 0.04;
/// Distance between nodes [voxels].
const PITCH: f32 = 3.0;
/// Greatest number of nodes along a side; nodes of a larger part are further apart.
const MOST_NODES: f32 = 160.0;
/// Directions to the neighbours of a voxel.
const AXES: [IVec3; 6] = [IVec3::X, IVec3::Y, IVec3::Z, IVec3::NEG_X, IVec3::NEG_Y, IVec3::NEG_Z];
/// Mark of a node without a point.
const NONE: u32 = u32::MAX;

/// Fusion lines of all welds of a part.
#[derive(Clone, Debug)]
pub struct FusionLine {
    points: Vec<Vec3>,
    /// Index of the nearest point for each node, z fastest.
    nearest: Vec<u32>,
    low: Vec3,
    pitch: f32,
    dims: IVec3,
}

impl FusionLine {
    /// Finds the fusion lines of a labelled field; obstacles have none.
    pub fn of(grid: &BrickGrid) -> Self {
        let points = points(grid);
        let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let (low, high) = points.iter().fold(none, |(low, high), &point| (low.min(point), high.max(point)));
        if points.is_empty() {
            return Self { points, nearest: Vec::new(), low: Vec3::ZERO, pitch: 1.0, dims: IVec3::ZERO };
        }
        let extent = high - low + 2.0 * REACH;
        let pitch = (PITCH * grid.voxel as f32).max(extent.max_element() / MOST_NODES);
        let dims = (extent / pitch).ceil().as_ivec3() + 1;
        let nearest = vec![NONE; (dims.x * dims.y * dims.z) as usize];
        let mut line = Self { points, nearest, low: low - REACH, pitch, dims };
        line.spread();
        line
    }

    /// Points of the lines [m], spaced by a voxel or less.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Distance of a point [m] from the nearest line [m]; infinite beyond 40 mm.
    #[inline(always)]
    pub fn distance(&self, point: Vec3) -> f32 {
        let low = ((point - self.low) / self.pitch).floor();
        let corner = IVec3::new(integer(low.x), integer(low.y), integer(low.z));
        let is_within = corner.cmpge(IVec3::ZERO).all() && corner.cmplt(self.dims - 1).all();
        if !is_within {
            return f32::INFINITY;
        }
        let square = |i: i32| {
            let node = self.node(corner + IVec3::new(i >> 2, i >> 1 & 1, i & 1));
            self.points.get(self.nearest[node] as usize).map_or(f32::INFINITY, |near| near.distance_squared(point))
        };
        let distance = (0..8).map(square).fold(f32::INFINITY, f32::min).sqrt();
        if distance <= REACH { distance } else { f32::INFINITY }
    }

    fn node(&self, at: IVec3) -> usize {
        ((at.x * self.dims.y + at.y) * self.dims.z + at.z) as usize
    }

    fn position(&self, at: IVec3) -> Vec3 {
        self.low + at.as_vec3() * self.pitch
    }

    /// Gives every node its nearest point: from the points to the nodes beside them, then in two sweeps.
    fn spread(&mut self) {
        let mut squares = vec![f32::INFINITY; self.nearest.len()];
        for at in 0..self.points.len() {
            let corner = ((self.points[at] - self.low) / self.pitch).floor().as_ivec3();
            for i in 0..8 {
                self.offer(&mut squares, corner + IVec3::new(i >> 2, i >> 1 & 1, i & 1), at as u32);
            }
        }
        let IVec3 { x, y, .. } = self.dims;
        let rows = || (0..x).flat_map(move |x| (0..y).map(move |y| (x, y)));
        rows().for_each(|row| self.sweep(&mut squares, row, 1));
        rows().rev().for_each(|row| self.sweep(&mut squares, row, -1));
    }

    /// Offers the nodes of a row the points of the 13 neighbours that precede each in the order of the sweep.
    /// `ahead`: 1 for the sweep upwards, -1 for the one back; `squares`: squared distances of the nearest points.
    fn sweep(&mut self, squares: &mut [f32], (x, y): (i32, i32), ahead: i32) {
        let IVec3 { z: count, .. } = self.dims;
        let within = |(x, y): &(i32, i32)| (0..self.dims.x).contains(x) && (0..self.dims.y).contains(y);
        let beside = [(-1, -1), (-1, 0), (-1, 1), (0, -1)].map(|(dx, dy)| (x + ahead * dx, y + ahead * dy));
        let rows: Vec<usize> = beside.into_iter().filter(within).map(|(x, y)| self.node(IVec3::new(x, y, 0))).collect();
        let (mut z, mut before) = (if ahead > 0 { 0 } else { count - 1 }, NONE);
        while (0..count).contains(&z) {
            let at = IVec3::new(x, y, z);
            for row in &rows {
                for z in [z - ahead, z, z + ahead].into_iter().filter(|z| (0..count).contains(z)) {
                    self.offer(squares, at, self.nearest[row + z as usize]);
                }
            }
            self.offer(squares, at, before);
            before = self.nearest[self.node(at)];
            z += ahead;
        }
    }

    fn offer(&mut self, squares: &mut [f32], node: IVec3, candidate: u32) {
        let place = self.node(node);
        if candidate == NONE || candidate == self.nearest[place] {
            return;
        }
        let square = self.points[candidate as usize].distance_squared(self.position(node));
        if square < squares[place] {
            (self.nearest[place], squares[place]) = (candidate, square);
        }
    }
}

/// Middles between neighbouring voxels of weld and of base metal next to the surface [m].
fn points(grid: &BrickGrid) -> Vec<Vec3> {
    let is_weld = |label: u16| label > 0 && label < FIRST_OBSTACLE;
    let near = |phi: f32| phi <= 0.0 && f64::from(phi) > -1.5 * grid.voxel;
    let mut points = Vec::new();
    for place in (0..grid.label.len()).filter(|&place| is_weld(grid.label[place]) && near(grid.phi[place])) {
        let voxel = grid.voxel_of(place);
        // Bodies united by the lesser distance leave φ near zero on the faces between them, deep in the metal.
        let is_open = AXES.iter().any(|&axis| (1..=2).any(|step| grid.phi_at(voxel + axis * step) > 0.0));
        for axis in AXES.into_iter().filter(|_| is_open) {
            let other = voxel + axis;
            if grid.label_at(other) == 0 && near(grid.phi_at(other)) {
                let middle: DVec3 = grid.position(voxel).midpoint(grid.position(other));
                points.push(middle.as_vec3());
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plate with weld metal in a strip of 10 mm about x = 0.
    fn plate() -> BrickGrid {
        let half = DVec3::new(0.05, 0.02, 0.005);
        let distance = |p: DVec3| (p.abs() - half).max_element();
        let mut grid = BrickGrid::from_distance(-half, half, 1e-3, 3.0, distance);
        let x = |place: usize| grid.position(grid.voxel_of(place)).x;
        grid.label = (0..grid.phi.len()).map(|place| u16::from(x(place).abs() < 0.0049)).collect();
        grid
    }

    #[test]
    fn distances_are_those_from_the_border_of_the_weld() {
        let line = FusionLine::of(&plate());
        for i in 0..60 {
            let x = 0.75e-3 * (i - 30) as f32;
            let expected = (x.abs() - 4.5e-3).abs();
            let found = line.distance(Vec3::new(x, 3.3e-3, 5e-3));
            // Points lie half a voxel below the surface, 1 mm apart.
            assert!((found - expected).abs() < 0.9e-3, "{found} at {x}");
            assert!(expected < 5e-3 || (found - expected).abs() < 0.1e-3, "{found} at {x}");
        }
    }

    #[test]
    fn faces_between_united_bodies_deep_in_the_metal_are_no_fusion_line() {
        let half = DVec3::new(0.05, 0.02, 0.005);
        let outer = |p: DVec3| (p.abs() - half).max_element();
        // Two halves that meet at x = 0, each a body of its own.
        let distance = |p: DVec3| outer(p).max(-p.x.abs());
        let mut grid = BrickGrid::from_distance(-half, half, 1e-3, 3.0, distance);
        let x = |place: usize| grid.position(grid.voxel_of(place)).x;
        grid.label = (0..grid.phi.len()).map(|place| u16::from(x(place) > 0.0)).collect();
        let line = FusionLine::of(&grid);
        let depth = |point: &Vec3| f64::from((point.abs() - half.as_vec3()).max_element());
        assert!(!line.points().is_empty() && line.points().iter().all(|point| depth(point) > -2.5e-3));
    }

    #[test]
    fn a_part_without_a_weld_and_obstacles_have_no_line() {
        let mut grid = plate();
        grid.label.iter_mut().for_each(|label| *label *= FIRST_OBSTACLE);
        assert!(FusionLine::of(&grid).points().is_empty());
        grid.label.clear();
        assert_eq!(FusionLine::of(&grid).distance(Vec3::ZERO), f32::INFINITY);
        assert_eq!(FusionLine::of(&plate()).distance(Vec3::new(0.0, 0.0, 0.5)), f32::INFINITY);
    }
}
