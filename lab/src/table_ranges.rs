//! Adaptation of a model to a table: rate constant, reference values, and bounds of the scales with which effects
//! compare a tool's use.

use effects::{Dimension, Effect, Holder, Library, Model, Scale};

use super::evidence::Split;
use super::rows::RowEvidence;
use super::table_reach::compile;
use super::table_reads::HOOKS;
use super::table_steps::{NOMINAL_AREA, NOMINAL_SPEED};
use crate::criteria::{RATE_RANGE_FACTOR, SPAN_RANGE_FACTOR};
use trials::measure::median;
use trials::table::{Removed, Row};

const LENGTH: Dimension = Dimension::whole([0, 1, 0, 0]);
const VOLUME: Dimension = Dimension::whole([0, 3, 0, 0]);
const TIME: Dimension = Dimension::whole([0, 0, 1, 0]);

impl RowEvidence<'_> {
    /// Returns a model with its rate constant and the bounds of that matched to the table's median row, and with the
    /// medians of the rows as reference values. Values that the model itself states are kept.
    ///
    /// # Errors
    /// If the library does not know the model, or it cannot be evaluated.
    pub fn scaled(&self, mut model: Model, library: &Library) -> Result<Model, String> {
        self.set_references(&mut model, library);
        self.widen_ranges(&mut model, library);
        let laws = model.resolve_laws(library).map_err(|error| error.to_string())?;
        let gives_rate = |law: &&&Effect| law.changes_in(model.process).any(|change| HOOKS.contains(&change.hook));
        let Some((owner, constant)) = laws.iter().find(gives_rate).and_then(|law| {
            law.parameters.iter().find(|parameter| parameter.scale == Scale::Log).map(|p| (law.name.clone(), p.clone()))
        }) else {
            return Ok(model);
        };
        let path = format!("{owner}.{}", constant.name);
        if model.values(&owner, &constant.name).is_empty() {
            let compiled = compile(&Model { effects: Vec::new(), ..model.clone() }, library)?;
            let predicted = self.predicted(&compiled).map_err(|error| error.to_string())?;
            let ratios = self.of(Split::Calibration).iter().filter_map(|&at| {
                self.table.rows[at].removal_rate.filter(|_| predicted[at] > 0.0).map(|rate| rate / predicted[at])
            });
            let ratio = median(ratios.collect()).unwrap_or(1.0);
            model.set(&owner, &constant.name, &[ratio * constant.default.of(model.process)]);
        }
        if model.range_of(&path).is_none() {
            let value = model.values(&owner, &constant.name)[0];
            model.ranges.push((path, [value / RATE_RANGE_FACTOR, value * RATE_RANGE_FACTOR]));
        }
        Ok(model)
    }

    fn median_of(&self, value: impl Fn(&trials::table::Row) -> Option<f64>) -> Option<f64> {
        median(self.table.rows.iter().filter_map(value).collect())
    }

    /// Sets the reference values of effects to the medians of the rows.
    fn set_references(&self, model: &mut Model, library: &Library) {
        for (name, middle) in [
            ("reference_pressure", self.median_of(|row| row.pressure.or(row.force.map(|force| force / NOMINAL_AREA)))),
            ("reference_speed", self.median_of(|row| Some(row.speed.unwrap_or(NOMINAL_SPEED)))),
            ("reference_distance", self.median_of(|row| Some(row.speed.unwrap_or(NOMINAL_SPEED) * row.duration?))),
        ] {
            for owner in model.effects.iter().map(|part| part.name.clone()).collect::<Vec<_>>() {
                let has = library.find(&owner).is_some_and(|effect| effect.parameter(name).is_some());
                if let Some(middle) = middle.filter(|_| has && model.values(&owner, name).is_empty()) {
                    model.set(&owner, name, &[middle]);
                }
            }
        }
    }

    /// Widens the ranges of volumes, distances and times with which an effect compares the use of a tool. Use far below
    /// or above them has no visible effect, so the table's own use sets the ranges.
    fn widen_ranges(&self, model: &mut Model, library: &Library) {
        let owners: Vec<&Effect> = model.effects.iter().filter_map(|part| library.find(&part.name)).collect();
        for effect in owners {
            let states = || effect.states.iter().filter(|state| state.per == Holder::Tool);
            for parameter in effect.parameters.iter().filter(|parameter| parameter.scale == Scale::Log) {
                let path = format!("{}.{}", effect.name, parameter.name);
                let dimension = parameter.unit.dimension;
                if model.range_of(&path).is_some() || !states().any(|state| state.unit.dimension == dimension) {
                    continue;
                }
                let Some(span) = self.span(dimension).filter(|span| *span > 0.0) else { continue };
                let [least, greatest] = parameter.range.of(model.process);
                let range = [least.min(span / SPAN_RANGE_FACTOR), greatest.max(span * SPAN_RANGE_FACTOR)];
                if range != [least, greatest] {
                    model.ranges.push((path, range));
                }
            }
        }
    }

    /// Greatest volume [m³], distance [m] or time [s] of a tool's use since it was fresh; of one row if the rows are
    /// not in order of time.
    fn span(&self, dimension: Dimension) -> Option<f64> {
        let table = self.table;
        let area = table.area.unwrap_or(NOMINAL_AREA);
        let own = |row: &Row| -> Option<f64> {
            let duration = row.duration?;
            Some(match dimension {
                LENGTH => row.speed.unwrap_or(NOMINAL_SPEED) * duration,
                TIME => duration,
                VOLUME if table.removed == Removed::Depth => row.removal_rate? * area * duration,
                VOLUME => row.removal_rate? * duration,
                _ => return None,
            })
        };
        let mut used = vec![0.0; table.tools.len()];
        let each = table.rows.iter().filter(|row| row.role == trials::trial::Role::Calibration).filter_map(|row| {
            let before = if row.fresh || !table.in_time { 0.0 } else { used[row.tool] };
            used[row.tool] = before + own(row)?;
            Some(used[row.tool])
        });
        each.max_by(f64::total_cmp)
    }
}
