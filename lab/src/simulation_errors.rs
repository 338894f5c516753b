//! Errors of the simulation, measured by variants of the same campaign: on a lattice twice as fine; with passes that
//! begin or end a row of their logs earlier or later; and from the repeated scan before the first pass, which shows how
//! that scan's noise changes under the tool.
//!
//! Near the best values these differences change far less with the parameters than the surface does, so that they are
//! simulated only once there. The share of the lattice error that the data contain is one degree of freedom of the
//! campaign, with a prior (Kennedy and O'Hagan 2001): four thirds where the true surface is smooth (Richardson 1911;
//! Roache 1994), less where data come from a simulation on a lattice of their own.

use effects::CompiledModel;
use rayon::prelude::*;
use sdf_bake::HeightMap;
use serde::Serialize;

use super::evidence::EvidenceError;
use super::model_origin::identity;
use super::scans::ScanEvidence;
use trial_simulation::{PassEnds, SimulatedPass, Variation};
use trials::measure::ScanNoise;
use trials::trial::PassScan;

/// Ratio of the finer to the usual voxel; every pixel stays on a lattice line.
const FINER: f64 = 0.5;

/// Range of depths over which the previous scan's noise may fall to 1/e [m], and number of steps of the search.
const NOISE_DEPTHS: [f64; 2] = [1e-7, 1e-2];
const NOISE_DEPTH_STEPS: usize = 150;

/// Prior mean of the share of the lattice error in the data: 1 where they come from a lattice like the finer one, four
/// thirds where they are smooth.
const EXPECTED_SHARE: f64 = 1.0;
const SHARE_SIGMA: f64 = 1.0 / 3.0;
/// Standard deviation of the share between regions, which may differ in the order of convergence.
pub const SHARE_SPREAD: f64 = SHARE_SIGMA;

/// Errors of the simulation at each pixel of each scan: from its lattice, and from the unknown ends of passes.
#[derive(Clone, Debug, Serialize)]
pub struct SimulationErrors {
    /// Simulated scans on the usual lattice, by trial and pass.
    #[serde(skip)]
    usual: Vec<Vec<HeightMap>>,
    /// Correction of a simulated scan for the lattice error [m], by trial, pass and pixel.
    heights: Vec<Vec<Vec<f64>>>,
    /// Height change of a scan where its trial's passes begin a row of their logs earlier, and where they end one later
    /// [m], by trial, pass and pixel.
    ends: Vec<Vec<[Vec<f64>; 2]>>,
    /// Removed depth at which the noise of the scan before has fallen to 1/e [m].
    noise_depth: f64,
    /// SHA-256 of all errors.
    identity: String,
}

/// One simulated scan with its known errors, pixel by pixel.
#[derive(Clone, Copy, Debug)]
pub struct ScanErrors<'a> {
    /// The scan as it is simulated on the usual lattice.
    pub simulated: &'a HeightMap,
    /// Height on the finer lattice minus that on the usual one at each pixel [m].
    pub lattice: &'a [f64],
    /// Height change of each pixel where passes begin a row of their logs earlier, and where they end one later [m].
    pub ends: &'a [Vec<f64>; 2],
    /// Removed depth at which the noise of the scan before has fallen to 1/e [m].
    pub noise_depth: f64,
}

