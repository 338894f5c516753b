//! The samples of a tile in structure-of-arrays form: loops over lanes, which the compiler vectorises.
//!
//! Every lane does the same operations in the same order, none of them fused, so a sample gives the same bits in any
//! lane and on every processor.

use glam::Vec3;

use super::walk::WHOLE;

/// Number of samples that are processed together.
pub(crate) const LANES: usize = 16;

/// One number per sample.
pub(crate) type Lanes = [f32; LANES];

/// Points or vectors of the samples, by component.
#[derive(Clone, Copy)]
pub(crate) struct Points {
    pub(crate) x: Lanes,
    pub(crate) y: Lanes,
    pub(crate) z: Lanes,
}

/// Directions of rays.
pub(crate) struct Directions {
    pub(crate) along: Points,
    /// Reciprocal of each component; a huge number for zero.
    pub(crate) inverse: Points,
}

impl Points {
    pub(crate) const ZERO: Self = Self { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };

    /// Vector of one lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, point: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (point.x, point.y, point.z);
    }

    /// Centre of the bounding box of the `wanted` points, and their greatest distance from it.
    #[inline(always)]
    pub(crate) fn around(&self, wanted: &[bool; LANES]) -> (Vec3, f32) {
        let range = |axis: &Lanes| {
            let [mut low, mut high] = [[f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]];
            for i in 0..LANES {
                low[i] = if wanted[i] { axis[i] } else { low[i] };
                high[i] = if wanted[i] { axis[i] } else { high[i] };
            }
            [joined(low, smaller), joined(high, larger)]
        };
        let [x, y, z] = [range(&self.x), range(&self.y), range(&self.z)];
        let middle = 0.5 * Vec3::new(x[0] + x[1], y[0] + y[1], z[0] + z[1]);
        let mut squares = [0.0; LANES];
        for i in 0..LANES {
            let square = self.get(i).distance_squared(middle);
            squares[i] = if wanted[i] { square } else { 0.0 };
        }
        (middle, joined(squares, larger).sqrt())
    }

    /// Moves the points along directions, each by its own length.
    #[inline(always)]
    pub(crate) fn moved(&self, directions: &Self, lengths: &Lanes) -> Self {
        let mut moved = Self::ZERO;
        for i in 0..LANES {
            moved.x[i] = self.x[i] + directions.x[i] * lengths[i];
            moved.y[i] = self.y[i] + directions.y[i] * lengths[i];
            moved.z[i] = self.z[i] + directions.z[i] * lengths[i];
        }
        moved
    }

    /// Lowest corners of the points' cells. For a point on a cell border that its direction crosses downwards, the next
    /// lower cell is taken.
    #[inline(always)]
    pub(crate) fn corners(&self, directions: &Self) -> Self {
        let mut corners = Self::ZERO;
        for i in 0..LANES {
            corners.x[i] = corner(self.x[i], directions.x[i]);
            corners.y[i] = corner(self.y[i], directions.y[i]);
            corners.z[i] = corner(self.z[i], directions.z[i]);
        }
        corners
    }
}

impl Directions {
    /// Directions from unit vectors.
    #[inline(always)]
    pub(crate) fn new(along: Points) -> Self {
        let mut inverse = Points::ZERO;
        for i in 0..LANES {
            inverse.x[i] = inverse_of(along.x[i]);
            inverse.y[i] = inverse_of(along.y[i]);
            inverse.z[i] = inverse_of(along.z[i]);
        }
        Self { along, inverse }
    }

    /// The same direction in all lanes.
    #[inline(always)]
    pub(crate) fn all(direction: Vec3) -> Self {
        let [x, y, z] = direction.to_array().map(|component| [component; LANES]);
        Self::new(Points { x, y, z })
    }

    /// Length from a point of a lane to the position at which its ray leaves the cube with lowest corner `low`.
    #[inline(always)]
    pub(crate) fn length_in(&self, lane: usize, at: Vec3, low: Vec3, side: f32) -> f32 {
        let along = |at: f32, low: f32, slope: f32, inverse: f32| {
            let border = if slope < 0.0 { low } else { low + side };
            (border - at) * inverse
        };
        let (d, inverse) = (&self.along, &self.inverse);
        let x = along(at.x, low.x, d.x[lane], inverse.x[lane]);
        let y = along(at.y, low.y, d.y[lane], inverse.y[lane]);
        let z = along(at.z, low.z, d.z[lane], inverse.z[lane]);
        larger(smaller(smaller(x, y), z), 0.0)
    }
}

/// Reduces all lanes pairwise.
#[inline(always)]
fn joined(mut lanes: Lanes, join: impl Fn(f32, f32) -> f32) -> f32 {
    let mut half = LANES / 2;
    while half > 0 {
        for i in 0..half {
            lanes[i] = join(lanes[i], lanes[i + half]);
        }
        half /= 2;
    }
    lanes[0]
}

/// The larger of two numbers that are not NaN.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers that are not NaN.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// True if any lane is set.
#[inline(always)]
pub(crate) fn any(lanes: &[bool; LANES]) -> bool {
    lanes.iter().fold(false, |any, lane| any | lane)
}

#[inline(always)]
fn corner(at: f32, slope: f32) -> f32 {
    let nearest = (at + WHOLE) - WHOLE;
    let is_beyond = (nearest > at) | ((slope < 0.0) & (nearest == at));
    nearest - if is_beyond { 1.0 } else { 0.0 }
}

#[inline(always)]
fn inverse_of(component: f32) -> f32 {
    let inverse = 1.0 / component;
    if component == 0.0 { f32::MAX } else { inverse }
}

/// Converts a whole number below 2²² to an integer; larger numbers give a value far beyond any index.
#[inline(always)]
pub(crate) fn integer(whole: f32) -> i32 {
    ((whole + WHOLE).to_bits() as i32).wrapping_sub(WHOLE.to_bits() as i32)
}
