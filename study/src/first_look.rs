//! First answer of a study: its law fitted roughly, the misfit, and the most promising effects.

use super::measurements::Data;
use super::study_state::StudyState;
use super::{row_covariates, tile_covariates};
use lab::criteria::SIGNIFICANCE_LEVEL;
use lab::{CovariateStudy, ErrorUnit, FirstLook, Promise, Result, Simulated, Split};
use serde::{Deserialize, Serialize};

/// Expected least and greatest number of simulations of the calibration data in a study: a guess, not calibrated [1].
pub const EXPECTED_SIMULATIONS: [f64; 2] = [600.0, 3000.0];

/// The first answer.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct FirstAnswer {
    /// Root mean square residual of the roughly fitted law [unit of errors].
    pub rms: f64,
    /// The covariate that explains most of its error, and the share of the excess that it explains alone; absent if
    /// none is significant.
    pub depends_on: Option<(String, f64)>,
    /// The most promising effects; none of them is fitted or tested.
    pub promises: Vec<Promise>,
}

impl StudyState<'_> {
    /// Computes the first answer.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn first_answer(&mut self) -> Result<FirstAnswer> {
        let start = self.start()?;
        if let Data::Scans(_, evidence) = &mut self.data {
            evidence.limit_steps(&start)?;
        }
        let model = self.data.fitting(self.model.clone(), self.library)?;
        let FirstLook { law, rms, promises } = FirstLook::new(self.data.evidence(), &model, self.library)?;
        let seed = self.record.seed;
        let (study, named): (CovariateStudy, Box<dyn Fn(usize) -> String>) = match &self.data {
            Data::Scans(_, evidence) => {
                let simulated = Simulated::all(evidence, &[&law])?.remove(0);
                let study = tile_covariates::study(evidence, &simulated, Split::Calibration, seed);
                (study, Box::new(|at| tile_covariates::covariate(at).0))
            }
            Data::Rows(_, evidence) => {
                let study = row_covariates::study(evidence, &law, Split::Calibration, seed)?;
                (study, Box::new(|at| row_covariates::covariate(evidence, at).0))
            }
        };
        let real = study.covariates.iter().filter(|one| one.p_value_of_all <= SIGNIFICANCE_LEVEL);
        let most = real.max_by(|a, b| a.share.total_cmp(&b.share));
        Ok(FirstAnswer { rms, depends_on: most.map(|one| (named(one.covariate), one.share)), promises })
    }

    /// Simulates the calibration data once with the law before any fit, so that the caller can measure the time of a
    /// simulation.
    ///
    /// # Errors
    /// If the model cannot be simulated.
    pub fn simulate_once(&self) -> Result<()> {
        self.data.evidence().residuals(&self.start()?, Split::Calibration)?;
        Ok(())
    }
}

impl FirstAnswer {
    /// The answer in words.
    ///
    /// - `floor`: noise floor [unit of errors]
    pub fn words(&self, floor: f64, unit: ErrorUnit) -> String {
        let depends = self.depends_on.as_ref().map_or(
            "its error depends significantly on no covariate".to_owned(),
            |(name, share)| {
                format!(
                    "its error depends most on the {name}, which alone explains {:.0} % of the excess",
                    100.0 * share
                )
            },
        );
        let names: Vec<String> =
            self.promises.iter().map(|one| format!("{} ({:.0} %)", one.name, 100.0 * one.share)).collect();
        let suspects = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        format!(
            "the law, roughly fitted, leaves {}, noise alone {}; {depends}\nleading suspects, \
             by the share of χ² that each is predicted to explain; none is fitted yet: {suspects}",
            unit.shown(self.rms),
            unit.shown(floor)
        )
    }
}
