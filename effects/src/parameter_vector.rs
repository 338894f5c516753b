//! The parameters of a model as one flat list of numbers, as fits need them.

use super::accepted::Accepted;
use super::definition::{Effect, Parameter, Process, Rows, Scale};
use super::model::{Model, ModelError};
use super::unit::Unit;

/// How many values parameters have that differ from pass to pass or from scan to scan.
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

/// One number of a model. Values are in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterSlot {
    /// Law or effect.
    pub owner: String,
    /// Parameter of it.
    pub parameter: String,
    /// Which pass or scan, from 0, if it differs between them.
    pub row: Option<usize>,
    /// Unit for people.
    pub unit: Unit,
    /// The unit as written.
    pub unit_text: String,
    /// Value at which the effect vanishes.
    pub null: Option<f64>,
    /// Plausible values: those that the library lists, or those that the model states.
    pub range: [f64; 2],
    /// Whether the model states its range: then no fit goes beyond it.
    pub is_range_stated: bool,
    /// How to vary it.
    pub scale: Scale,
    /// Typical value.
    pub default: f64,
    /// Whether the model lets fits vary it.
    pub free: bool,
    /// Whether it belongs to a base law.
    pub is_law: bool,
}

impl ParameterSlot {
    /// `effect.parameter`, with `[2]` after it for the second pass or scan.
    pub fn name(&self) -> String {
        let row = self.row.map_or(String::new(), |row| format!("[{}]", row + 1));
        format!("{}.{}{row}", self.owner, self.parameter)
    }

    /// The values that it may be given.
    pub fn accepted(&self) -> Accepted<'_> {
        let Self { range, null, default, unit, ref unit_text, .. } = *self;
        Accepted { range, null, default, unit, unit_text }
    }
}

/// Slots in the making.
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

    /// Adds the parameters of a law or effect. Returns the place of the first row of each.
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

/// One number stands for all rows; of a list, each row has its own, and rows beyond it are at null.
fn row_value(given: &[f64], row: usize, parameter: &Parameter, process: Process) -> f64 {
    let default = parameter.default.of(process);
    match given {
        [] => default,
        [one] => *one,
        list => list.get(row).copied().unwrap_or(parameter.null.unwrap_or(default)),
    }
}