impl SimulationErrors {
    /// Simulates all passes of a ground campaign on both lattices, with shifted ends, and from the repeated scans.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn new(evidence: &ScanEvidence, model: &CompiledModel) -> Result<Self, EvidenceError> {
        let usual = &evidence.simulation;
        let finer = usual.on_voxels(FINER)?;
        let ends = |taken_over: f64, lifted: f64| {
            let ends = PassEnds { taken_over, lifted };
            usual.varied(move |_| Variation { ends, ..Variation::default() })
        };
        let (begun, ended) = (ends(-1.0, 0.0)?, ends(0.0, 1.0)?);
        let repeats: Vec<HeightMap> = evidence.noise.iter().map(ScanNoise::without_gaps).collect();
        let again = usual.varied(|trial| Variation { before: Some(&repeats[trial]), ..Variation::default() })?;
        let runs: Result<Vec<_>, _> =
            [usual, &finer, &begun, &ended, &again].into_par_iter().map(|simulation| simulation.run(model)).collect();
        let runs = runs?;
        let trial = |(usual, other): (&Vec<SimulatedPass>, &Vec<SimulatedPass>)| {
            usual.iter().zip(other).map(|(usual, other)| difference(&usual.scan, &other.scan)).collect()
        };
        let beside = |run: usize| -> Vec<Vec<Vec<f64>>> { runs[0].iter().zip(&runs[run]).map(trial).collect() };
        let heights = beside(1);
        let ends: Vec<Vec<[Vec<f64>; 2]>> = (beside(2).into_iter().zip(beside(3)))
            .map(|(begun, ended)| begun.into_iter().zip(ended).map(|(begun, ended)| [begun, ended]).collect())
            .collect();
        let noise_depth = noise_depth(evidence, &repeats, &beside(4));
        let identity = identity(&(&heights, &ends, noise_depth));
        let scans =
            |passes: &Vec<SimulatedPass>| passes.iter().filter_map(|pass| pass.scan.heights().cloned()).collect();
        Ok(Self { usual: runs[0].iter().map(scans).collect(), heights, ends, noise_depth, identity })
    }

    /// Known errors of a scan's simulation.
    pub fn beside(&self, trial: usize, pass: usize) -> ScanErrors<'_> {
        ScanErrors {
            simulated: &self.usual[trial][pass],
            lattice: &self.heights[trial][pass],
            ends: &self.ends[trial][pass],
            noise_depth: self.noise_depth,
        }
    }

    /// A simulated scan on the usual lattice, and its correction [m], one for each pixel.
    pub fn of(&self, trial: usize, pass: usize) -> (&HeightMap, &[f64]) {
        (&self.usual[trial][pass], &self.heights[trial][pass])
    }

    /// SHA-256 of all errors.
    pub fn identity(&self) -> &str {
        &self.identity
    }
}

/// Whitens residuals with the lattice error as one more degree of freedom: independent with variance one where it acts
/// in addition to noise. `field` is the contribution of the whole lattice error. The covariance `1 + σ² f fᵀ` has a
/// root in closed form.
pub fn without_lattice_error(residuals: &[f64], field: &[f64]) -> Vec<f64> {
    let left: Vec<f64> = residuals.iter().zip(field).map(|(r, f)| r - EXPECTED_SHARE * f).collect();
    change_without_lattice_error(&left, field)
}

/// Linear part of [`without_lattice_error`], for a change of residuals.
pub fn change_without_lattice_error(change: &[f64], field: &[f64]) -> Vec<f64> {
    let square = dot(field, field);
    if square == 0.0 {
        return change.to_vec();
    }
    let shrink = (1.0 - (1.0 + SHARE_SIGMA * SHARE_SIGMA * square).sqrt().recip()) / square;
    let along = shrink * dot(change, field);
    change.iter().zip(field).map(|(r, f)| r - along * f).collect()
}

/// Inverse of [`change_without_lattice_error`].
pub fn with_lattice_error(change: &[f64], field: &[f64]) -> Vec<f64> {
    let square = dot(field, field);
    if square == 0.0 {
        return change.to_vec();
    }
    let grow = ((1.0 + SHARE_SIGMA * SHARE_SIGMA * square).sqrt() - 1.0) / square;
    let along = grow * dot(change, field);
    change.iter().zip(field).map(|(r, f)| r + along * f).collect()
}

