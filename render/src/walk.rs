//! Traversal of the bricks by a ray, in the largest steps that are proven free.
//!
//! ```text
//!   outside │ outside │ brick with metal   a brick without a voxel in the metal is crossed in one step, within others
//!   ────────┼─────────┼───┬─┬┬┬──  │       a cube of 4³ or 2³ cells without one; the cells that are left
//!           │         │     surface        are examined one by one, so no cell that holds the surface is skipped
//! ```
//! Lengths here are in voxels, from the lowest voxel of the index, in f32. The ray starts where it enters the box,
//! which keeps f32 accurate to about 10⁻³ voxel in a grid of 10⁴ voxels. Twin of `walk.wgsl`.

use glam::{BVec3A, IVec3, Vec3, Vec3A};
use sdf_bake::grid::{BRICK_SIDE, INSIDE, OUTSIDE, trilinear};

use super::camera::Ray;
use super::cubic::first_root;
use super::field::Field;
use super::occupancy::Blocks;

/// Shift that converts cell coordinates to brick coordinates.
pub(crate) const BRICK_SHIFT: i32 = BRICK_SIDE.trailing_zeros() as i32;

/// Nudge across a border [voxels], and the rounding error added per voxel of the grid's extent.
const NUDGE: f32 = 1e-4;
const NUDGE_PER_VOXEL: f32 = 4e-7;

/// Direction of the crossing that a ray searches for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sense {
    /// From outside to the metal.
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
}

/// The direction of a ray through the cells.
pub(crate) struct Line {
    pub(crate) direction: Vec3A,
    /// Reciprocal of each component; a huge number for zero.
    inverse: Vec3A,
    /// Axes along which the ray runs towards lower coordinates.
    pub(crate) backward: BVec3A,
}

/// State of a ray's traversal of a grid.
pub(crate) struct Walk<'a> {
    field: &'a Field<'a>,
    /// Blocks that must be examined.
    blocks: &'a [Blocks],
    sense: Sense,
    origin: Vec3A,
    line: Line,
    nudge: f32,
    /// Distance of `origin` from the ray's own start [m].
    entry: f64,
    /// Position along the ray, from `origin` [voxels].
    t: f32,
    /// Position at which the ray leaves the box [voxels].
    end: f32,
}

/// The part of a ray within one cell.
pub(crate) struct Cell {
    /// φ at the eight corners, positive on the side from which the ray comes [m].
    values: [f32; 8],
    /// Entry point of the ray, 0 to 1 within the cell.
    from: Vec3A,
    direction: Vec3A,
    /// Length of the ray in the cell [voxels].
    length: f32,
}

impl Line {
    /// `direction`: unit vector.
    #[inline]
    pub(crate) fn new(direction: Vec3A) -> Self {
        let still = direction.cmpeq(Vec3A::ZERO);
        let inverse = Vec3A::select(still, Vec3A::MAX, direction.recip());
        Self { direction, inverse, backward: direction.cmplt(Vec3A::ZERO) }
    }

    /// Lowest corner of the cell that contains the ray or, on a border, the cell that it enters next. Otherwise a ray
    /// almost parallel to a border would advance along it by nudges only.
    #[inline]
    pub(crate) fn corner(&self, at: Vec3A) -> Vec3A {
        let nearest = nearest_whole(at);
        let is_beyond = nearest.cmpgt(at) | (self.backward & nearest.cmpeq(at));
        nearest - Vec3A::select(is_beyond, Vec3A::ONE, Vec3A::ZERO)
    }

    /// Length [voxels] from `at` to the exit of the ray from the cube with lowest corner `low`.
    #[inline]
    pub(crate) fn length_in(&self, at: Vec3A, low: Vec3A, side: f32) -> f32 {
        let border = Vec3A::select(self.backward, low, low + side);
        ((border - at) * self.inverse).min_element().max(0.0)
    }

    /// Length [voxels] from `at` to the exit of the ray from the free cube around a brick; `distance` is that to the
    /// nearest occupied brick [bricks].
    #[inline]
    pub(crate) fn length_in_free(&self, at: Vec3A, (brick, distance): (IVec3, u8)) -> f32 {
        let (low, side) = free_cube(brick, distance);
        self.length_in(at, low.as_vec3a(), side as f32)
    }

