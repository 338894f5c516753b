//! Comparison of a model with a campaign: only the scans' poses and the instrument's blur are fitted.

use std::path::Path;

use effects::CompiledModel;
use lab::Result;
use lab::criteria::{CriterionValues, NEAR_FLOOR_RATIO, SIGNIFICANCE_LEVEL};
use serde::Serialize;

use super::failures::{CovariateFigures, Failures, plots};
use super::maps::Seen;
use super::provenance::provenance;
use super::report_from_diagnosis::{compared_scans, folder_name};
use super::scan_figures::{ScanFigures, figures};
use super::track::deepest;
use super::waterfall::{Scans, Step};
use super::{residual_tests, row_covariates, tile_covariates};
use crate::{Compared, Conclusion, Direction, DisplayUnit, Misfit, StudyReport, Waterfall, WaterfallStep};
use lab::Simulated;
use lab::{
    CovariateStudy, ErrorUnit, Evidence, NoiseSummary, ParameterState, ParameterSummary, PassTrend, RowEvidence,
    ScanEvidence, Split, StructureTest, robust_sum,
};
use trials::trial::{Campaign, Finding};

/// Result of a comparison.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// True if the model leaves only noise.
    pub agrees: bool,
    /// Result in one sentence.
    pub sentence: String,
    /// Notes on ambiguous input files and how they were interpreted, one sentence each.
    pub notes: Vec<String>,
    /// Findings of the consistency checks between scans and logs; empty for a table.
    pub findings: Vec<Finding>,
    /// Unit of the errors: metres for scans, shares of the removal for tables.
    pub error_unit: ErrorUnit,
    /// Root mean square residual of the model.
    pub rms: f64,
    /// Noise floor of the residual.
    pub noise_floor: f64,
    /// Standard deviation of the instrument's blur [µm]; absent for tables.
    pub blur_um: Option<f64>,
    /// Noise of the scans by trial, from repeated scans; empty for a table.
    pub noise: Vec<NoiseSummary>,
    /// Passes that tests and covariates use.
    pub judged: &'static str,
    /// Trend of equal passes, and the changes that the model's law can produce; absent if there are no equal passes.
    pub equal_passes: Option<PassTrend>,
    /// Structure and covariates of the residual.
    #[serde(flatten)]
    pub failures: Failures,
    /// Figures of each scan; empty for a table.
    pub scans: Vec<ScanFigures>,
    /// Lines of the table whose residuals are gross outliers.
    pub outlier_lines: Vec<u64>,
    /// Values of all decision criteria, by name.
    pub criteria: CriterionValues,
}

/// Options of a comparison.
pub struct Asked<'a> {
    /// Folder of the campaign.
    pub folder: &'a Path,
    /// Requested sections; if empty, the report shows a default choice.
    pub lines: &'a [Direction],
    /// Seed of all draws.
    pub seed: u64,
}

/// Compares a model with the scans of a campaign.
///
/// # Errors
/// If the model cannot be simulated, or an input file cannot be read again for its hash.
pub fn compare_scans(
    (campaign, evidence): (&Campaign, &ScanEvidence),
    model: &CompiledModel,
    asked: &Asked,
) -> Result<(Comparison, StudyReport)> {
    let simulated = Simulated::all(evidence, &[model])?.remove(0);
    let split = if evidence.of(Split::Calibration).next().is_some() { Split::Calibration } else { Split::Evaluation };
    let tests = residual_tests::of_scans(evidence, &simulated, split, (0, asked.seed));
    let study = tile_covariates::study(evidence, &simulated, split, asked.seed);
    let scans = Scans::new(evidence, false);
    let waterfall = scans.waterfall(&simulated, &[Step { name: "model".to_owned(), simulated: &simulated }]);
    let seen = Seen { evidence, base: &simulated, found: None, lines: asked.lines };
    let figures: Vec<ScanFigures> =
        evidence.views.iter().map(|view| figures(evidence, view, &simulated, asked.lines)).collect();
    let judged = || evidence.views.iter().zip(&figures).filter(|(view, _)| view.split == split).map(|(_, f)| f);
    let rms = |of: fn(&ScanFigures) -> f64| {
        (judged().map(|f| of(f).powi(2)).sum::<f64>() / judged().count().max(1) as f64).sqrt()
    };
    let error = [rms(|figures| 1e-6 * figures.rms_um), rms(|figures| 1e-6 * figures.noise_floor_um)];
    let equal_passes = evidence.trend(model)?;
    let notes = campaign.notes().into_iter().chain(evidence.noise_notes()).collect();
    let removal = deepest(evidence, &simulated, split);
    let found = Found { equal_passes, tests, study, named: &tile_covariates::covariate, error, notes, removal };
    let blur = Some(simulated.nuisances.blur * 1e6);
    let comparison = Comparison {
        blur_um: blur,
        noise: NoiseSummary::all(evidence),
        scans: figures,
        findings: campaign.findings(),
        ..found.comparison(evidence.unit(), split)
    };
    let alignments: Vec<_> = evidence.views.iter().map(|view| scans.alignment(view)).collect();
    let named = found.compared(model, asked.folder);
    let compared = compared_scans(campaign, evidence, &alignments, named);
    let compared = Compared { blur: Some(simulated.nuisances.blur).filter(|blur| *blur > 0.0), ..compared };
    let report = StudyReport {
        waterfall,
        volumes: seen.volumes(),
        scans: seen.scans(),
        sections: seen.sections(),
        ..found.report(&comparison, compared, (model, asked))?
    };
    Ok((comparison, report))
}

