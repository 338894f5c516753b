//! Errors of simulated masks: the dose that the lattice misses, and the noise of the border beside the simulation.

use effects::CompiledModel;

use super::border_noise::{BorderNoise, BorderResidual};
use super::evidence::{EvidenceError, Split};
use super::exposure_view::ExposureView;
use super::model_origin::identity;
use super::nuisances::Nuisances;
use super::scans::{ScanEvidence, ScanView};
use trial_simulation::SimulatedPass;

/// Greatest ratio of the finer to the usual voxel; the finer voxel is a pixel, or less.
const FINER: f64 = 0.5;

/// Lattice error of simulated masks.
#[derive(Clone, Debug)]
pub struct MaskErrors {
    /// Dose on the finer lattice minus that on the usual one [1], by trial, pass and pixel.
    doses: Vec<Vec<Vec<f64>>>,
    /// SHA-256 of the doses and of the noise of the border.
    identity: String,
}

impl MaskErrors {
    /// Dose that the usual lattice misses at each pixel of a mask.
    pub(super) fn of(&self, trial: usize, pass: usize) -> &[f64] {
        &self.doses[trial][pass]
    }

    /// SHA-256 of all errors.
    pub(super) fn identity(&self) -> &str {
        &self.identity
    }
}

impl ScanEvidence<'_> {
    /// Measures the lattice error of masks near a model, and fits the noise of their borders to the residuals.
    /// From then on both are part of the data's covariance, and there is no coarser lattice.
    ///
    /// # Errors
    /// If the model cannot be simulated on the finer lattice.
    pub(super) fn measure_mask_errors(&mut self, model: &CompiledModel) -> Result<(), EvidenceError> {
        self.mask_errors = None;
        let simulation = &self.simulation.trials()[0];
        let finer = simulation.trial.scans.before.pixels.pitch / simulation.part.voxel;
        let finer = self.simulation.on_voxels(finer.min(FINER))?;
        let (usual, finer) = rayon::join(|| self.simulation.run(model), || finer.run(model));
        let (usual, finer) = (usual?, finer?);
        let margins = |view: &ScanView, passes: &[Vec<SimulatedPass>]| {
            self.predicted(view, (passes, model), Nuisances::default())
        };
        let both = |view: &ScanView| Ok::<_, EvidenceError>([margins(view, &usual)?, margins(view, &finer)?]);
        let both: Vec<[Vec<f64>; 2]> = self.views.iter().map(both).collect::<Result<_, _>>()?;
        let noise = self.border_noise(&both);
        for (view, margins) in self.views.iter_mut().zip(&both) {
            let Some(data) = view.data.as_exposure() else { continue };
            let informed = data.clone().beside(noise, margins.each_ref().map(|margins| &margins[..]));
            view.data = Box::new(informed.expect("noise of single tiles keeps a covariance definite"));
        }
        let mut doses: Vec<Vec<Vec<f64>>> = usual.iter().map(|passes| vec![Vec::new(); passes.len()]).collect();
        for (view, [usual, finer]) in self.views.iter().zip(&both) {
            let missed = usual.iter().zip(finer).map(|(usual, finer)| finer - usual);
            doses[view.trial][view.pass] = missed.map(|missed| if missed.is_finite() { missed } else { 0.0 }).collect();
        }
        let of_noise =
            noise.map(|noise| (noise.dose, noise.tile.alone, noise.tile.shared, noise.tile.length, noise.tile.kernel));
        let identity = identity(&(&doses, of_noise));
        self.mask_errors = Some(MaskErrors { doses, identity });
        self.prepare_lattices();
        Ok(())
    }

    /// Noise of the borders beside simulations on the finer lattice; `None` if the calibration masks show too little.
    fn border_noise(&self, margins: &[[Vec<f64>; 2]]) -> Option<BorderNoise> {
        let masks = self.views.iter().zip(margins).filter(|(view, _)| view.split == Split::Calibration);
        let masks: Vec<(&ExposureView, &[Vec<f64>; 2])> =
            masks.filter_map(|(view, margins)| Some((view.data.as_exposure()?, margins))).collect();
        let residuals: Vec<Vec<BorderResidual>> =
            masks.iter().map(|(data, [_, finer])| data.border_residuals(finer)).collect();
        let first = masks.first()?.0;
        BorderNoise::fitted(&residuals, (first.tile_side(), first.measured.pixels.pitch))
    }

    /// Adds the share of the lattice error in the data to the simulated doses of a mask.
    pub(super) fn with_missed_dose(&self, view: &ScanView, mut margins: Vec<f64>, share: f64) -> Vec<f64> {
        if let Some(errors) = self.mask_errors.as_ref().filter(|_| share != 0.0) {
            margins.iter_mut().zip(errors.of(view.trial, view.pass)).for_each(|(dose, missed)| *dose += share * missed);
        }
        margins
    }
}
