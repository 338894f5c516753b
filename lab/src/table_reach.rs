//! Effects that rows of a table can show, and reasons against the others.

use effects::{CompiledModel, Effect, Library, Model, RowCounts, Signal};

use super::coordinates::{Coordinate, moved};
use super::evidence::{EvidenceError, Split};
use super::rows::RowEvidence;
use super::table_reads::{held, within_reach};
use super::table_steps::{NOMINAL_AREA, NOMINAL_COATING, NOMINAL_SPEED, ROOM, measuring, temperature};
use crate::criteria::PREDICTION_CHANGE_LEAST;
use trials::table::Removed;

impl RowEvidence<'_> {
    /// Checks that an effect can be judged on this table.
    ///
    /// # Errors
    /// With the reason if it cannot: it acts only across the surface, needs a column that is missing, or changes all
    /// rows alike.
    pub fn acts(&self, effect: &Effect) -> Result<(), String> {
        within_reach(self.table, effect, &held(effect, self.table.process))?;
        let builtin = Library::builtin();
        let own = (builtin.find(&effect.name) != Some(effect))
            .then(|| builtin.with(&[(effect.file.clone(), effect.text.clone())]))
            .transpose();
        let own = own.map_err(|error| error.to_string())?;
        let [without, typical] = self.without_and_with(effect, own.as_ref().unwrap_or(builtin))?;
        match self.shape(&without, &typical) {
            (change, _) if change < PREDICTION_CHANGE_LEAST => Err("changes nothing in these rows".to_owned()),
            (_, shape) if shape < PREDICTION_CHANGE_LEAST => {
                Err("moves all rows alike: it cannot be distinguished from the rate constant".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Predictions without an effect and with its default values.
    fn without_and_with(&self, effect: &Effect, library: &Library) -> Result<[Vec<f64>; 2], String> {
        let with = self.scaled(Model::new(self.table.process).with(&effect.name), library)?;
        let mut compiled = compile(&with, library)?;
        let typical = self.predicted(&compiled).map_err(|error| error.to_string())?;
        for (index, slot) in compiled.parameters().to_vec().iter().enumerate() {
            if slot.owner == effect.name {
                compiled.set(index, slot.null.unwrap_or(compiled.value(index)));
            }
        }
        let without = self.predicted(&compiled).map_err(|error| error.to_string())?;
        Ok([without, typical])
    }

    /// Change of the log prediction of each calibration row by an effect with its default values, less each group's
    /// mean.
    ///
    /// # Errors
    /// If an effect cannot be evaluated.
    pub(super) fn response(&self, effect: &Effect, library: &Library) -> Result<Vec<f64>, String> {
        let [without, with] = self.without_and_with(effect, library)?;
        let rows = self.of(Split::Calibration);
        let log = |&at: &usize| if without[at] > 0.0 && with[at] > 0.0 { (with[at] / without[at]).ln() } else { 0.0 };
        let changes: Vec<f64> = rows.iter().map(log).collect();
        let group = |k: usize| self.table.rows[rows[k]].group;
        let mean = |of: usize| {
            let own: Vec<f64> = (0..rows.len()).filter(|&k| group(k) == of).map(|k| changes[k]).collect();
            own.iter().sum::<f64>() / own.len().max(1) as f64
        };
        let means: Vec<f64> = (0..self.table.groups.len()).map(mean).collect();
        Ok(changes.iter().enumerate().map(|(k, change)| change - means[group(k)]).collect())
    }

    /// Greatest difference of the logarithms of two predictions in calibration rows: as it is, and after each group's
    /// mean is subtracted.
    fn shape(&self, a: &[f64], b: &[f64]) -> (f64, f64) {
        let rows = self.of(Split::Calibration);
        let log = |at: &usize| if a[*at] > 0.0 && b[*at] > 0.0 { (b[*at] / a[*at]).ln() } else { 0.0 };
        let change = rows.iter().map(|at| log(at).abs()).fold(0.0, f64::max);
        let group = |group: usize| {
            let ratios = rows.iter().filter(|at| self.table.rows[**at].group == group).map(log);
            let (low, high) = ratios.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), r| (l.min(r), h.max(r)));
            (high - low).max(0.0)
        };
        (change, (0..self.table.groups.len()).map(group).fold(0.0, f64::max))
    }

    /// The free parameters of a model that change this table's predictions distinctly, and a sentence for each other
    /// one. Of those that change all rows alike only the first, the rate constant, is kept.
    ///
    /// # Errors
    /// If the model cannot be evaluated.
    pub fn coordinates(&self, model: &CompiledModel) -> Result<(Vec<Coordinate>, Vec<String>), EvidenceError> {
        let all = Coordinate::of(model, |_| true);
        let at: Vec<f64> = all.iter().map(|c| c.clamped(c.from_value(model.value(c.index)))).collect();
        let start = self.predicted(&moved(model, &all, &at))?;
        let (mut kept, mut notes, mut gained) = (Vec::new(), Vec::new(), false);
        for (k, coordinate) in all.iter().enumerate() {
            let mut there = at.clone();
            let forward = coordinate.clamped(at[k] + coordinate.step());
            there[k] = if forward > at[k] { forward } else { coordinate.clamped(at[k] - coordinate.step()) };
            let (change, shape) = self.shape(&start, &self.predicted(&moved(model, &all, &there))?);
            let name = coordinate.slot.name();
            if change < PREDICTION_CHANGE_LEAST {
                notes.push(format!("{name} changes nothing in these rows and is kept"));
            } else if shape < PREDICTION_CHANGE_LEAST && gained {
                notes.push(format!("{name} moves all rows alike, as the rate constant does, and is kept"));
            } else {
                gained |= shape < PREDICTION_CHANGE_LEAST;
                kept.push(coordinate.clone());
            }
        }
        Ok((kept, notes))
    }

    /// Sentences on values that the table omits, and on the quantities that columns measure.
    pub(super) fn assumptions(&self) -> Vec<String> {
        let table = self.table;
        let mut notes = Vec::new();
        let by_force = table.area.is_none() && table.rows.iter().any(|row| row.force.is_some());
        notes.extend(
            match (table.area, by_force, table.removed) {
                (Some(_), ..) => None,
                (None, true, Removed::Depth) => Some("the rate constant is identified only divided by the area"),
                (None, true, Removed::Volume) => Some("a threshold pressure is identified only times the area"),
                (None, false, Removed::Depth) => Some("volumes are identified only divided by the area"),
                (None, false, Removed::Volume) => Some("the rate constant is identified only times the area"),
            }
            .map(|what| format!("no area of contact is given: {} mm^2 is assumed, and {what}", 1e6 * NOMINAL_AREA)),
        );
        if table.process.signal() == Signal::Dose && table.coating.is_none() {
            let thickness = 1e6 * NOMINAL_COATING;
            notes.push(format!(
                "no thickness of the coating is given: {thickness} um is assumed, and the rate constant is identified \
                 only times the thickness"
            ));
        }
        if table.process.signal() == Signal::Dose && table.rows.iter().any(|row| row.speed.is_none()) {
            notes.push(format!(
                "no speed is given: {NOMINAL_SPEED} m/s is assumed, and the rate constant is identified only times the \
                 speed"
            ));
        }
        if table.groups.len() > 1 {
            notes.push(format!("each of the {} groups has its own gain, free in every fit", table.groups.len()));
        }
        notes.extend(self.measured_states());
        notes
    }

    fn measured_states(&self) -> Vec<String> {
        let effects = Library::builtin().effects().iter().filter(|effect| effect.acts_in(self.table.process));
        let states = effects.flat_map(|effect| effect.states.iter().map(move |state| (effect, state)));
        let measured = states.filter_map(|(effect, state)| {
            let usage = measuring(self.table, &effect.name, state)?;
            let name = &self.table.usage[usage].name;
            let zero = if temperature(self.table) == Some(usage) { format!(" less {ROOM} K") } else { String::new() };
            Some(format!("{}.{} is read from column {name:?}{zero}, not integrated", effect.name, state.name))
        });
        measured.collect()
    }
}

pub(super) fn compile(model: &Model, library: &Library) -> Result<CompiledModel, String> {
    CompiledModel::new(model, library, RowCounts::default()).map_err(|error| error.to_string())
}