    /// Interval of a ray within a box, from `first` on; empty for a miss. Lengths are from `start`.
    #[inline]
    pub(crate) fn span(&self, start: Vec3A, (low, high): (Vec3A, Vec3A), first: f32) -> (f32, f32) {
        let beside = (start.cmplt(low) | start.cmpgt(high)) & self.direction.cmpeq(Vec3A::ZERO);
        let (near, far) = ((low - start) * self.inverse, (high - start) * self.inverse);
        let (near, far) = (Vec3A::select(self.backward, far, near), Vec3A::select(self.backward, near, far));
        let (enter, leave) = (near.max_element().max(first), far.min_element());
        let meets = enter < leave && !beside.any();
        if meets { (enter, leave) } else { (0.0, 0.0) }
    }
}

/// Adding it to a number below 2²² leaves no bits for a fraction.
pub(crate) const WHOLE: f32 = 12_582_912.0;

/// Rounds each component to the nearest whole number.
#[inline]
pub(crate) fn nearest_whole(at: Vec3A) -> Vec3A {
    (at + WHOLE) - WHOLE
}

/// Converts whole numbers to integers; 2²² and more give values far beyond any index.
#[inline]
pub(crate) fn integers(whole: Vec3A) -> IVec3 {
    let integer = |x: f32| ((x + WHOLE).to_bits() as i32).wrapping_sub(WHOLE.to_bits() as i32);
    IVec3::new(integer(whole.x), integer(whole.y), integer(whole.z))
}

impl<'a> Walk<'a> {
    /// Starts a walk in the bounding box of all metal; `None` for a ray that misses it.
    pub(crate) fn entering(field: &'a Field<'a>, ray: &Ray) -> Option<Self> {
        Self::new(field, ray, Sense::Entering, field.metal_box)
    }

    /// Starts a walk that searches for the exit from the metal, in the whole indexed box.
    pub(crate) fn leaving(field: &'a Field<'a>, ray: &Ray) -> Option<Self> {
        Self::new(field, ray, Sense::Leaving, (Vec3::ZERO, indexed_size(field)))
    }

