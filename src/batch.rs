//! One trial simulated with many parameter sets: reads the table of sets, and writes a result line for each.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use effects::{CompiledModel, ParameterSlot};
use files::input::{self, MOST_TABLE_BYTES, quoted, quoted_near};
use serde::Serialize;

use crate::trial_run::residual;
use files::output::FolderKind;
use trial_simulation::{ModelRun, SimulatedPass};
use trials::trial::Trial;

/// Name of the result file: one line of JSON for each set, in the order of the table.
pub const BATCH_FILE: &str = "batch.jsonl";
/// Kind of the result folder.
pub const BATCH: FolderKind = FolderKind { marker: BATCH_FILE, key: "impulse_ns", names: &[] };
/// Name of the table's first column.
const NAME: &str = "name";

/// A parameter set.
pub struct BatchRun {
    /// Name in the table.
    pub name: String,
    /// Model with the values of the set.
    pub model: CompiledModel,
    /// Values of the table, in the parameters' own units.
    parameters: BTreeMap<String, f64>,
}

/// A line of the result file.
#[derive(Serialize)]
pub struct BatchLine {
    name: String,
    parameters: BTreeMap<String, f64>,
    /// Volume removed by Eq. (1) in each pass [mm³].
    removed_by_law_mm3: Vec<f64>,
    /// Volume of coating removed by Eq. (2) in each pass [mm³].
    coating_mm3: Vec<f64>,
    /// Exposed share of the scanned area after each pass; empty for grinding.
    exposed_share: Vec<f64>,
    /// Root mean square of force minus setpoint in contact [N].
    force_rms_error_n: Vec<f64>,
    /// Impulse ∫ F dt of each pass [N s].
    impulse_ns: Vec<f64>,
    /// Root mean square of measured minus simulated heights [µm]; empty for sanding.
    residual_rms_um: Vec<f64>,
    /// Number of steps in all passes.
    steps: usize,
    /// Reason why the run ended before its last pass; absent if it did not.
    #[serde(skip_serializing_if = "Option::is_none")]
    stopped: Option<String>,
}

/// Reads a table of parameter sets: the first column is their name, the others are parameters of `model` as
/// `effect.parameter` in their own units.
///
/// # Errors
/// The first fault, with file and line number.
pub fn read(file: &Path, model: &CompiledModel) -> Result<Vec<BatchRun>> {
    let at = |line: usize| format!("--batch {}:{line}", file.display());
    let bytes = input::read(file, MOST_TABLE_BYTES).context("--batch")?;
    let mut table = csv::Reader::from_reader(bytes.as_slice());
    let header = table.headers().with_context(|| at(1))?.clone();
    ensure!(
        header.get(0) == Some(NAME),
        "{}: the first column is {}, `name` is accepted",
        at(1),
        quoted(header.get(0).unwrap_or_default())
    );
    let shown = |column: &str| {
        let known: Vec<String> = model.parameters().iter().map(|slot| slot.name()).collect();
        quoted_near(column, known.iter().map(String::as_str))
    };
    let index = |column: &str| {
        let known = || model.parameters().iter().map(|slot| slot.name()).collect::<Vec<_>>().join(", ");
        model
            .index(column)
            .with_context(|| format!("{}: the model has no parameter {}; it has {}", at(1), shown(column), known()))
    };
    let columns: Vec<usize> = header.iter().skip(1).map(index).collect::<Result<_>>()?;
    let mut runs: Vec<BatchRun> = Vec::new();
    for (line, row) in (2..).zip(table.records()) {
        let row = row.with_context(|| at(line))?;
        let mut run = BatchRun { name: row[0].to_owned(), model: model.clone(), parameters: BTreeMap::new() };
        if run.name.is_empty() || runs.iter().any(|other| other.name == run.name) {
            bail!("{}: the name is {}, one that no other line has is accepted", at(line), quoted(&run.name));
        }
        for (&column, text) in columns.iter().zip(row.iter().skip(1)) {
            let slot = &model.parameters()[column];
            let value = value(slot, text).with_context(|| at(line))?;
            run.model.set(column, slot.unit.to_si(value));
            run.parameters.insert(slot.name(), value);
        }
        runs.push(run);
    }
    ensure!(!runs.is_empty(), "{}: no parameter set, one line for each is accepted", at(2));
    Ok(runs)
}

/// Reads a cell of the table, in the parameter's own unit.
fn value(slot: &ParameterSlot, text: &str) -> Result<f64> {
    let value: f64 =
        text.trim().parse().ok().filter(|value: &f64| !value.is_nan()).with_context(|| {
            format!("{} is {}, a number in {} is accepted", slot.name(), quoted(text), slot.unit_text)
        })?;
    slot.accepted().check(slot.unit.to_si(value)).with_context(|| slot.name())?;
    Ok(value)
}

impl BatchLine {
    /// Makes the result line of a parameter set.
    pub fn new(run: &BatchRun, trial: &Trial, ModelRun { passes, stopped }: &ModelRun) -> Self {
        let each = |figure: fn(&SimulatedPass) -> f64| passes.iter().map(figure).collect();
        Self {
            name: run.name.clone(),
            parameters: run.parameters.clone(),
            removed_by_law_mm3: each(|pass| pass.record.removed_volume * 1e9),
            coating_mm3: each(|pass| pass.record.coating_volume * 1e9),
            exposed_share: passes.iter().filter_map(|pass| pass.exposed_share).collect(),
            force_rms_error_n: each(|pass| pass.record.force_rms_error),
            impulse_ns: each(|pass| pass.record.impulse),
            residual_rms_um: (0..passes.len())
                .filter_map(|pass| residual(trial, &passes[pass], pass))
                .map(|r| r * 1e6)
                .collect(),
            steps: passes.iter().map(|pass| pass.record.steps).sum(),
            stopped: stopped.as_ref().map(ToString::to_string),
        }
    }
}
