//! Residuals of a table's rows over covariates of each row.

use effects::CompiledModel;

use crate::DisplayUnit;
use lab::criteria::{GROSS_RESIDUAL_SIGMAS, ROW_BLOCK_LENGTH};
use lab::{
    CovariateField, CovariateStudy, Evidence, EvidenceError, RowEvidence, Split, StructureTest, covariate_study,
};
use trials::measure::centre_and_sigma;
use trials::table::Row;

/// A covariate of a row: name, unit, SI value of one unit, value.
type Known = (&'static str, &'static str, f64, fn(&Row) -> Option<f64>);
const COVARIATES: [Known; 5] = [
    ("force", "N", 1.0, |row| row.force),
    ("pressure", "MPa", 1e6, |row| row.pressure),
    ("sliding speed", "m/s", 1.0, |row| row.speed),
    ("duration", "s", 1.0, |row| row.duration),
    ("time since the first row", "h", 3600.0, |row| row.began),
];

/// Name and unit of a covariate: those above, the order of the rows, rows since the tool was fresh, states that columns
/// measure, and further columns.
pub fn covariate(evidence: &RowEvidence, at: usize) -> (String, DisplayUnit) {
    let table = evidence.table;
    let plain = |name: &str| (name.to_owned(), DisplayUnit::new("", 1.0));
    let rest = at.checked_sub(COVARIATES.len() + 2);
    match (COVARIATES.get(at), rest) {
        (Some((name, unit, si, _)), _) => ((*name).to_owned(), DisplayUnit::new(unit, *si)),
        (None, None) => plain(if at == COVARIATES.len() { "row" } else { "rows since the tool was fresh" }),
        (None, Some(rest)) => match table.usage.get(rest) {
            Some(usage) => {
                (usage.name.clone(), DisplayUnit::new(if usage.unit == "1" { "" } else { &usage.unit }, 1.0))
            }
            None => plain(&table.covariates[rest - table.usage.len()].name),
        },
    }
}

/// Studies the dependence of a split's residuals on the covariates of each row.
///
/// # Errors
/// If the model cannot be evaluated.
pub fn study(
    evidence: &RowEvidence,
    model: &CompiledModel,
    split: Split,
    seed: u64,
) -> Result<CovariateStudy, EvidenceError> {
    let table = evidence.table;
    let all: Vec<f64> = evidence.residuals(model, split)?.iter().map(|r| r * evidence.noise).collect();
    let (middle, spread) = centre_and_sigma(&all).unwrap_or_default();
    let counts = |(_, residual): &(&usize, &f64)| (*residual - middle).abs() <= GROSS_RESIDUAL_SIGMAS * spread;
    let (rows, residuals): (Vec<usize>, Vec<f64>) = evidence.of(split).iter().zip(&all).filter(counts).unzip();
    let known = |value: f64| if value.is_finite() { value } else { 0.0 };
    let of = |value: &dyn Fn(usize) -> f64| rows.iter().map(|&at| known(value(at))).collect::<Vec<f64>>();
    let since = since_fresh(&table.rows);
    let mut values: Vec<Vec<f64>> =
        COVARIATES.iter().map(|(_, _, _, value)| of(&|at| value(&table.rows[at]).unwrap_or(0.0))).collect();
    let in_time = |value: f64| if table.in_time { value } else { 0.0 };
    values.push(of(&|at| in_time(at as f64)));
    values.push(of(&|at| in_time(since[at])));
    let in_own_unit = |k: usize, at: usize| (table.rows[at].usage[k] - table.usage[k].scale.1) / table.usage[k].scale.0;
    values.extend((0..table.usage.len()).map(|k| of(&|at| in_own_unit(k, at))));
    values.extend(table.covariates.iter().map(|covariate| of(&|at| covariate.values[at])));
    let field = CovariateField {
        nx: rows.len(),
        cells: (0..rows.len()).collect(),
        residuals,
        sigmas: vec![evidence.noise; rows.len()],
        blocks: rows.iter().map(|at| at / ROW_BLOCK_LENGTH).collect(),
        values,
    };
    Ok(covariate_study(&[field], 1.0, seed))
}

/// Test of the dependence of residuals on declared columns: share and p-value of the covariate that explains most,
/// corrected for their number; `None` with too few rows.
pub fn test_of_declared(evidence: &RowEvidence, study: &CovariateStudy) -> Option<StructureTest> {
    let declared = COVARIATES.len() + 2 + evidence.table.usage.len();
    let own = study.covariates.iter().filter(|one| one.covariate < declared);
    let most = own.min_by(|a, b| a.p_value_of_all.total_cmp(&b.p_value_of_all).then(b.share.total_cmp(&a.share)))?;
    let name = "goes with a declared column".to_owned();
    Some(StructureTest { name, statistic: most.share, p_value: most.p_value_of_all, rejects: false })
}

/// Number of rows of a tool since it was fresh, before each row.
fn since_fresh(rows: &[Row]) -> Vec<f64> {
    let count = |at: usize| {
        let same = rows[..=at].iter().rev().filter(|row| row.tool == rows[at].tool);
        same.take_while(|row| !row.fresh).count().min(at) as f64
    };
    (0..rows.len()).map(count).collect()
}
