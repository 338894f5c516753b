//! The way of a ray through the bricks: empty bricks in one stride, then cells of eight voxels.
//!
//! ```text
//!   outside │ outside │ band brick │ ...      a brick without a slot is crossed in one step,
//!   ────────┼─────────┼─┬─┬─┬─┬──  │          within the band the ray advances by φ or by one cell,
//!           │         │ · · ·│surface         whichever is longer, so no cell that holds the surface is passed
//! ```
//!
//! Lengths here are in voxels, from the lowest voxel of the index, in f32: the ray starts where it enters the indexed
//! box, which keeps f32 to about 10⁻³ voxel in a grid of 10⁴ voxels.

use glam::{BVec3, IVec3, Vec3};
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_SIDE, INSIDE, OUTSIDE, trilinear};

use super::camera::Ray;
use super::cubic::first_root;

/// Cells to bricks by shifting.
const BRICK_SHIFT: i32 = BRICK_SIDE.trailing_zeros() as i32;

/// Nudge across a border [voxels], and what rounding adds for each voxel of the grid's extent.
const NUDGE: f32 = 1e-4;
const NUDGE_PER_VOXEL: f32 = 4e-7;

/// Largest distance by which the zero of the interpolated φ may be nearer than interpolated φ says [voxels]: a
/// corner's distance is off by at most its distance from the point, √3/2 on average at worst, and so is the surface.
const INTERPOLATION_REACH: f32 = 1.732_050_8;

/// Which way through the surface a ray looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sense {
    /// From outside into the metal.
    Entering,
    /// From the metal to the outside.
    Leaving,
}

impl Sense {
    fn sign(self) -> f32 {
        match self {
            Self::Entering => 1.0,
            Self::Leaving => -1.0,
        }
    }

    /// Index entry of bricks in which no crossing can be.
    fn clear(self) -> u32 {
        match self {
            Self::Entering => OUTSIDE,
            Self::Leaving => INSIDE,
        }
    }
}

/// A ray under way through a grid.
pub(crate) struct Walk<'a> {
    grid: &'a BrickGrid,
    sense: Sense,
    low: IVec3,
    origin: Vec3,
    direction: Vec3,
    inverse: Vec3,
    /// Axes along which the ray runs towards lower coordinates.
    backward: BVec3,
    nudge: f32,
    /// Distance of `origin` from the ray's own start [m].
    entry: f64,
    /// Where the ray is, from `origin` [voxels].
    t: f32,
    /// Where it leaves the indexed box [voxels].
    end: f32,
}

/// The part of a ray within one cell.
pub(crate) struct Cell {
    /// φ at the eight corners, positive on the side that the ray comes from [m].
    values: [f32; 8],
    /// Entry of the ray, 0 to 1 within the cell.
    from: Vec3,
    direction: Vec3,
    /// Length of the ray in the cell [voxels].
    length: f32,
}

