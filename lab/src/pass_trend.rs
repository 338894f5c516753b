//! Measured change of the removal between equal successive passes, and the range of changes that a law can produce with
//! any parameters. A law without memory cannot describe a tool that changes.

use effects::CompiledModel;
use rayon::prelude::*;
use serde::Serialize;

use super::coordinates::{Coordinate, moved};
use super::evidence::{Evidence, EvidenceError, Split};
use super::rows::RowEvidence;
use super::scans::{ScanEvidence, ScanView};
use crate::criteria::{SAME_LOAD, SAME_SETTING, TREND_FACTOR, TREND_REMOVAL_SHARE, TREND_SIGMAS, TREND_VALUES};
use trials::trial::Pass;

/// Relative change of the removed volume or depth between equal successive passes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassTrend {
    /// Number of pairs of equal passes.
    pub pairs: usize,
    /// Measured mean change.
    pub measured: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// Change that the model predicts.
    pub model: f64,
    /// Least and greatest change that the law can produce.
    pub reach: [f64; 2],
    /// Description of the parameter values that were tried.
    pub tried: &'static str,
    /// True if no values of the law produce the measured change.
    pub out_of_reach: bool,
}

impl PassTrend {
    /// - `measured`: logarithms of ratios and their standard deviations
    /// - `model`, `tried_changes`: mean logarithm of the model's ratio with its own values, and with each set of tried
    ///   values
    fn new(measured: &[(f64, f64)], model: f64, tried_changes: &[f64], tried: &'static str) -> Option<Self> {
        let weights: f64 = measured.iter().map(|(_, sigma)| sigma.powi(-2)).sum();
        let mean = measured.iter().map(|(change, sigma)| change / (sigma * sigma)).sum::<f64>() / weights;
        let all = || tried_changes.iter().copied().chain([model]).filter(|change| change.is_finite());
        let reach = [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)];
        let sigma = weights.powf(-0.5);
        (mean.is_finite() && reach[0].is_finite()).then(|| Self {
            pairs: measured.len(),
            measured: mean.exp_m1(),
            sigma: sigma * mean.exp(),
            model: model.exp_m1(),
            reach: reach.map(f64::exp_m1),
            tried,
            out_of_reach: mean - TREND_SIGMAS * sigma > reach[1] || mean + TREND_SIGMAS * sigma < reach[0],
        })
    }

    /// Sentence for display.
    pub fn sentence(&self) -> String {
        let percent = |change: f64| format!("{:+.1}", 100.0 * change);
        let verdict =
            if self.out_of_reach { "no values of its parameters can follow" } else { "its parameters can follow" };
        format!(
            "From a pass to an equal one after it the removal changes by {} ± {:.1} %; the base law changes it by {} to {} % {}: {verdict}.",
            percent(self.measured),
            100.0 * self.sigma,
            percent(self.reach[0]),
            percent(self.reach[1]),
            self.tried,
        )
    }
}

/// Trend of the calibration rows that follow an equal one by the same tool without dressing; `None` if there are none.
///
/// # Errors
/// If the model cannot be evaluated.
pub fn trend_of_rows(evidence: &RowEvidence, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
    let pairs = equal_rows(evidence);
    if pairs.is_empty() {
        return Ok(None);
    }
    let rows = &evidence.table.rows;
    let change = |&(a, b): &(usize, usize)| (rows[b].removal_rate? / rows[a].removal_rate?).ln().into();
    let measured: Vec<(f64, f64)> = pairs
        .iter()
        .filter_map(change)
        .map(|change: f64| (change, evidence.noise * std::f64::consts::SQRT_2))
        .collect();
    let of = |model: &CompiledModel| -> Result<f64, EvidenceError> {
        let predicted = evidence.predicted(model)?;
        let most = predicted.iter().copied().fold(0.0, f64::max);
        let enough = pairs.iter().all(|&(a, b)| predicted[a].min(predicted[b]) > TREND_REMOVAL_SHARE * most);
        let sum: f64 = pairs.iter().map(|&(a, b)| (predicted[b] / predicted[a]).ln()).sum();
        Ok(if enough { sum / pairs.len() as f64 } else { f64::NAN })
    };
    let coordinates = law_coordinates(evidence, model);
    let grid = grid(&coordinates);
    let tried: Vec<f64> = grid.par_iter().map(|at| of(&moved(model, &coordinates, at)).unwrap_or(f64::NAN)).collect();
    Ok(PassTrend::new(&measured, of(model)?, &tried, "over the whole range of its parameters"))
}

/// Pairs of successive calibration rows with equal settings and the same tool, without dressing in between.
fn equal_rows(evidence: &RowEvidence) -> Vec<(usize, usize)> {
    let rows = &evidence.table.rows;
    let near = |a: Option<f64>, b: Option<f64>, same: f64| match (a, b) {
        (Some(a), Some(b)) => (b / a).ln().abs() < same,
        (a, b) => a == b,
    };
    let is_equal = |&(a, b): &(usize, usize)| {
        let (first, next) = (&rows[a], &rows[b]);
        let force = near(first.force, next.force, SAME_LOAD) && near(first.pressure, next.pressure, SAME_LOAD);
        let rest = near(first.speed, next.speed, SAME_SETTING) && near(first.duration, next.duration, SAME_SETTING);
        !next.fresh && first.tool == next.tool && first.group == next.group && force && rest
    };
    let calibrates = |at: &usize| evidence.of(Split::Calibration).contains(at);
    (1..rows.len()).map(|b| (b - 1, b)).filter(|(a, b)| calibrates(a) && calibrates(b)).filter(is_equal).collect()
}