/// Compares a model with the rows of a table.
///
/// # Errors
/// If the model cannot be evaluated, or an input file cannot be read again for its hash.
pub fn compare_rows(evidence: &RowEvidence, model: &CompiledModel, asked: &Asked) -> Result<(Comparison, StudyReport)> {
    let split = Split::Calibration;
    let residuals = evidence.residuals(model, split)?;
    let study = row_covariates::study(evidence, model, split, asked.seed)?;
    let declared = row_covariates::test_of_declared(evidence, &study);
    let tests = residual_tests::of_rows(&residuals, declared, (0, asked.seed));
    let rms = |residuals: &[f64]| evidence.noise * (robust_sum(residuals) / residuals.len().max(1) as f64).sqrt();
    let named = |at: usize| row_covariates::covariate(evidence, at);
    let equal_passes = evidence.trend(model)?;
    let error = [rms(&residuals), evidence.noise];
    let notes = evidence.table.notes.iter().chain(&evidence.notes).cloned().collect();
    let found = Found { equal_passes, tests, study, named: &named, error, notes, removal: 1.0 };
    let outlier_lines = evidence.outliers(&residuals, split).iter().map(|row| row.line).collect();
    let comparison = Comparison { outlier_lines, ..found.comparison(evidence.unit(), split) };
    let held_out = evidence.residuals(model, Split::Evaluation)?;
    let step = |name: &str, calibration: f64, evaluation: f64| WaterfallStep {
        name: name.to_owned(),
        calibration: Some(calibration),
        evaluation: (!held_out.is_empty()).then_some(evaluation),
        ..WaterfallStep::default()
    };
    let steps =
        vec![step("model", rms(&residuals), rms(&held_out)), step("noise floor", evidence.noise, evidence.noise)];
    let compared = found.compared(model, asked.folder);
    let report = StudyReport {
        waterfall: Waterfall { misfit: Misfit::of(evidence.unit()), passes: Vec::new(), steps, notes: Vec::new() },
        ..found.report(&comparison, compared, (model, asked))?
    };
    Ok((comparison, report))
}

/// Results of tests and covariates, for scans and tables alike.
struct Found<'a> {
    equal_passes: Option<PassTrend>,
    tests: Vec<StructureTest>,
    study: CovariateStudy,
    named: &'a dyn Fn(usize) -> (String, DisplayUnit),
    /// Root mean square residual and noise floor [unit of errors].
    error: [f64; 2],
    /// Notes on how the input files were interpreted.
    notes: Vec<String>,
    /// Mean removal [unit of errors]; infinite if it cannot be expressed in it.
    removal: f64,
}

