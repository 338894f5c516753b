//! Scan after a pass: heights of a ground surface, or a mask of exposed substrate.

use effects::Signal;
use sdf_bake::{HeightMap, PixelGrid};

use super::ExposureMask;
use super::write::{exposure_csv, heights_csv};

/// Scan after a pass.
#[derive(Clone, Debug, PartialEq)]
pub enum PassScan {
    /// The ground surface.
    Heights(HeightMap),
    /// Exposure after sanding.
    Exposure(ExposureMask),
}

impl PassScan {
    /// The scan of a pass that was not scanned: all its pixels are missing.
    pub fn missing(signal: Signal, pixels: PixelGrid) -> Self {
        match signal {
            Signal::Height => Self::Heights(HeightMap { pixels, heights: vec![f64::NAN; pixels.len()] }),
            Signal::Dose => Self::Exposure(ExposureMask { pixels, exposed: vec![None; pixels.len()] }),
        }
    }

    /// True if none of its pixels has a value. A scan that a plan asks for has no pixels yet, and is not missing.
    pub fn is_missing(&self) -> bool {
        match self {
            Self::Heights(map) => !map.heights.is_empty() && map.heights.iter().all(|height| height.is_nan()),
            Self::Exposure(mask) => !mask.exposed.is_empty() && mask.exposed.iter().all(Option::is_none),
        }
    }

    /// The heights, if it is a scan of them.
    pub fn heights(&self) -> Option<&HeightMap> {
        match self {
            Self::Heights(map) => Some(map),
            Self::Exposure(_) => None,
        }
    }

    /// The mask, if it is one.
    pub fn mask(&self) -> Option<&ExposureMask> {
        match self {
            Self::Exposure(mask) => Some(mask),
            Self::Heights(_) => None,
        }
    }

    /// Positions of the pixels.
    pub fn pixels(&self) -> PixelGrid {
        match self {
            Self::Heights(map) => map.pixels,
            Self::Exposure(mask) => mask.pixels,
        }
    }

    /// A scan of the same kind and pixels without values.
    #[must_use]
    pub fn unmeasured(&self) -> Self {
        let pixels = self.pixels();
        match self {
            Self::Heights(_) => Self::Heights(HeightMap { pixels, heights: Vec::new() }),
            Self::Exposure(_) => Self::Exposure(ExposureMask { pixels, exposed: Vec::new() }),
        }
    }

    /// The same kind of scan, converted by the function for its content.
    pub(super) fn converted(
        &self,
        heights: impl Fn(&HeightMap) -> HeightMap,
        exposed: impl Fn(&ExposureMask) -> ExposureMask,
    ) -> Self {
        match self {
            Self::Heights(map) => Self::Heights(heights(map)),
            Self::Exposure(mask) => Self::Exposure(exposed(mask)),
        }
    }

    /// Word for its kind in names of files.
    pub fn file_word(&self) -> &'static str {
        match self {
            Self::Heights(_) => "after",
            Self::Exposure(_) => "exposed",
        }
    }

    /// Its text as a file.
    pub fn csv(&self) -> String {
        match self {
            Self::Heights(map) => heights_csv(map),
            Self::Exposure(mask) => exposure_csv(mask),
        }
    }
}