/// Trend of the calibration scans after equal passes on one workpiece; `None` if there are none.
///
/// # Errors
/// If the model cannot be simulated.
pub fn trend_of_scans(evidence: &ScanEvidence, model: &CompiledModel) -> Result<Option<PassTrend>, EvidenceError> {
    let scans = EqualScans::new(evidence);
    if scans.pairs.is_empty() {
        return Ok(None);
    }
    let here = scans.volumes(model)?;
    let measured: Vec<(f64, f64)> =
        scans.pairs.iter().map(|&pair| (scans.change(&here, pair, 0), scans.sigma(&here, pair))).collect();
    let coordinates = law_coordinates(evidence, model);
    let at: Vec<f64> = coordinates.iter().map(|c| c.from_value(model.value(c.index))).collect();
    let ways = coordinates.iter().enumerate().flat_map(|(k, coordinate)| {
        let value = coordinate.value(at[k]);
        [value / TREND_FACTOR, value * TREND_FACTOR].map(|value| (k, coordinate.clamped(coordinate.from_value(value))))
    });
    let changed = |(k, value): (usize, f64)| {
        let mut there = at.clone();
        there[k] = value;
        scans.volumes(&moved(model, &coordinates, &there)).map_or(f64::NAN, |volumes| scans.mean(&volumes))
    };
    let tried: Vec<f64> = ways.collect::<Vec<_>>().into_par_iter().map(changed).collect();
    Ok(PassTrend::new(&measured, scans.mean(&here), &tried, "with each parameter at a third and three times its value"))
}

/// Volumes up to each scan [m³]: measured, its standard deviation, simulated.
type Volumes = Vec<[f64; 3]>;

/// Calibration scans, and the pairs of successive scans after equal passes.
struct EqualScans<'a> {
    evidence: &'a ScanEvidence<'a>,
    views: Vec<&'a ScanView>,
    pairs: Vec<(usize, usize)>,
}

impl<'a> EqualScans<'a> {
    fn new(evidence: &'a ScanEvidence<'a>) -> Self {
        let views: Vec<&ScanView> = evidence.of(Split::Calibration).collect();
        let pass = |view: &ScanView| &evidence.simulation.trials()[view.trial].trial.passes[view.pass];
        let follows = |&(a, b): &(usize, usize)| {
            let (first, next) = (views[a], views[b]);
            first.trial == next.trial && first.pass + 1 == next.pass && is_equal(pass(first), pass(next))
        };
        let pairs = (1..views.len()).map(|b| (b - 1, b)).filter(follows).collect();
        Self { evidence, views, pairs }
    }

    fn volumes(&self, model: &CompiledModel) -> Result<Volumes, EvidenceError> {
        let passes = self.evidence.simulate(model, Split::Calibration)?;
        let nuisances = self.evidence.nuisances_of((&passes, model))?;
        let volume = |view: &&ScanView| -> Result<[f64; 3], EvidenceError> {
            let Some(data) = view.data.as_heights() else { return Ok([f64::NAN; 3]) };
            let predicted = self.evidence.predicted(view, (&passes, model), nuisances)?;
            let (removed, left) = data.volumes(self.evidence.untouched(view).heights, &predicted);
            Ok([removed - left, data.volume_sigma(), removed])
        };
        self.views.iter().map(volume).collect()
    }

    /// Volume of one pass alone.
    fn own(&self, volumes: &Volumes, at: usize, which: usize) -> f64 {
        let is_first = at == 0 || self.views[at - 1].trial != self.views[at].trial;
        volumes[at][which] - if is_first { 0.0 } else { volumes[at - 1][which] }
    }

    /// Log ratio of the volume of a pass to that of the one before.
    fn change(&self, volumes: &Volumes, (a, b): (usize, usize), which: usize) -> f64 {
        (self.own(volumes, b, which) / self.own(volumes, a, which)).ln()
    }

    /// Standard deviation of the measured change.
    fn sigma(&self, volumes: &Volumes, (a, b): (usize, usize)) -> f64 {
        let (first, next) = (volumes[a][1], volumes[b][1].hypot(volumes[a][1]));
        (first / self.own(volumes, a, 0)).hypot(next / self.own(volumes, b, 0))
    }

    /// Mean simulated log ratio.
    fn mean(&self, volumes: &Volumes) -> f64 {
        self.pairs.iter().map(|&pair| self.change(volumes, pair, 2)).sum::<f64>() / self.pairs.len() as f64
    }
}

/// Returns true if two passes have the same settings.
fn is_equal(a: &Pass, b: &Pass) -> bool {
    let near = |a: f64, b: f64| (b / a).ln().abs() < SAME_SETTING;
    near(a.force_setpoint, b.force_setpoint) && near(a.feed, b.feed) && near(a.spindle_speed, b.spindle_speed)
}

/// Coordinates of the free parameters of the base laws.
fn law_coordinates(evidence: &dyn Evidence, model: &CompiledModel) -> Vec<Coordinate> {
    evidence.coordinates(model).into_iter().filter(|coordinate| coordinate.slot.is_law).collect()
}

/// Full grid of evenly spaced values over the parameters' ranges.
fn grid(coordinates: &[Coordinate]) -> Vec<Vec<f64>> {
    let mut grid = vec![Vec::new()];
    for coordinate in coordinates {
        let [low, high] = coordinate.listed();
        let value = |k: usize| low + (high - low) * k as f64 / (TREND_VALUES - 1) as f64;
        grid = grid
            .iter()
            .flat_map(|at: &Vec<f64>| (0..TREND_VALUES).map(|k| [at.as_slice(), &[value(k)]].concat()))
            .collect();
    }
    grid
}
