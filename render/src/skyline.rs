//! Distance along the rays to a lamp beyond which nothing casts a shadow.
//!
//! ```text
//!        ↗ lamp        highest block in each column towards the lamp, among the blocks near the metal: a ray above it
//!     ▁▃▃█▂▁           is clear to the end
//! ```

use glam::{Vec2, Vec3};

use super::lanes::{LANES, Lanes, Points, larger};
use super::occupancy::Blocks;
use super::padded::Padded;
use sdf_bake::simd::in_wide_lanes;

/// Side of a column [voxels].
const COLUMN: f32 = 2.0;
/// Greatest number of columns along a side; columns of a larger part are wider.
const MOST_COLUMNS: f32 = 1024.0;
/// Bound of rounding errors in the position of a block or a ray [voxels].
const ROUNDING: f32 = 0.02;

/// Height profile of a part towards a lamp. Lengths are in voxels, from the lowest voxel of the index.
pub(crate) struct Skyline {
    /// Unit vector towards the lamp, and two perpendicular to it.
    axes: [Vec3; 3],
    /// Lowest corner of the first column.
    low: Vec2,
    /// Columns per voxel.
    per_voxel: f32,
    /// Number of columns along each side, including an empty border.
    columns: [usize; 2],
    heights: Vec<f32>,
}

impl Skyline {
    /// `direction`: unit vector towards the lamp.
    pub(crate) fn new(padded: &Padded, direction: Vec3) -> Self {
        let (across, along) = direction.any_orthonormal_pair();
        let axes = [direction, across, along];
        let project = |point: Vec3| Vec3::from_array(axes.map(|axis| axis.dot(point)));
        // Half size of a block of 2³ cells, which extends 1 to each side of its centre.
        let half = Vec3::from_array(axes.map(|axis| axis.abs().element_sum()));
        let middles = padded.near.iter().map(|(brick, _)| project((8 * brick + 4).as_vec3()));
        let (low, high) = middles.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), middle| {
            (low.min(middle - 4.0 * half), high.max(middle + 4.0 * half))
        });
        let extent = if low.x < high.x { high - low } else { Vec3::ZERO };
        let per_voxel = (MOST_COLUMNS / extent.y.max(extent.z)).min(1.0 / COLUMN);
        let columns = [extent.y, extent.z].map(|extent| (extent * per_voxel) as usize + 3);
        let heights = vec![f32::NEG_INFINITY; columns[0] * columns[1]];
        let mut skyline = Self { axes, low: Vec2::new(low.y, low.z), per_voxel, columns, heights };
        let blocks: [Vec3; 64] = std::array::from_fn(|block| {
            project(Vec3::new((block >> 4) as f32, (block >> 2 & 3) as f32, (block & 3) as f32) * 2.0 + 1.0)
        });
        in_wide_lanes(
            #[inline(always)]
            || {
                for &(brick, bits) in &padded.near {
                    skyline.raise(project((8 * brick).as_vec3()), (&blocks, bits), half + ROUNDING);
                }
            },
        );
        skyline
    }

    /// Raises all columns that the blocks of a brick cover. `blocks`: block centres relative to the brick's `corner`;
    /// `half`: half size of the box around each.
    #[inline(always)]
    fn raise(&mut self, corner: Vec3, (blocks, Blocks(mut bits)): (&[Vec3; 64], Blocks), half: Vec3) {
        let in_columns = |at: f32, side: usize| (at - self.low[side]) * self.per_voxel + 1.0;
        let (mut ranges, mut heights) = ([[0; 4]; 64], [0.0; 64]);
        for (block, middle) in blocks.iter().enumerate() {
            let (low, high) = (corner + *middle - half, corner + *middle + half);
            ranges[block] = [
                in_columns(low.y, 0) as i32,
                in_columns(high.y, 0) as i32,
                in_columns(low.z, 1) as i32,
                in_columns(high.z, 1) as i32,
            ];
            heights[block] = high.x;
        }
        while bits != 0 {
            let block = bits.trailing_zeros() as usize;
            let [first, last, from, to] = ranges[block].map(|column| column as usize);
            for row in first..=last {
                let row = row * self.columns[1];
                for height in &mut self.heights[row + from..=row + to] {
                    *height = larger(*height, heights[block]);
                }
            }
            bits &= bits - 1;
        }
    }

    /// Index of the column along one side.
    #[inline(always)]
    fn column(&self, side: usize, at: f32) -> usize {
        let place = (at - self.low[side]) * self.per_voxel + 1.0;
        place.max(0.0).min((self.columns[side] - 1) as f32) as i32 as usize
    }

    /// Length along a ray to the lamp beyond which all rays that start within `apart` of it are clear; negative if they
    /// are clear from the start.
    #[inline(always)]
    pub(crate) fn length(&self, start: Vec3, apart: f32) -> f32 {
        let [height, x, y] = self.axes.map(|axis| axis.dot(start));
        let mut highest = f32::NEG_INFINITY;
        for row in self.column(0, x - apart)..=self.column(0, x + apart) {
            let row = row * self.columns[1];
            let columns = row + self.column(1, y - apart)..=row + self.column(1, y + apart);
            highest = self.heights[columns].iter().copied().fold(highest, f32::max);
        }
        highest - height + apart
    }

    /// [`Skyline::length`] of each single ray.
    #[inline(always)]
    pub(crate) fn lengths(&self, starts: &Points) -> Lanes {
        let (mut heights, mut places) = ([0.0; LANES], [0; LANES]);
        for i in 0..LANES {
            let start = starts.get(i);
            heights[i] = self.axes[0].dot(start);
            let (row, column) = (self.column(0, self.axes[1].dot(start)), self.column(1, self.axes[2].dot(start)));
            places[i] = row * self.columns[1] + column;
        }
        let mut lengths = [0.0; LANES];
        for i in 0..LANES {
            lengths[i] = self.heights[places[i]] - heights[i] + ROUNDING;
        }
        lengths
    }
}
