//! Columns of the logs and values of the trials as variables: each is a state of the tool that follows its column.

use effects::Unit;
use trials::trial::{Trial, TrialColumn};

use super::form_text::number;
use super::variables::{Scope, Variable};
use crate::scans::ScanEvidence;

/// Columns that all trials give in each row with the same dimension, and that vary.
pub(crate) fn columns(evidence: &ScanEvidence) -> Vec<Variable> {
    let trials: Vec<&Trial> = evidence.simulation.trials().iter().map(|simulation| simulation.trial).collect();
    let Some(first) = trials.first() else { return Vec::new() };
    first.columns.iter().filter_map(|column| variable(column, &trials)).collect()
}

/// Converts a column to a variable; `None` if a trial lacks it, or if it is constant.
fn variable(column: &TrialColumn, trials: &[&Trial]) -> Option<Variable> {
    let of = |trial: &&Trial| -> Option<Vec<[f64; 2]>> {
        let is_own = |own: &&TrialColumn| own.name == column.name && own.dimension == column.dimension;
        let own = trial.columns.iter().find(is_own).filter(|own| own.hole.is_none())?;
        Some(trial.passes.iter().map(|pass| ends(&own.values(&pass.log))).collect())
    };
    let passes: Vec<[f64; 2]> = trials.iter().map(of).collect::<Option<Vec<_>>>()?.concat();
    let least = passes.iter().map(|ends| ends[0]).fold(f64::INFINITY, f64::min);
    let greatest = passes.iter().map(|ends| ends[1]).fold(f64::NEG_INFINITY, f64::max);
    if least >= greatest {
        return None;
    }
    let moves = passes.iter().any(|[low, high]| low < high);
    // Formulas read a temperature in degrees Celsius as kelvin.
    let unit = if column.scale.1 == 0.0 { column.unit.as_str() } else { "K" };
    let si = Unit::parse(unit).ok()?.to_si(1.0);
    let name = &column.name;
    let state = format!(
        "[state.{name}]\nper = \"tool\"\nunit = \"{unit}\"\nrate = \"0\"\ninitial = {}\nreset = \"pass\"\n",
        number(0.5 * (least + greatest) / si)
    );
    Some(Variable {
        name: format!("column-{}", name.replace('_', "-")).into(),
        formula: name.clone().into(),
        state: state.into(),
        unit: unit.to_owned().into(),
        scope: if moves { Scope::Tool } else { Scope::Other },
        about: format!("column {name}").into(),
    })
}

/// Least and greatest known value.
fn ends(values: &[f64]) -> [f64; 2] {
    let known = values.iter().copied().filter(|value| value.is_finite());
    known.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}
