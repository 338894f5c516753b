//! Total removal: the one figure to which the removal rate alone can be fitted.

use effects::CompiledModel;

use super::evidence::{Evidence, EvidenceError, Split};
use super::nuisances::Nuisances;
use super::rows::RowEvidence;
use super::scans::{ScanEvidence, ScanView};
use trial_simulation::SimulatedPass;
use trials::measure::median;

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
        let nuisances = self.nuisances_of((&passes, model))?;
        self.totals_of((&passes, model), split, nuisances)
    }

    fn unregistered(&self, model: &CompiledModel, split: Split) -> Result<Vec<f64>, EvidenceError> {
        let passes = self.simulate(model, split)?;
        let nuisances = self.nuisances_of((&passes, model))?;
        let rms = |view: &ScanView| {
            let predicted = self.predicted(view, (&passes, model), nuisances);
            predicted.map(|predicted| view.data.raw_rms(&predicted)).transpose()
        };
        self.of(split).filter_map(rms).collect()
    }
}

impl ScanEvidence<'_> {
    /// As [`Totals::totals`], for passes that were simulated already.
    pub(super) fn totals_of(
        &self,
        (passes, model): (&[Vec<SimulatedPass>], &CompiledModel),
        split: Split,
        nuisances: Nuisances,
    ) -> Result<Vec<Total>, EvidenceError> {
        let total = |view: &ScanView| {
            let about = format!("{}, pass {}", self.simulation.trials()[view.trial].trial.name, view.pass + 1);
            let predicted = self.predicted(view, (passes, model), nuisances)?;
            Ok(Total { about, ..view.data.total(&predicted, self.untouched(view).heights) })
        };
        self.of(split).map(total).collect()
    }
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
