//! Data for viewing a simulated model: fields of the workpiece, and residual maps.

use effects::CompiledModel;
use report::study::ColourScale;
use sdf_bake::PixelGrid;
use study::{ExposureMaps, HeightMaps, Maps, PassTiles, StudyReport};

use super::fields::{TrialFields, fields};
use lab::{EvidenceError, ScanEvidence};

/// Simulated fields and residual maps of a model.
pub(crate) struct Live {
    /// Fields of each trial.
    pub(crate) trials: Vec<TrialFields>,
    /// One map for each scan.
    pub(crate) maps: Vec<ScanMap>,
    /// Residuals and covariates of the tiles of each scan.
    pub(crate) tiles: Vec<PassTiles>,
}

/// Residual map of one scan.
pub(crate) struct ScanMap {
    /// Index of the trial, from 0.
    pub(crate) trial: usize,
    /// Index of the pass, from 0.
    pub(crate) pass: usize,
    /// Positions of the pixels.
    pub(crate) pixels: PixelGrid,
    /// Residuals at the pixels.
    pub(crate) residuals: Residuals,
}

/// Residuals at each pixel of a scan.
pub(crate) enum Residuals {
    /// Height residuals after grinding.
    Heights {
        /// Measured - simulated [m], NaN where missing, shape `[ny, nx]`.
        left: Vec<f64>,
        /// Scan noise [m]: root mean square of one pixel's error.
        floor: f64,
        /// Colour scale of the residuals.
        scale: ColourScale,
    },
    /// Exposed substrate after sanding.
    Exposure {
        /// Measured exposure; `None` where the optics could not decide, shape `[ny, nx]`.
        measured: Vec<Option<bool>>,
        /// Simulated exposure, shape `[ny, nx]`.
        simulated: Vec<bool>,
    },
}

impl Live {
    /// Simulates a model, and takes its residual maps from a report.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub(super) fn new(
        evidence: &ScanEvidence,
        model: &CompiledModel,
        report: &StudyReport,
    ) -> Result<Self, EvidenceError> {
        let name = |trial: usize, pass: usize| {
            format!("{}, pass {}", evidence.simulation.trials()[trial].trial.name, pass + 1)
        };
        let of = |view: &lab::ScanView| {
            let own = name(view.trial, view.pass);
            let scan = report.scans.iter().find(|scan| scan.pass == own)?;
            Some(ScanMap::new((view.trial, view.pass), &scan.maps))
        };
        let maps = evidence.views.iter().filter_map(of).collect();
        Ok(Self { trials: fields(&evidence.simulation, model)?, maps, tiles: report.tiles.clone() })
    }

    /// Returns the residual map of the scan after a pass.
    pub(crate) fn map(&self, trial: usize, pass: usize) -> Option<&ScanMap> {
        self.maps.iter().find(|map| (map.trial, map.pass) == (trial, pass))
    }
}

impl ScanMap {
    /// Takes the residual map of the whole model.
    fn new((trial, pass): (usize, usize), maps: &Maps) -> Self {
        let (pixels, residuals) = match maps {
            Maps::Heights(HeightMaps { pixels, base, with_effect, noise_floor, .. }) => {
                let left = with_effect.as_ref().unwrap_or(base).clone();
                // The scale is that of the base model, so that colours fade as the error falls.
                let scale = ColourScale::new(*noise_floor, base.iter().copied());
                (*pixels, Residuals::Heights { left, floor: *noise_floor, scale })
            }
            Maps::Exposure(ExposureMaps { pixels, measured, base, with_effect }) => {
                let simulated = with_effect.as_ref().unwrap_or(base).clone();
                (*pixels, Residuals::Exposure { measured: measured.clone(), simulated })
            }
        };
        Self { trial, pass, pixels, residuals }
    }

    /// Returns the height residual at a position [m], interpolated from the four pixels around it; `None` after
    /// sanding, outside the map and beside a missing pixel.
    pub(crate) fn left_at(&self, place: glam::DVec2) -> Option<f64> {
        let Residuals::Heights { left, .. } = &self.residuals else { return None };
        let value = interpolated(&self.pixels, left, place);
        value.is_finite().then_some(value)
    }
}

/// Interpolates a value at a position [m] from the four pixels around it; NaN outside the map and beside a missing
/// pixel.
pub(crate) fn interpolated(pixels: &PixelGrid, values: &[f64], place: glam::DVec2) -> f64 {
    let at = pixels.coordinates(place);
    let low = at.floor();
    let (i, j) = (low.x, low.y);
    if !(i >= 0.0 && j >= 0.0 && i + 1.0 < pixels.nx as f64 && j + 1.0 < pixels.ny as f64) {
        return pixels.nearest(place).map_or(f64::NAN, |at| values[at]);
    }
    let (f, at) = (at - low, pixels.at(i as usize, j as usize));
    let row = |at: usize| (1.0 - f.x) * values[at] + f.x * values[at + 1];
    (1.0 - f.y) * row(at) + f.y * row(at + pixels.nx)
}
