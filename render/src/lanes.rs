//! The samples of a tile side by side: loops over lanes, which a compiler makes vectors of.
//!
//! Every lane does the same operations in the same order, none of them fused, so a lane has the same bits wherever it
//! stands and on every processor.

use glam::Vec3;

use super::walk::WHOLE;

/// Samples that are looked at together.
pub(crate) const LANES: usize = 16;

/// One number of each sample.
pub(crate) type Lanes = [f32; LANES];

/// Points or vectors of the samples by their components.
#[derive(Clone, Copy)]
pub(crate) struct Points {
    pub(crate) x: Lanes,
    pub(crate) y: Lanes,
    pub(crate) z: Lanes,
}

/// The directions of rays.
pub(crate) struct Directions {
    pub(crate) along: Points,
    /// Of each component; a huge number for zero.
    pub(crate) inverse: Points,
}

impl Points {
    pub(crate) const ZERO: Self = Self { x: [0.0; LANES], y: [0.0; LANES], z: [0.0; LANES] };

    /// Of one lane.
    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> Vec3 {
        Vec3::new(self.x[lane], self.y[lane], self.z[lane])
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, point: Vec3) {
        (self.x[lane], self.y[lane], self.z[lane]) = (point.x, point.y, point.z);
    }

    /// Middle of the box around those that are `wanted`, and the largest distance from it.
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

    /// The points moved along directions, each by its own length.
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

    /// Lowest corners of the points' cells; of the next lower cells for points on a border that `directions` run down
    /// across.
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
    /// Of unit vectors.
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

    /// The same for all lanes.
    #[inline(always)]
    pub(crate) fn all(direction: Vec3) -> Self {
        let [x, y, z] = direction.to_array().map(|component| [component; LANES]);
        Self::new(Points { x, y, z })
    }

    /// Length from a point of a lane to where its ray leaves the cube with the lowest corner `low`.
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

/// All lanes joined two by two.
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

/// The larger of two numbers of which none is NaN.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers of which none is NaN.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Whether any lane is set.
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

/// A whole number of less than 2²² as an integer; far beyond any index for others.
#[inline(always)]
pub(crate) fn integer(whole: f32) -> i32 {
    ((whole + WHOLE).to_bits() as i32).wrapping_sub(WHOLE.to_bits() as i32)
}
