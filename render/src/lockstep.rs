//! Traces the rays of a tile in lockstep, in lanes; each result equals that of [`Field::trace`].
//!
//! ```text
//!   φ > 0 at all corners of the cell      step by φ, as
//! [`common_clear_length`](super::ray_packet::common_clear_length) does, or
//!   free cube of bricks                   across the cell or the cube, whichever is longer
//!   a corner inside the metal             the exact root in the cell
//! ```

use glam::{DVec3, Vec3};

use super::cubic::first_roots;
use super::field::Field;
use super::lanes::{Directions, LANES, Lanes, Points, any, larger, smaller};
use super::padded::{Cells, Padded};
use super::rays::Rays;
use super::shadow::STEEPEST;
use super::walk::nudge;

/// Distances from the starts of at most [`LANES`] rays to where they enter the metal [m], infinite for a miss; compiled
/// by `pulp` for each instruction set.
pub(crate) struct Crossings<'a> {
    pub(crate) field: &'a Field<'a>,
    pub(crate) padded: &'a Padded,
    pub(crate) rays: &'a Rays,
    /// Length from the start of each ray that is free of metal [m].
    pub(crate) clear: f64,
}

/// Rays from the points at which they enter the bounding box of all metal [voxels].
struct Start {
    points: Points,
    directions: Points,
    /// Distance from the rays' own starts [voxels].
    entry: [f64; LANES],
    /// Length in the box; 0 for a ray that misses it.
    length: Lanes,
}

impl pulp::NullaryFnOnce for Crossings<'_> {
    type Output = [f64; LANES];

    #[inline(always)]
    fn call(self) -> [f64; LANES] {
        let start = self.start();
        let lengths = self.lengths(&start);
        let mut distances = [f64::INFINITY; LANES];
        for i in 0..LANES {
            distances[i] = (start.entry[i] + f64::from(lengths[i])) * self.field.grid.voxel;
        }
        distances
    }
}

// Everything below is inlined into that call, so that it is compiled for the same instruction set.

impl Crossings<'_> {
    #[inline(always)]
    fn start(&self) -> Start {
        let field = self.field;
        let (mut from, along) = (self.rays.origins, &self.rays.directions);
        for axis in 0..3 {
            for i in 0..LANES {
                from[axis][i] = from[axis][i] * field.per_metre - field.lowest[axis];
            }
        }
        let (mut entry, mut leave) = ([self.clear * field.per_metre; LANES], [f64::INFINITY; LANES]);
        for axis in 0..3 {
            let (least, most) = (f64::from(field.metal_box.0[axis]), f64::from(field.metal_box.1[axis]));
            for i in 0..LANES {
                let (p, d) = (from[axis][i], along[axis][i]);
                let inverse = if d == 0.0 { f64::MAX } else { 1.0 / d };
                let (a, b) = ((least - p) * inverse, (most - p) * inverse);
                let (near, far) = if a < b { (a, b) } else { (b, a) };
                entry[i] = if near > entry[i] { near } else { entry[i] };
                leave[i] = if far < leave[i] { far } else { leave[i] };
            }
        }
        let mut start = Start { points: Points::ZERO, directions: Points::ZERO, entry, length: [0.0; LANES] };
        for i in 0..LANES {
            let meets = self.rays.wanted[i] & (entry[i] < leave[i]) & (leave[i] < f64::INFINITY);
            let p = DVec3::new(from[0][i], from[1][i], from[2][i]);
            let d = self.rays.direction(i);
            let (point, length) = ((p + d * entry[i]).as_vec3(), (leave[i] - entry[i]) as f32);
            start.points.set(i, if meets { point } else { Vec3::ZERO });
            start.directions.set(i, if meets { d.as_vec3() } else { Vec3::ZERO });
            start.length[i] = if meets { length } else { 0.0 };
        }
        start
    }

    /// Lengths up to the crossings [voxels], infinite for a miss.
    #[inline(always)]
    fn lengths(&self, start: &Start) -> Lanes {
        let directions = Directions::new(start.directions);
        let (per_metre, nudge) = (self.field.per_metre as f32, nudge(self.field));
        let (mut t, mut found) = ([0.0; LANES], [f32::INFINITY; LANES]);
        let mut cells = Cells::new(self.field.grid.band);
        let mut under_way = start.length.map(|length| length > 0.0);
        while any(&under_way) {
            let at = start.points.moved(&directions.along, &t);
            cells.low = at.corners(&directions.along);
            self.padded.read(&under_way, &mut cells);
            let (mut stride, mut length, mut may_cross) = ([0.0; LANES], [0.0; LANES], [false; LANES]);
            for i in 0..LANES {
                let (point, low) = (at.get(i), cells.low.get(i));
                let is_free = cells.to_metal[i] > 0;
                let (cube, side) = cells.free_cube(i, cells.to_metal[i]);
                length[i] = directions.length_in(i, point, low, 1.0);
                let across = if is_free { directions.length_in(i, point, cube, side) } else { length[i] };
                let by_phi = cells.phi(i, point - low) * (per_metre / STEEPEST);
                let mut least = cells.values[0][i];
                for corner in 1..8 {
                    least = smaller(least, cells.values[corner][i]);
                }
                let is_clear = is_free | (least > 0.0);
                may_cross[i] = under_way[i] & !is_clear;
                stride[i] = larger(across + nudge, if is_clear { by_phi } else { 0.0 });
            }
            if any(&may_cross) {
                let roots = roots(&cells, &at, &directions.along, &length, &may_cross);
                for i in 0..LANES {
                    let crosses = may_cross[i] & (roots[i] <= 1.0);
                    found[i] = if crosses { t[i] + roots[i] * length[i] } else { found[i] };
                    under_way[i] &= !crosses;
                }
            }
            for i in 0..LANES {
                t[i] += stride[i];
                under_way[i] &= t[i] < start.length[i];
            }
        }
        found
    }
}