impl<'a> Walk<'a> {
    /// Starts a walk, or `None` for a ray that misses the indexed box.
    pub(crate) fn new(grid: &'a BrickGrid, ray: &Ray, sense: Sense) -> Option<Self> {
        let low = grid.origin * BRICK_SIDE as i32;
        let size = (grid.dims * BRICK_SIDE as i32).as_dvec3();
        let start = ray.origin / grid.voxel - low.as_dvec3();
        let (mut enter, mut leave) = (0f64, f64::INFINITY);
        for axis in 0..3 {
            let (p, d) = (start[axis], ray.direction[axis]);
            if d == 0.0 {
                if !(p >= 0.0 && p <= size[axis]) {
                    return None;
                }
            } else {
                let (a, b) = (-p / d, (size[axis] - p) / d);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        if !(enter < leave && leave.is_finite()) {
            return None;
        }
        let direction = ray.direction.as_vec3();
        Some(Self {
            grid,
            sense,
            low,
            origin: (start + ray.direction * enter).as_vec3(),
            direction,
            inverse: direction.recip(),
            backward: direction.cmplt(Vec3::ZERO),
            nudge: NUDGE + NUDGE_PER_VOXEL * size.max_element() as f32,
            entry: enter * grid.voxel,
            t: 0.0,
            end: (leave - enter) as f32,
        })
    }

    /// Distance from the ray's start to where the walk is [m].
    pub(crate) fn distance(&self) -> f64 {
        self.entry + f64::from(self.t) * self.grid.voxel
    }

    /// Distance from the ray's start to the far side of the indexed box [m].
    pub(crate) fn end(&self) -> f64 {
        self.entry + f64::from(self.end) * self.grid.voxel
    }

    /// The next cell that is not in an empty brick; the walk stands at its entry.
    pub(crate) fn next_cell(&mut self) -> Option<Cell> {
        while self.t < self.end {
            let at = self.origin + self.direction * self.t;
            let corner = self.corner(at);
            let brick = corner >> BRICK_SHIFT;
            if self.grid.slot(brick + self.grid.origin) == self.sense.clear() {
                self.t += self.length_in(at, (brick << BRICK_SHIFT).as_vec3(), BRICK_SIDE as f32) + self.nudge;
                continue;
            }
            let low = corner.as_vec3();
            let mut values = self.grid.cell_phi(corner + self.low);
            let sign = self.sense.sign();
            values.iter_mut().for_each(|phi| *phi *= sign);
            let length = self.length_in(at, low, 1.0);
            return Some(Cell { values, from: at - low, direction: self.direction, length });
        }
        None
    }

    /// Lowest corner of the cell that the ray is in or, on a border, enters next. Without the second half a ray
    /// almost parallel to a border would creep along it by nudges.
    fn corner(&self, at: Vec3) -> IVec3 {
        let whole = at.as_ivec3();
        let on_border = self.backward & whole.as_vec3().cmpeq(at);
        whole - IVec3::select(on_border, IVec3::ONE, IVec3::ZERO)
    }

    /// Goes on past a cell without a crossing by the cell's length or by its φ, whichever is longer.
    pub(crate) fn pass(&mut self, cell: &Cell) {
        let free = cell.phi() / self.grid.voxel as f32 - INTERPOLATION_REACH;
        self.t += free.max(cell.length) + self.nudge;
    }

    /// Length [voxels] from `at` to where the ray leaves the cube with lowest corner `low`.
    fn length_in(&self, at: Vec3, low: Vec3, side: f32) -> f32 {
        let mut length = f32::INFINITY;
        for axis in 0..3 {
            let d = self.direction[axis];
            if d != 0.0 {
                let border = if d > 0.0 { low[axis] + side } else { low[axis] };
                length = length.min((border - at[axis]) * self.inverse[axis]);
            }
        }
        length.max(0.0)
    }

    /// Distance from the ray's start to the crossing in the cell at which the walk stands [m].
    pub(crate) fn crossing_in(&self, cell: &Cell) -> Option<f64> {
        let length = cell.crossing()?;
        Some(self.distance() + f64::from(length) * self.grid.voxel)
    }
}

impl Cell {
    /// φ where the ray enters [m], positive on the side that the ray comes from.
    pub(crate) fn phi(&self) -> f32 {
        trilinear(&self.values, self.from)
    }

    /// Length of the ray up to the first zero of φ [voxels].
    fn crossing(&self) -> Option<f32> {
        if self.values.iter().all(|&phi| phi > 0.0) {
            return None;
        }
        let phi = |s: f32| trilinear(&self.values, self.from + self.direction * (s * self.length));
        first_root([phi(0.0), phi(1.0 / 3.0), phi(2.0 / 3.0), phi(1.0)]).map(|s| s * self.length)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn a_ray_along_a_border_does_not_creep() {
        let half = DVec3::splat(0.5);
        let grid = BrickGrid::from_distance(-half, half, 0.0625, 3.0, |p| p.z.abs() + 0.05);
        for axis in 0..3 {
            for sideways in [-1e-3, -1e-6, -1e-12, -1e-17, -1e-30, 0.0, 1e-30, 1e-17, 1e-6] {
                for sign in [-1.0, 1.0] {
                    let mut direction = DVec3::splat(sideways);
                    direction[axis] = sign;
                    let direction = direction.normalize();
                    let ray = Ray { origin: direction * -8.0, direction };
                    let mut walk = Walk::new(&grid, &ray, Sense::Entering).unwrap();
                    let mut cells = 0;
                    while let Some(cell) = walk.next_cell() {
                        walk.pass(&cell);
                        cells += 1;
                        assert!(cells < 100, "more than 100 cells in 32 along {direction}");
                    }
                }
            }
        }
    }
}
