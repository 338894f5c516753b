//! The parameters of a model as one flat vector, as fits need it.

use super::accepted::Accepted;
use super::definition::{Effect, Parameter, Rows, Scale};
use super::model::{Model, ModelError};
use super::process::Process;
use super::unit::Unit;

/// Number of values of parameters that differ between passes or between scans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowCounts {
    /// Passes of the campaign.
    pub passes: usize,
    /// Scans of the campaign.
    pub scans: usize,
}

impl Default for RowCounts {
    fn default() -> Self {
        Self { passes: 1, scans: 1 }
    }
}

/// One entry of the parameter vector. Values are in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSlot {
    /// Law or effect.
    pub owner: String,
    /// Name of the parameter.
    pub parameter: String,
    /// One value, or one for each pass or each scan.
    pub per: Rows,
    /// Index of the pass or scan, from 0, if the value differs between them.
    pub row: Option<usize>,
    /// Unit in files and tables.
    pub unit: Unit,
    /// The unit as written.
    pub unit_text: String,
    /// Null value.
    pub null: Option<f64>,
    /// Plausible values: the library's range, or the model's.
    pub range: [f64; 2],
    /// True if the model states the range: no fit then leaves it.
    pub is_range_stated: bool,
    /// Scale on which it is varied.
    pub scale: Scale,
    /// Typical value.
    pub default: f64,
    /// True if the model lets fits vary it.
    pub free: bool,
    /// True if it belongs to a base law.
    pub is_law: bool,
}

impl ParameterSlot {
    /// `effect.parameter`, followed by `[2]` for the second pass or scan.
    pub fn name(&self) -> String {
        let row = self.row.map_or(String::new(), |row| format!("[{}]", row + 1));
        format!("{}.{}{row}", self.owner, self.parameter)
    }

    /// Values that it may take.
    pub fn accepted(&self) -> Accepted<'_> {
        let Self { range, null, default, unit, ref unit_text, .. } = *self;
        Accepted { range, null, default, unit, unit_text }
    }
}

/// Builder of the parameter vector.
pub(super) struct Slots<'a> {
    model: &'a Model,
    rows: RowCounts,
    pub(super) slots: Vec<ParameterSlot>,
    pub(super) values: Vec<f64>,
}

impl<'a> Slots<'a> {
    pub(super) fn new(model: &'a Model, rows: RowCounts) -> Self {
        Self { model, rows, slots: Vec::new(), values: Vec::new() }
    }

    /// Adds the parameters of a law or effect. Returns the index of the first row of each.
    pub(super) fn add(&mut self, effect: &Effect) -> Result<Vec<usize>, ModelError> {
        self.model.check_values(effect)?;
        Ok(effect.parameters.iter().map(|parameter| self.add_parameter(effect, parameter)).collect())
    }

    fn add_parameter(&mut self, effect: &Effect, parameter: &Parameter) -> usize {
        let first = self.slots.len();
        let process = self.model.process;
        let given = self.model.values(&effect.name, &parameter.name);
        let rows = match parameter.per {
            Rows::Model => 1,
            Rows::Pass => self.rows.passes.max(given.len()).max(1),
            Rows::Scan => self.rows.scans.max(given.len()).max(1),
        };
        let path = format!("{}.{}", effect.name, parameter.name);
        let stated = self.model.range_of(&path);
        for row in 0..rows {
            self.values.push(row_value(given, row, parameter, process));
            self.slots.push(ParameterSlot {
                owner: effect.name.clone(),
                parameter: parameter.name.clone(),
                per: parameter.per,
                row: (parameter.per != Rows::Model).then_some(row),
                unit: parameter.unit,
                unit_text: parameter.unit_text.clone(),
                null: parameter.null,
                range: stated.unwrap_or(parameter.range.of(process)),
                is_range_stated: stated.is_some(),
                scale: parameter.scale,
                default: parameter.default.of(process),
                free: self.model.is_free(&path, parameter.free.of(process)),
                is_law: effect.kind == super::definition::Kind::Law,
            });
        }
        first
    }
}

/// Value of a row. A single number applies to all rows; in a list each row has its own, and further rows are at null.
fn row_value(given: &[f64], row: usize, parameter: &Parameter, process: Process) -> f64 {
    let default = parameter.default.of(process);
    match given {
        [] => default,
        [one] => *one,
        list => list.get(row).copied().unwrap_or(parameter.null.unwrap_or(default)),
    }
}
