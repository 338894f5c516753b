//! Height maps of instruments, and the solid below a map as a signed distance field.
//!
//! A map is a regular grid of points: pixel (i, j) is the *point* `origin + pitch · (i, j)`, i along x, j along y.
//! A height is along z; NaN is a pixel that the instrument could not measure.
//!
//! [`BrickGrid::from_heights`](crate::BrickGrid::from_heights) cleans the map (`spikes`, `fill`), resamples its surface
//! on the voxel lattice (`lattice`) and computes the distance of every voxel in the band to it (`foot`, `solid`).

mod fill;
mod foot;
mod lattice;
mod solid;
mod spikes;

use glam::DVec2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use solid::{HeightsReport, SlabOptions};

/// Least number of measured pixels along each axis.
pub const LEAST_PIXELS: usize = 4;

/// Positions of an instrument's pixels.
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

    /// True if there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of pixel (i, j) in a list of values; i runs fastest.
    pub fn at(&self, i: usize, j: usize) -> usize {
        j * self.nx + i
    }

    /// Position of pixel (i, j) [m].
    pub fn position(&self, i: usize, j: usize) -> DVec2 {
        self.origin + self.pitch * DVec2::new(i as f64, j as f64)
    }

    /// Pixel coordinates of a position [m]: whole numbers at the pixels.
    pub fn coordinates(&self, place: DVec2) -> DVec2 {
        (place - self.origin) / self.pitch
    }

    /// Index of the pixel nearest to a position [m]; `None` more than half a pitch beyond the border.
    pub fn nearest(&self, place: DVec2) -> Option<usize> {
        let at = self.coordinates(place).round();
        let within = at.cmpge(DVec2::ZERO).all() && at.x < self.nx as f64 && at.y < self.ny as f64;
        within.then(|| self.at(at.x as usize, at.y as usize))
    }
}

/// Heights on a pixel grid.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeightMap {
    /// Positions of the pixels.
    pub pixels: PixelGrid,
    /// Heights [m], NaN where missing, shape `[ny, nx]`.
    pub heights: Vec<f64>,
}

impl HeightMap {
    /// Map from a function of position [m] to height [m].
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

    /// Indices of pixels that stand out from their surroundings in every direction.
    ///
    /// A pixel's excess along a direction is its height minus the mean of its two neighbours in that direction, which
    /// no slope changes; along a ridge or a toe one direction has no excess. A spike's least excess over the four
    /// directions exceeds five robust standard deviations of all excesses, five of those in the 5 x 5 pixels around it,
    /// and the excess of a crown with a radius of ten pixels.
    pub fn spikes(&self) -> Vec<usize> {
        spikes::find(self)
    }

    /// Fills missing pixels by the thin plate of least bending energy through the others. Measured pixels do not
    /// change.
    ///
    /// # Errors
    /// [`HeightsError`] if shape and pitch are invalid, or too few pixels are measured.
    pub fn filled(&self) -> Result<Self, HeightsError> {
        self.check()?;
        Ok(fill::filled(self))
    }

    /// Checks shape, pitch and number of measured pixels.
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

/// Reason why a height map gives no surface.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum HeightsError {
    /// Origin or pitch is invalid.
    #[error("origin {origin} m and pitch {pitch} m: finite values and a pitch above zero are expected")]
    BadGrid {
        /// Origin given [m].
        origin: DVec2,
        /// Pitch given [m].
        pitch: f64,
    },
    /// The number of values differs from that of the pixels.
    #[error("{found} heights for {nx} x {ny} pixels")]
    WrongShape {
        /// Number of heights given.
        found: usize,
        /// Pixels along x.
        nx: usize,
        /// Pixels along y.
        ny: usize,
    },
    /// Too few pixels are measured.
    #[error("{seen} of {nx} x {ny} pixels are seen: at least 4 x 4 pixels and a quarter of them are needed")]
    TooFewPixels {
        /// Number of measured pixels.
        seen: usize,
        /// Pixels along x.
        nx: usize,
        /// Pixels along y.
        ny: usize,
    },
    /// The field, or the map with its margin, is too large for memory.
    #[error("{points:.1e} points: at most {accepted:.0e} are accepted; use a larger voxel or a smaller margin")]
    TooLarge {
        /// Number of lattice points, or of pixels of the map's rows with the margin.
        points: f64,
        /// Greatest accepted number of points.
        accepted: f64,
    },
    /// Smoothing the pixels between voxels would take too long.
    #[error(
        "a voxel of {pixels:.0} pixels: at most {accepted:.0e} sums are accepted, not {sums:.1e}; use a smaller voxel or margin"
    )]
    TooCoarse {
        /// Pixels per voxel.
        pixels: f64,
        /// Number of products that smoothing would sum.
        sums: f64,
        /// Greatest accepted number of products.
        accepted: f64,
    },
    /// Heights differ so much that steps as vertical walls, or the box around them, are too large for memory.
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
        /// Requested voxel [m].
        voxel: f64,
    },
    /// An option is out of range.
    #[error("{name} is {found}, it must be {accepted}")]
    BadOption {
        /// Field of [`SlabOptions`].
        name: &'static str,
        /// Value given.
        found: f64,
        /// Accepted values.
        accepted: &'static str,
    },
}
