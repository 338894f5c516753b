//! Misfit of a model in numbers: tests of structure, and dependence on covariates.

use effects::CompiledModel;
use lab::Result;
use serde::Serialize;

use super::{residual_tests, row_covariates, tile_covariates};
use crate::{Bin, CovariatePlot, DisplayUnit};
use lab::Simulated;
use lab::{CovariateBin, CovariateShare, CovariateStudy, Evidence, RowEvidence, ScanEvidence, Split, StructureTest};

/// A covariate in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct CovariateFigures {
    /// Its name.
    pub name: String,
    /// Share of the excess variance that a spline of it explains.
    pub share: f64,
    /// Fall of [`Failures::joint_share`] when this covariate is left out.
    pub drop: f64,
    /// P-value of the share where residuals do not depend on the covariate.
    pub p_value: f64,
    /// P-value that the largest share of any covariate reaches this one where none matters.
    pub p_value_of_all: f64,
}

/// Structure and covariates of a model's residual.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Failures {
    /// Tests of structure.
    pub tests: Vec<StructureTest>,
    /// Share of the excess variance that all covariates explain together.
    pub joint_share: f64,
    /// Covariates, in descending order of their shares.
    pub covariates: Vec<CovariateFigures>,
}

impl Failures {
    /// - `named`: name and unit of a covariate
    pub(super) fn new(
        tests: Vec<StructureTest>,
        study: &CovariateStudy,
        named: &dyn Fn(usize) -> (String, DisplayUnit),
    ) -> Self {
        let one = |share: &CovariateShare| CovariateFigures {
            name: named(share.covariate).0,
            share: share.share,
            drop: share.drop,
            p_value: share.p_value,
            p_value_of_all: share.p_value_of_all,
        };
        let mut covariates: Vec<CovariateFigures> = study.covariates.iter().map(one).collect();
        covariates.sort_by(|a, b| b.share.total_cmp(&a.share));
        Self { tests, joint_share: study.joint_share, covariates }
    }
}

/// Misfit of a base model on the calibration scans, in numbers and as plots that also show the residuals with effects.
///
/// - `degrees_of_freedom`: number of parameters of the base model that were fitted to them
pub(super) fn of_scans(
    evidence: &ScanEvidence,
    (base, last): (&Simulated, Option<&Simulated>),
    (degrees_of_freedom, seed): (usize, u64),
) -> (Failures, Vec<CovariatePlot>) {
    let study = |simulated| tile_covariates::study(evidence, simulated, Split::Calibration, seed);
    let (with_base, with_last) = (study(base), last.map(study));
    let tests = residual_tests::of_scans(evidence, base, Split::Calibration, (degrees_of_freedom, seed));
    let plots = plots(&with_base, with_last.as_ref(), &tile_covariates::covariate);
    (Failures::new(tests, &with_base, &tile_covariates::covariate), plots)
}

/// As [`of_scans`], for the calibration rows of a table.
///
/// # Errors
/// If a model cannot be evaluated.
pub(super) fn of_rows(
    evidence: &RowEvidence,
    (base, last): (&CompiledModel, Option<&CompiledModel>),
    (degrees_of_freedom, seed): (usize, u64),
) -> Result<(Failures, Vec<CovariatePlot>)> {
    let study = |model: &CompiledModel| row_covariates::study(evidence, model, Split::Calibration, seed);
    let (with_base, with_last) = (study(base)?, last.map(study).transpose()?);
    let declared = row_covariates::test_of_declared(evidence, &with_base);
    let residuals = evidence.residuals(base, Split::Calibration)?;
    let tests = residual_tests::of_rows(&residuals, declared, (degrees_of_freedom, seed));
    let named = |at: usize| row_covariates::covariate(evidence, at);
    let plots = plots(&with_base, with_last.as_ref(), &named);
    Ok((Failures::new(tests, &with_base, &named), plots))
}

/// Covariate plots of the report.
///
/// - `named`: name and unit of a covariate
pub(super) fn plots(
    base: &CovariateStudy,
    found: Option<&CovariateStudy>,
    named: &dyn Fn(usize) -> (String, DisplayUnit),
) -> Vec<CovariatePlot> {
    let bins = |share: &CovariateShare| -> Vec<Bin> {
        let bin = |bin: &CovariateBin| Bin { covariate: bin.covariate, residual: bin.residual, band: bin.band };
        share.bins.iter().map(bin).collect()
    };
    let plot = |share: &CovariateShare| {
        let (name, unit) = named(share.covariate);
        let same = found.and_then(|found| found.covariates.iter().find(|other| other.covariate == share.covariate));
        CovariatePlot {
            name,
            unit,
            bins: bins(share),
            with_effect: same.map(bins).unwrap_or_default(),
            share: share.share,
            drop: share.drop,
            p_value: share.p_value,
            p_value_of_all: share.p_value_of_all,
        }
    };
    base.covariates.iter().map(plot).collect()
}