    fn new(field: &'a Field<'a>, ray: &Ray, sense: Sense, (least, most): (Vec3, Vec3)) -> Option<Self> {
        let start = ray.origin * field.per_metre - field.lowest;
        let (mut enter, mut leave) = (0f64, f64::INFINITY);
        for axis in 0..3 {
            let (p, d) = (start[axis], ray.direction[axis]);
            let (least, most) = (f64::from(least[axis]), f64::from(most[axis]));
            if d == 0.0 {
                if !(p >= least && p <= most) {
                    return None;
                }
            } else {
                let inverse = d.recip();
                let (a, b) = ((least - p) * inverse, (most - p) * inverse);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        if !(enter < leave && leave.is_finite()) {
            return None;
        }
        Some(Self {
            field,
            blocks: if sense == Sense::Entering { &field.metal } else { &field.air },
            sense,
            origin: (start + ray.direction * enter).as_vec3a(),
            line: Line::new(ray.direction.as_vec3a()),
            nudge: nudge(field),
            entry: enter * field.grid.voxel,
            t: 0.0,
            end: (leave - enter) as f32,
        })
    }

    /// Distance from the ray's start to the current position [m].
    pub(crate) fn distance(&self) -> f64 {
        self.entry + f64::from(self.t) * self.field.grid.voxel
    }

    /// Distance from the ray's start to the far side of the box [m].
    pub(crate) fn end(&self) -> f64 {
        self.entry + f64::from(self.end) * self.field.grid.voxel
    }

    /// Advances to the next cell that may contain the surface, and stops at its entry.
    pub(crate) fn next_cell(&mut self) -> Option<Cell> {
        while self.t < self.end {
            let at = self.origin + self.line.direction * self.t;
            let low = self.line.corner(at);
            let corner = integers(low);
            if let Some((low, side)) = self.clear_cube(corner) {
                self.t += self.line.length_in(at, low.as_vec3a(), side as f32) + self.nudge;
                continue;
            }
            let sign = self.sense.sign();
            let mut values = self.field.cell_phi(corner);
            values.iter_mut().for_each(|phi| *phi *= sign);
            let length = self.line.length_in(at, low, 1.0);
            return Some(Cell { values, from: at - low, direction: self.line.direction, length });
        }
        None
    }

    /// Lowest corner and side of a cube around a cell that contains no crossing, or `None` if the cell may contain one.
    #[inline]
    fn clear_cube(&self, corner: IVec3) -> Option<(IVec3, i32)> {
        let brick = corner >> BRICK_SHIFT;
        let entry = self.field.index.entry(brick);
        let shift = match (self.sense, entry.slot) {
            (Sense::Entering, _) if entry.to_metal > 0 => return Some(free_cube(brick, entry.to_metal)),
            (Sense::Leaving, INSIDE) => BRICK_SHIFT,
            (_, OUTSIDE | INSIDE) => 0,
            (_, slot) => self.blocks[slot as usize].clear_shift(corner),
        };
        (shift > 0).then(|| ((corner >> shift) << shift, 1 << shift))
    }

    /// Advances past a cell without a crossing.
    pub(crate) fn pass(&mut self, cell: &Cell) {
        self.t += cell.length + self.nudge;
    }

    /// Distance from the ray's start to the crossing in the current cell [m].
    pub(crate) fn crossing_in(&self, cell: &Cell) -> Option<f64> {
        let length = cell.crossing()?;
        Some(self.distance() + f64::from(length) * self.field.grid.voxel)
    }
}

impl Field<'_> {
    /// φ [voxels] at a point of a ray; outside the bricks, the coordinates of the missing brick and its distance from
    /// the nearest brick.
    #[inline]
    pub(crate) fn clearance(&self, line: &Line, at: Vec3A) -> Result<f32, (IVec3, u8)> {
        let low = line.corner(at);
        let corner = integers(low);
        let brick = corner >> BRICK_SHIFT;
        let distance = self.index.entry(brick).to_brick;
        if distance > 0 {
            return Err((brick, distance));
        }
        Ok(trilinear(&self.cell_phi(corner), (at - low).into()) * self.per_metre as f32)
    }
}

/// Lowest corner and side [voxels] of the free cube around a brick; `distance` is that to the nearest occupied brick
/// [bricks].
#[inline]
pub(crate) fn free_cube(brick: IVec3, distance: u8) -> (IVec3, i32) {
    let reach = i32::from(distance) - 1;
    ((brick - reach) << BRICK_SHIFT, (2 * reach + 1) << BRICK_SHIFT)
}

/// Nudge of a ray across a border of a grid [voxels].
pub(crate) fn nudge(field: &Field) -> f32 {
    NUDGE + NUDGE_PER_VOXEL * indexed_size(field).max_element()
}

/// Size of the indexed box [voxels].
pub(crate) fn indexed_size(field: &Field) -> Vec3 {
    (field.grid.dims * BRICK_SIDE as i32).as_vec3()
}

impl Cell {
    /// Length of the ray up to the first zero of φ [voxels].
    fn crossing(&self) -> Option<f32> {
        if self.values.iter().fold(true, |all, &phi| all & (phi > 0.0)) {
            return None;
        }
        let phi = |s: f32| trilinear(&self.values, (self.from + self.direction * (s * self.length)).into());
        first_root([phi(0.0), phi(1.0 / 3.0), phi(2.0 / 3.0), phi(1.0)]).map(|s| s * self.length)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::BrickGrid;

    use super::*;

    #[test]
    fn a_ray_along_a_border_does_not_creep() {
        let half = DVec3::splat(0.5);
        let grid = BrickGrid::from_distance(-half, half, 0.0625, 3.0, |p| p.z.abs() - 0.05);
        let field = Field::new(&grid);
        for axis in 0..3 {
            for sideways in [-1e-3, -1e-6, -1e-12, -1e-17, -1e-30, 0.0, 1e-30, 1e-17, 1e-6] {
                for sign in [-1.0, 1.0] {
                    let mut direction = DVec3::splat(sideways);
                    direction[axis] = sign;
                    let direction = direction.normalize();
                    let ray = Ray { origin: direction * -8.0, direction };
                    let mut walk = Walk::entering(&field, &ray).unwrap();
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
