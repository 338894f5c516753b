//! Height maps as instruments give them, and the solid below one as a signed distance field.
//!
//! A map is a regular grid of points: pixel (i, j) is the *point* `origin + pitch · (i, j)`, i along x, j along y.
//! A height is along z; NaN is a pixel that the instrument could not see.
//!
//! [`BrickGrid::from_heights`](crate::BrickGrid::from_heights) cleans the map (`spikes`, `fill`), lays its surface on
//! the voxel lattice (`lattice`) and measures the distance of every voxel in the band to it (`foot`, `solid`).

mod fill;
mod foot;
mod lattice;
mod solid;
mod spikes;

use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use solid::{HeightsReport, SlabOptions};

/// Fewest seen pixels along each axis that make a surface.
pub const LEAST_PIXELS: usize = 4;

/// Where the pixels of an instrument lie.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PixelGrid {
    /// x, y of the first pixel [m].
    pub origin: DVec2,
    /// Distance between pixels along x and y [m].
    pub pitch: f64,
    /// Pixels along x.
    pub nx: usize,
    /// Pixels along y.
    pub ny: usize,
}

impl PixelGrid {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.nx * self.ny
    }

    /// Whether there is no pixel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Position of pixel (i, j) in a list of values; i runs fastest.
    pub fn at(&self, i: usize, j: usize) -> usize {
        j * self.nx + i
    }

    /// Place of pixel (i, j) [m].
    pub fn position(&self, i: usize, j: usize) -> DVec2 {
        self.origin + self.pitch * DVec2::new(i as f64, j as f64)
    }

    /// Pixel coordinates of a place [m]: whole numbers at the pixels.
    pub fn coordinates(&self, place: DVec2) -> DVec2 {
        (place - self.origin) / self.pitch
    }

    /// Index of the pixel nearest to a place [m], `None` if that is more than half a pitch beyond the border.
    pub fn nearest(&self, place: DVec2) -> Option<usize> {
        let at = self.coordinates(place).round();
        let within = at.cmpge(DVec2::ZERO).all() && at.x < self.nx as f64 && at.y < self.ny as f64;
        within.then(|| self.at(at.x as usize, at.y as usize))
    }
}

/// Heights on a pixel grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeightMap {
    /// Where the pixels lie.
    pub pixels: PixelGrid,
    /// Heights [m], NaN where missing, shape `[ny, nx]`.
    pub heights: Vec<f64>,
}

impl HeightMap {
    /// A map from a function of place [m] to height [m].
    pub fn from_function(pixels: PixelGrid, height: impl Fn(DVec2) -> f64) -> Self {
        let heights = (0..pixels.len()).map(|k| height(pixels.position(k % pixels.nx, k / pixels.nx))).collect();
        Self { pixels, heights }
    }

    /// Height of pixel (i, j) [m], NaN where missing.
    pub fn height(&self, i: usize, j: usize) -> f64 {
        self.heights[self.pixels.at(i, j)]
    }

    /// Number of missing pixels.
    pub fn missing(&self) -> usize {
        self.heights.iter().filter(|height| height.is_nan()).count()
    }

    /// Indices of pixels that stick out of their surroundings in every direction.
    ///
    /// A pixel's excess along a direction is its height less the mean of its two neighbours there, which no slope
    /// changes; a ridge or a toe has one direction without excess. A spike's least excess over the four directions is
    /// above five robust standard deviations of all excesses, of those in the 5 x 5 pixels around it, and above what
    /// a crown with a radius of ten pixels has.
    pub fn spikes(&self) -> Vec<usize> {
        spikes::find(self)
    }

    /// The map with missing pixels filled by the thin plate through the others (least bending energy). Pixels that
    /// are seen stay.
    ///
    /// # Errors
    /// [`HeightsError`] when shape and pitch do not make a map, or too few pixels are seen.
    pub fn filled(&self) -> Result<Self, HeightsError> {
        self.check()?;
        Ok(fill::filled(self))
    }

    /// Checks shape, pitch and number of seen pixels.
    pub(crate) fn check(&self) -> Result<(), HeightsError> {
        let PixelGrid { origin, pitch, nx, ny } = self.pixels;
        if !(pitch > 0.0 && pitch.is_finite() && origin.is_finite()) {
            return Err(HeightsError::BadGrid { origin, pitch });
        }
        if self.heights.len() != nx * ny {
            return Err(HeightsError::WrongShape { found: self.heights.len(), nx, ny });
        }
        let seen = self.heights.iter().filter(|height| height.is_finite()).count();
        if nx.min(ny) < LEAST_PIXELS || 4 * seen < nx * ny {
            return Err(HeightsError::TooFewPixels { seen, nx, ny });
        }
        Ok(())
    }
}

/// Why a height map makes no surface.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum HeightsError {
    /// Origin or pitch is no length.
    #[error("origin {origin} m and pitch {pitch} m: finite values and a pitch above zero are expected")]
    BadGrid {
        /// Origin given [m].
        origin: DVec2,
        /// Pitch given [m].
        pitch: f64,
    },
    /// The number of values is not that of the pixels.
    #[error("{found} heights for {nx} x {ny} pixels")]
    WrongShape {
        /// Heights given.
        found: usize,
        /// Pixels along x.
        nx: usize,
        /// Pixels along y.
        ny: usize,
    },
    /// Not enough was seen.
    #[error("{seen} of {nx} x {ny} pixels are seen: at least 4 x 4 pixels and a quarter of them are needed")]
    TooFewPixels {
        /// Pixels with a height.
        seen: usize,
        /// Pixels along x.
        nx: usize,
        /// Pixels along y.
        ny: usize,
    },
    /// The field, or the map with its margin, would not fit in memory.
    #[error("{points:.1e} points: at most {accepted:.0e} are accepted; use a larger voxel or a smaller margin")]
    TooLarge {
        /// Lattice points, or pixels of the map's rows with the margin.
        points: f64,
        /// Points that are accepted.
        accepted: f64,
    },
    /// The pixels between voxels would take too long to smooth.
    #[error(
        "a voxel of {pixels:.0} pixels: at most {accepted:.0e} sums are accepted, not {sums:.1e}; use a smaller voxel or margin"
    )]
    TooCoarse {
        /// Pixels along a voxel.
        pixels: f64,
        /// Products that smoothing would add up.
        sums: f64,
        /// Products that are accepted.
        accepted: f64,
    },
    /// Heights so far apart that their steps, as walls, or the box around them would not fit in memory.
    #[error(
        "heights from {:?} mm to {:?} mm are too far apart for a voxel of {:?} mm: leave cells without a height empty, or use a \
         larger voxel",
        1e3 * low, 1e3 * high, 1e3 * voxel
    )]
    TooFarApart {
        /// Least height [m].
        low: f64,
        /// Greatest height [m].
        high: f64,
        /// Voxel asked for [m].
        voxel: f64,
    },
    /// The options make no field.
    #[error("{name} is {found}, it must be {accepted}")]
    BadOption {
        /// Field of [`SlabOptions`].
        name: &'static str,
        /// Value given.
        found: f64,
        /// What would do.
        accepted: &'static str,
    },
}