/// First zeros of φ along the `wanted` rays within their cells, as shares of their `lengths`; above 1 if there is none.
#[inline(always)]
fn roots(cells: &Cells, at: &Points, directions: &Points, lengths: &Lanes, wanted: &[bool; LANES]) -> Lanes {
    let mut along = [[0.0; LANES]; 4];
    for (third, values) in along.iter_mut().enumerate() {
        let part = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0][third];
        for i in 0..LANES {
            let from: Vec3 = at.get(i) - cells.low.get(i);
            values[i] = cells.phi(i, from + directions.get(i) * (part * lengths[i]));
        }
    }
    first_roots(&along, wanted)
}

#[cfg(test)]
mod tests {
    use sdf_bake::BrickGrid;

    use super::*;
    use crate::camera::{Camera, Ray};
    use crate::ray_packet::common_clear_length;
    use crate::rays::ImagePositions;
    use crate::tile::tile_pixels;

    const VOXEL: f64 = 0.0005;

    #[test]
    fn rays_in_lockstep_meet_what_each_meets_alone() {
        let half = DVec3::new(0.02, 0.015, 0.01);
        let shape = |p: DVec3| {
            let q = (p - DVec3::new(0.0, 0.0, -0.007)).abs() - DVec3::new(0.02, 0.015, 0.0007);
            let plate = q.max(DVec3::ZERO).length() + q.max_element().min(0.0);
            plate.min((p - DVec3::new(0.004, 0.0, -0.002)).length() - 0.005)
        };
        let grid = BrickGrid::from_distance(-half, half, VOXEL, 3.0, shape);
        let field = Field::new(&grid);
        for (elevation, size) in [(0.7, 96.0), (0.05, 160.0), (1.4, 24.0)] {
            let camera = Camera::framing(-half, half, -1.1, elevation, 1.0);
            let (mut hits, mut others) = (0, 0);
            for corner in (0..size as usize).step_by(4).flat_map(|y| (0..size as usize).step_by(4).map(move |x| (x, y)))
            {
                let mut places = ImagePositions { across: [0.0; LANES], down: [0.0; LANES], wanted: [true; LANES] };
                for (lane, (x, y)) in tile_pixels(corner).enumerate() {
                    (places.across[lane], places.down[lane]) = ((x as f64 + 0.5) / size, (y as f64 + 0.5) / size);
                }
                let rays = Rays::through(&places, &camera, (1.0, camera.half_image()));
                let clear = common_clear_length(&field, &rays, 0.0).min(1e3);
                let call = Crossings { field: &field, padded: field.padded(), rays: &rays, clear };
                let together = pulp::Arch::new().dispatch(call);
                for (lane, distance) in together.into_iter().enumerate() {
                    let ray = Ray { origin: rays.origin(lane), direction: rays.direction(lane) };
                    match field.trace(&ray) {
                        Some(hit) if (hit.distance - distance).abs() < 2e-3 * VOXEL => hits += 1,
                        None if distance == f64::INFINITY => {}
                        // A ray that grazes an edge may pass on either side of it.
                        _ => others += 1,
                    }
                }
            }
            assert!(hits as f64 > 0.05 * size * size && others as f64 <= 1e-3 * size * size, "{hits} and {others}");
        }
    }
}
