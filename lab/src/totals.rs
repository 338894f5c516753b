//! Total removal: the one figure to which the removal rate alone can be fitted.

use effects::CompiledModel;
use sdf_bake::HeightMap;

use super::evidence::{Evidence, EvidenceError, Split};
use super::exposure_view::ExposureView;
use super::height_view::HeightView;
use super::observation::Observation;
use super::rows::RowEvidence;
use super::scans::{ScanData, ScanEvidence, ScanView};
use trial_simulation::SimulatedPass;
use trials::measure::median;
use trials::trial::PassScan;

/// Total removal up to a scan, or by the rows of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Total {
    /// Display name of the data.
    pub about: String,
    /// Measured value: volume [m³], exposed area [m²], or for rows the geometric mean of the removal rates.
    pub measured: f64,
    /// Value that a model predicts; for rows, the measured one times the median ratio.
    pub predicted: f64,
    /// Standard deviation of the measured value.
    pub sigma: f64,
}

impl Total {
    /// Predicted minus measured, and its standard deviation, relative to the measured value.
    pub fn error(&self) -> (f64, f64) {
        ((self.predicted - self.measured) / self.measured, self.sigma / self.measured)
    }
}

/// Data with total removals, and with errors before registration.
pub trait Totals: Evidence {
    /// One total for each scan of a split, or one for a table.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError>;

    /// Root mean square of measured minus simulated before registration [m]; empty if there is nothing to register.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    fn unregistered(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError>;
}

impl Totals for ScanEvidence<'_> {
    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError> {
        let passes = self.simulate(model, split)?;
        let observation = self.observation_of((&passes, model))?;
        self.totals_of((&passes, model), split, observation)
    }

    fn unregistered(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let passes = self.simulate(model, split)?;
        let observation = self.observation_of((&passes, model))?;
        let rms = |view: &ScanView| match (&view.data, &passes[view.trial][view.pass].scan) {
            (ScanData::Heights(data), PassScan::Heights(simulated)) => {
                Some(data.raw_rms(&self.seen(view, simulated, observation)))
            }
            _ => None,
        };
        Ok(self.of(split).filter_map(rms).collect())
    }
}

impl ScanEvidence<'_> {
    /// As [`Totals::totals`], for passes that were simulated already.
    pub(super) fn totals_of(
        &self,
        (passes, model): (&[Vec<SimulatedPass>], &CompiledModel),
        split: Split,
        observation: Observation,
    ) -> Result<Vec<Total>, EvidenceError> {
        let total = |view: &ScanView| {
            let pass = &passes[view.trial][view.pass];
            let about = format!("{}, pass {}", self.simulation.trials[view.trial].trial.name, view.pass + 1);
            Ok(match (&view.data, &pass.scan) {
                (ScanData::Heights(data), PassScan::Heights(simulated)) => {
                    let before = &self.simulation.trials[view.trial].trial.scans.before;
                    Total { about, ..volume(data, &self.seen(view, simulated, observation), before) }
                }
                (ScanData::Exposure(data), _) => Total { about, ..bare_area(data, &margin(pass, model)?) },
                (ScanData::Heights(_), PassScan::Exposure(_)) => unreachable!("a simulated scan is like the real one"),
            })
        };
        self.of(split).map(total).collect()
    }
}

fn margin(pass: &SimulatedPass, model: &CompiledModel) -> Result<Vec<f64>, EvidenceError> {
    Ok(pass.surface.dose_margin(model)?.expect("a sanded surface has doses"))
}

/// Removed volume under all tiles.
fn volume(data: &HeightView, simulated: &HeightMap, before: &HeightMap) -> Total {
    let area = data.measured.pixels.pitch.powi(2);
    let left = data.left_held(simulated);
    let (mut predicted, mut missing) = (0.0, 0.0);
    for (_, at) in data.tiles.pixels().filter(|(_, at)| left[*at].is_finite() && before.heights[*at].is_finite()) {
        predicted += area * (before.heights[at] - simulated.heights[at]);
        missing += area * left[at];
    }
    Total { about: String::new(), measured: predicted - missing, predicted, sigma: data.volume_sigma() }
}

/// Exposed area over all tiles.
fn bare_area(data: &ExposureView, margin: &[f64]) -> Total {
    let pixel = data.measured.pixels.pitch.powi(2);
    let area =
        |is_bare: &dyn Fn(usize) -> bool| pixel * data.tiles.pixels().filter(|&(_, at)| is_bare(at)).count() as f64;
    let measured = area(&|at| data.measured.exposed[at] == Some(true));
    Total { about: String::new(), measured, predicted: area(&|at| margin[at] >= 0.0), sigma: data.area_sigma() }
}

impl Totals for RowEvidence<'_> {
    fn totals(&self, model: &CompiledModel, split: Split) -> Result<Vec<Total>, EvidenceError> {
        let predicted = self.predicted(model)?;
        let rows = self.of(split);
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        let rate = |at: usize| self.table.rows[at].removal_rate.expect("rows of a split have a removal");
        let mean = rows.iter().map(|&at| rate(at).ln()).sum::<f64>() / rows.len() as f64;
        // The median difference: grossly wrong rows do not count.
        let differences = rows.iter().map(|&at| (predicted[at].max(f64::MIN_POSITIVE) / rate(at)).ln()).collect();
        let measured = mean.exp();
        let predicted = measured * median(differences).unwrap_or(0.0).exp();
        let sigma = measured * self.noise / (rows.len() as f64).sqrt();
        Ok(vec![Total { about: self.table.name.clone(), measured, predicted, sigma }])
    }

    fn unregistered(&self, _: &CompiledModel, _: Split) -> Result<Vec<f64>, EvidenceError> {
        Ok(Vec::new())
    }
}
