//! The scanner of a trial: the surface at its pixels, and the scan that it reports under a model.

use effects::{CompiledModel, RunError, StepValues, Variable};
use sdf_bake::{BrickGrid, PixelGrid};
use sim::{Profilometer, Topography};

use trials::trial::{ExposureMask, PassScan};

/// The surface at the scanner's pixels after a pass, before the model's effects on the scanner.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenSurface {
    /// Number of the pass in its trial, from 1.
    pass: usize,
    /// Row of parameters that have one value per pass or scan, from 0.
    row: usize,
    shown: ScannedQuantity,
}

/// Quantity that is scanned after a pass.
#[derive(Clone, Debug, PartialEq)]
enum ScannedQuantity {
    /// After grinding.
    Heights(Topography),
    /// Coating dose at each pixel, NaN where there is no surface; after sanding.
    Doses(PixelGrid, Vec<f64>),
}

impl SeenSurface {
    /// Reads a part at the pixels of a trial's scan.
    ///
    /// - `like`: the trial's own scan after the pass
    /// - `pass`, `row`: number of the pass in its trial, from 1; row of parameters per pass or scan, from 0
    pub fn of(
        part: &BrickGrid,
        (pixels, like): (PixelGrid, &PassScan),
        model: &CompiledModel,
        (pass, row): (usize, usize),
    ) -> Self {
        let shown = match like {
            PassScan::Heights(_) => ScannedQuantity::Heights(Topography::read(part, pixels, model)),
            PassScan::Exposure(_) => {
                ScannedQuantity::Doses(pixels, Profilometer::sharp(pixels).channel(part, &part.dose))
            }
        };
        Self { pass, row, shown }
    }

    /// Dose minus exposure threshold at each pixel, NaN where there is no surface; `None` for grinding.
    ///
    /// # Errors
    /// A formula that gives no finite number.
    pub fn dose_margin(&self, model: &CompiledModel) -> Result<Option<Vec<f64>>, RunError> {
        let ScannedQuantity::Doses(_, doses) = &self.shown else { return Ok(None) };
        let threshold = model.exposure_threshold(&self.step())?;
        Ok(Some(doses.iter().map(|dose| dose - threshold).collect()))
    }

    /// Variables of the scanner's formulas for the scan.
    fn step(&self) -> StepValues {
        let mut step = StepValues::new();
        (step.pass_row, step.scan_row) = (self.row, self.row);
        step.set(Variable::PassNumber, self.pass as f64);
        step
    }

    /// The scan that the model's scanner reports. It needs no new simulation: other values of the scanner's parameters
    /// cost one evaluation of its formulas over the pixels.
    ///
    /// - `model`: that of the simulated pass, or the same with other parameter values
    ///
    /// # Errors
    /// A formula that gives no finite number.
    pub fn reported(&self, model: &CompiledModel) -> Result<PassScan, RunError> {
        let step = self.step();
        Ok(match &self.shown {
            ScannedQuantity::Heights(surface) => PassScan::Heights(surface.reported(model, &step)?),
            ScannedQuantity::Doses(pixels, doses) => {
                let threshold = model.exposure_threshold(&step)?;
                let exposed = doses.iter().map(|dose| dose.is_finite().then_some(*dose >= threshold)).collect();
                PassScan::Exposure(ExposureMask { pixels: *pixels, exposed })
            }
        })
    }
}

/// Share of exposed pixels among those with a value.
pub fn exposed_share(mask: &ExposureMask) -> f64 {
    let known = mask.exposed.iter().flatten();
    known.clone().filter(|exposed| **exposed).count() as f64 / known.count().max(1) as f64
}