impl Found<'_> {
    /// Names of the compared campaign and model, for scans and tables alike.
    fn compared(&self, model: &CompiledModel, folder: &Path) -> Compared {
        let (campaign, model) = (folder_name(folder), model_words(model));
        Compared { campaign, model, notes: self.notes.clone(), ..Compared::default() }
    }

    fn comparison(&self, unit: ErrorUnit, split: Split) -> Comparison {
        let [rms, floor] = self.error;
        let failures = Failures::new(self.tests.clone(), &self.study, self.named);
        // Holm's rule with the covariates as one more test. If no test rejects, the covariates have the strictest
        // level.
        let level = SIGNIFICANCE_LEVEL / (self.tests.len() + 1) as f64;
        let depends = failures.covariates.iter().any(|covariate| covariate.p_value_of_all <= level);
        let hidden = floor >= self.removal;
        let agrees = !self.tests.iter().any(|test| test.rejects) && !depends && !hidden;
        let errors = format!("{} where noise alone leaves {}", unit.shown(rms), unit.shown(floor));
        let beyond = self.equal_passes.as_ref().filter(|trend| trend.out_of_reach);
        let beyond = beyond.map_or(String::new(), |trend| format!(" {}", trend.sentence()));
        let is_near = !agrees && rms <= NEAR_FLOOR_RATIO * floor;
        let near = if is_near { " The error is near the noise, but what is left has structure." } else { "" };
        let is_significant = |covariate: &&CovariateFigures| covariate.p_value_of_all <= SIGNIFICANCE_LEVEL;
        let removal = unit.shown(self.removal);
        let sentence = match (agrees, failures.covariates.iter().find(is_significant)) {
            _ if hidden => format!(
                "The model leaves {errors}, and all that was removed is {removal}: noise hides it, and nothing can be said. Is [scan] \
                 repeat another scan of the same surface?"
            ),
            (true, _) => format!("The model leaves {errors}: no structure beyond noise."),
            (false, Some(most)) => format!(
                "The model leaves {errors}; its error depends most on the {}, which alone explains {:.0} % of the excess.",
                most.name,
                100.0 * most.share
            ),
            (false, None) => format!("The model leaves {errors}; no single covariate explains it."),
        };
        Comparison {
            agrees,
            sentence: sentence + near + &beyond,
            notes: self.notes.clone(),
            findings: Vec::new(),
            error_unit: unit,
            rms,
            noise_floor: floor,
            blur_um: None,
            noise: Vec::new(),
            judged: if split == Split::Calibration { "calibration" } else { "evaluation" },
            equal_passes: self.equal_passes.clone(),
            failures,
            scans: Vec::new(),
            outlier_lines: Vec::new(),
            criteria: CriterionValues,
        }
    }

    /// Fills the parts of the report that scans and tables have in common.
    fn report(
        &self,
        comparison: &Comparison,
        compared: Compared,
        (model, asked): (&CompiledModel, &Asked),
    ) -> Result<StudyReport> {
        Ok(StudyReport {
            compared,
            conclusion: if comparison.agrees { Conclusion::Agrees } else { Conclusion::Differs },
            sentence: comparison.sentence.clone(),
            tests: self.tests.clone(),
            waterfall: Waterfall {
                misfit: Misfit::heights(),
                passes: Vec::new(),
                steps: Vec::new(),
                notes: Vec::new(),
            },
            volumes: Vec::new(),
            scans: Vec::new(),
            sections: Vec::new(),
            covariates: plots(&self.study, None, self.named),
            tiles: Vec::new(),
            suspects: Vec::new(),
            unfitted: Vec::new(),
            parameters: parameters(model),
            correlations: Vec::new(),
            detectable: Vec::new(),
            next_trial: None,
            proposal: None,
            provenance: provenance(asked.folder, asked.seed)?,
            diagnosis: serde_json::to_value(comparison)?,
        })
    }
}

/// Names of the laws and effects of a model.
fn model_words(model: &CompiledModel) -> String {
    model.effects().map(|effect| effect.name.as_str()).collect::<Vec<_>>().join(", ")
}

/// Values of the model's parameters; none was fitted.
fn parameters(model: &CompiledModel) -> Vec<ParameterSummary> {
    let one = |(slot, value): (&effects::ParameterSlot, &f64)| ParameterSummary {
        name: slot.name(),
        unit: slot.unit_text.clone(),
        value: slot.unit.from_si(*value),
        interval: None,
        state: ParameterState::Fixed,
        listed_to: None,
    };
    model.parameters().iter().zip(model.values()).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use lab::CovariateShare;

    /// Comparison with one test, and with the error as a multiple of the noise floor.
    fn found(rejects: bool, floors: f64) -> Comparison {
        let test = StructureTest { name: "runs".to_owned(), statistic: -9.0, p_value: 0.001, rejects };
        let found = Found {
            equal_passes: None,
            tests: vec![test],
            study: CovariateStudy::default(),
            named: &|_| unreachable!("there is no covariate"),
            error: [floors, 1.0],
            notes: Vec::new(),
            removal: 10.0,
        };
        found.comparison(ErrorUnit::Metre, Split::Calibration)
    }

    /// Comparison without a test that rejects, with a covariate of this p-value and with this removal.
    fn explained(p_value: f64, removal: f64) -> Comparison {
        let share =
            CovariateShare { covariate: 0, share: 0.5, drop: 0.5, p_value, p_value_of_all: p_value, bins: vec![] };
        let found = Found {
            equal_passes: None,
            tests: Vec::new(),
            study: CovariateStudy { joint_share: 0.5, covariates: vec![share] },
            named: &|_| ("force".to_owned(), DisplayUnit::new("N", 1.0)),
            error: [1.0, 1.0],
            notes: Vec::new(),
            removal,
        };
        found.comparison(ErrorUnit::Metre, Split::Calibration)
    }

    #[test]
    fn a_covariate_that_explains_or_noise_that_hides_never_agrees() {
        assert!(explained(0.5, 10.0).agrees && !explained(0.002, 10.0).agrees);
        let hidden = explained(0.5, 0.9);
        assert!(!hidden.agrees && hidden.sentence.contains("noise hides it"), "{}", hidden.sentence);
    }

    #[test]
    fn a_model_whose_tests_find_structure_never_agrees() {
        for floors in [0.2, 1.05, 3.0] {
            assert!(!found(true, floors).agrees && found(false, floors).agrees);
            assert_eq!(found(true, floors).sentence.contains("what is left has structure"), floors < 1.1);
        }
    }
}