/// Most probable share of the lattice error in whitened residuals.
pub fn lattice_share(residuals: &[f64], field: &[f64]) -> f64 {
    let prior = SHARE_SIGMA.powi(-2);
    (EXPECTED_SHARE * prior + dot(residuals, field)) / (prior + dot(field, field))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Height of a scan on the finer lattice minus that on the usual lattice [m].
pub(super) fn difference(usual: &PassScan, finer: &PassScan) -> Vec<f64> {
    match (usual, finer) {
        (PassScan::Heights(usual), PassScan::Heights(finer)) => {
            let error = |(usual, finer): (&f64, &f64)| if (finer - usual).is_finite() { finer - usual } else { 0.0 };
            usual.heights.iter().zip(&finer.heights).map(error).collect()
        }
        _ => Vec::new(),
    }
}

/// Removed depth at which the noise of the scan before has fallen to 1/e [m]. It maps the differences between the two
/// scans before the first pass to those between simulations that start from them, by least squares over tiles.
///
/// A bump of height h under a spring of stiffness K wears at the rate k K h, and the ground at k (p − p_c): the depth
/// is about (p − p_c) / K.
fn noise_depth(evidence: &ScanEvidence, repeats: &[HeightMap], simulated: &[Vec<Vec<f64>>]) -> f64 {
    let mut tiles: Vec<[f64; 3]> = Vec::new();
    for view in &evidence.views {
        let Some(data) = view.data.as_heights() else { continue };
        let of = |heights: &[f64]| data.tiles.means(|at| if heights[at].is_finite() { heights[at] } else { 0.0 });
        let (before, after) = (of(&repeats[view.trial].heights), of(&simulated[view.trial][view.pass]));
        tiles.extend((0..data.tiles.len()).map(|k| [data.removed[k], before[k], after[k]]));
    }
    let cost = |depth: &f64| -> f64 {
        tiles.iter().map(|[removed, before, after]| (after - before * (-removed / depth).exp()).powi(2)).sum()
    };
    let depths = (0..=NOISE_DEPTH_STEPS)
        .map(|k| NOISE_DEPTHS[0] * (NOISE_DEPTHS[1] / NOISE_DEPTHS[0]).powf(k as f64 / NOISE_DEPTH_STEPS as f64));
    depths.min_by(|a, b| cost(a).total_cmp(&cost(b))).expect("there are steps")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_has_the_likelihood_of_the_joint_covariance() {
        let (residuals, field) = ([0.3, -1.2, 2.0, 0.5], [1.5, -0.4, 0.7, 2.2]);
        let variance = |i: usize, j: usize| SHARE_SIGMA.powi(2) * field[i] * field[j] + f64::from(u8::from(i == j));
        let covariance = nalgebra::Matrix4::from_fn(variance);
        let centred = nalgebra::Vector4::from_fn(|i, _| residuals[i] - EXPECTED_SHARE * field[i]);
        let expected = centred.dot(&(covariance.try_inverse().unwrap() * centred));
        let left = without_lattice_error(&residuals, &field);
        assert!((dot(&left, &left) - expected).abs() < 1e-12);
        let [up, down] = [1.0, -1.0].map(|sign| residuals.map(|r| sign * r));
        let [up, down] = [up, down].map(|residuals| without_lattice_error(&residuals, &field));
        let change: Vec<f64> = up.iter().zip(&down).map(|(up, down)| 0.5 * (up - down)).collect();
        for (undone, r) in with_lattice_error(&change, &field).iter().zip(residuals) {
            assert!((undone - r).abs() < 1e-12);
        }
    }

    #[test]
    fn the_share_is_found_where_the_field_is_strong() {
        let field: Vec<f64> = (0..200).map(|k| f64::from(k % 7) - 3.0).collect();
        let residuals: Vec<f64> = field.iter().map(|f| 1.25 * f).collect();
        assert!((lattice_share(&residuals, &field) - 1.25).abs() < 0.01);
        assert_eq!(lattice_share(&[], &[]), EXPECTED_SHARE);
    }
}
