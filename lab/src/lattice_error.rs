//! The error that the simulation's own lattice makes, from the same campaign on a lattice twice as fine.
//!
//! Near the best values the difference of the two changes far less with the parameters than the surface does. So it is
//! simulated once there, and added to every simulation of a fit (additive correction, Kennedy and O'Hagan 2000). Of a
//! simulation of second order the finer one still errs by a third of the difference (Richardson 1911; Roache 1994): so much
//! enters the covariance. It is not extrapolated, because rims converge unevenly.

use effects::CompiledModel;
use rayon::prelude::*;
use serde::Serialize;

use super::evidence::EvidenceError;
use super::model_origin::identity;
use super::scans::ScanEvidence;
use crate::simulation::SimulatedPass;
use trials::trial::PassScan;

/// Voxels of the finer lattice over those of the usual one: every pixel stays on a lattice line.
const FINER: f64 = 0.5;

/// What the lattice takes off or adds at each pixel of each scan.
#[derive(Clone, Debug, Serialize)]
pub struct LatticeError {
    /// Height to add to a simulated scan [m] by trial, pass and pixel.
    heights: Vec<Vec<Vec<f64>>>,
    /// Identity of all of them.
    identity: String,
}

impl LatticeError {
    /// Simulates all passes of a ground campaign on both lattices.
    ///
    /// # Errors
    /// When the model cannot be simulated.
    pub fn new(evidence: &ScanEvidence, model: &CompiledModel) -> Result<Self, EvidenceError> {
        let usual = &evidence.simulation;
        let finer = usual.on_voxels(FINER)?;
        let runs: Result<Vec<_>, _> = [usual, &finer].into_par_iter().map(|simulation| simulation.run(model)).collect();
        let runs = runs?;
        let trial = |(usual, finer): (&Vec<SimulatedPass>, &Vec<SimulatedPass>)| {
            usual.iter().zip(finer).map(|(usual, finer)| difference(&usual.scan, &finer.scan)).collect()
        };
        let heights: Vec<Vec<Vec<f64>>> = runs[0].iter().zip(&runs[1]).map(trial).collect();
        let identity = identity(&heights);
        Ok(Self { heights, identity })
    }

    /// Heights to add to a scan [m], one for each pixel.
    pub fn of(&self, trial: usize, pass: usize) -> &[f64] {
        &self.heights[trial][pass]
    }

    /// What tells it from others.
    pub fn identity(&self) -> &str {
        &self.identity
    }
}

/// What a scan on the finer lattice has above one on the usual lattice [m].
fn difference(usual: &PassScan, finer: &PassScan) -> Vec<f64> {
    match (usual, finer) {
        (PassScan::Heights(usual), PassScan::Heights(finer)) => {
            let error = |(usual, finer): (&f64, &f64)| if (finer - usual).is_finite() { finer - usual } else { 0.0 };
            usual.heights.iter().zip(&finer.heights).map(error).collect()
        }
        _ => Vec::new(),
    }
}
