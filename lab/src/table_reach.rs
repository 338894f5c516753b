//! Which effects rows of a table can show, and why not the others.

use std::collections::BTreeSet;

use effects::{
    CompiledModel, Effect, Formula, Holder, Hook, Kind, Library, Model, Motion, Per, Process, RowCounts, Rows, Scale,
    Variable,
};

use super::coordinates::{Coordinate, moved};
use super::evidence::{EvidenceError, Split};
use super::rows::RowEvidence;
use super::table_steps::{NOMINAL_AREA, NOMINAL_COATING, NOMINAL_SPEED, ROOM, measuring, temperature};
use crate::criteria::{PREDICTION_CHANGE_LEAST, RATE_RANGE_FACTOR};
use trials::measure::median;
use trials::table::{Removed, Table};

/// Hooks that rows have.
const HOOKS: [Hook; 4] = [Hook::Spindle, Hook::Force, Hook::Rate, Hook::Dose];

/// What a formula reads, looked up through definitions and states.
struct Reads<'a> {
    table: &'a Table,
    effect: &'a Effect,
    variables: BTreeSet<Variable>,
    seen: BTreeSet<String>,
}

impl Reads<'_> {
    fn add(&mut self, formula: &Formula) {
        let effect = self.effect;
        for (name, _) in formula.tree.names() {
            if effect.parameter(name).is_some() || !self.seen.insert(name.to_owned()) {
                continue;
            }
            if let Some(definition) = effect.definitions.iter().find(|definition| definition.name == name) {
                self.add(&definition.formula);
            } else if let Some(state) = effect.states.iter().find(|state| state.name == name) {
                if measuring(self.table, &effect.name, state).is_some() {
                    continue;
                }
                match &state.motion {
                    Motion::Rate(rate) => self.add(rate),
                    Motion::Relax { target, time } => {
                        self.add(target);
                        self.add(time);
                    }
                }
            } else {
                self.variables.extend(Variable::ALL.iter().find(|variable| variable.name() == name));
            }
        }
    }
}

/// Whether the formulas of an effect that rows have read only what rows have.
fn within_reach(table: &Table, effect: &Effect) -> Result<(), String> {
    let changes: Vec<_> = effect.changes_in(table.process).filter(|change| HOOKS.contains(&change.hook)).collect();
    let Some(first) = effect.changes_in(table.process).next() else {
        return Err(format!("does nothing when {}", table.process.name()));
    };
    if changes.is_empty() {
        return Err(match first.hook {
            Hook::Height | Hook::Exposure => "acts only in a scan".to_owned(),
            Hook::Pressure => "acts only across the surface: the force sets the mean pressure".to_owned(),
            _ => "acts only across the surface".to_owned(),
        });
    }
    if effect.parameters.iter().any(|parameter| parameter.per != Rows::Model) {
        return Err("has a value for each pass: with one for each row nothing is left to compare".to_owned());
    }
    let mut reads = Reads { table, effect, variables: BTreeSet::new(), seen: BTreeSet::new() };
    changes.iter().for_each(|change| reads.add(&change.formula));
    let variables = std::mem::take(&mut reads.variables);
    let states: Vec<_> = effect.states.iter().filter(|state| reads.seen.contains(&state.name)).collect();
    if states.iter().any(|state| state.per != Holder::Tool) {
        return Err("acts only across the surface: it remembers each place of tool or workpiece".to_owned());
    }
    let integrated = states.iter().find(|state| measuring(table, &effect.name, state).is_none());
    if let Some(state) = integrated {
        if changes.iter().any(|change| change.hook == Hook::Force) {
            return Err("acts within a row: the logged force is a mean in which it is averaged out".to_owned());
        }
        if table.rows.iter().any(|row| row.duration.is_none()) {
            return Err(format!("remembers {}, which needs a duration", state.name));
        }
    }
    variables.into_iter().try_for_each(|variable| gives(table, variable))
}

/// Whether a table gives a variable.
fn gives(table: &Table, variable: Variable) -> Result<(), String> {
    let has = |value: fn(&trials::table::Row) -> bool| table.rows.iter().all(value);
    let row = variable.row();
    let missing = |what: &str| Err(format!("reads {}, for which {what} is missing in the table", row.name));
    let given = match variable {
        Variable::Force | Variable::ForceSetpoint | Variable::ForceReading => has(|row| row.force.is_some()),
        Variable::ContactArea => table.area.is_some(),
        Variable::SlidingSpeed | Variable::SlipSpeed => has(|row| row.speed.is_some()),
        Variable::SpindleSetpoint | Variable::SpindleSpeed | Variable::ToolRadius => {
            table.radius.is_some() && has(|row| row.speed.is_some())
        }
        Variable::TemperatureLogged => temperature(table).is_some(),
        Variable::RemovedDepth => table.area.is_some() || table.removed == Removed::Depth,
        Variable::Dose | Variable::CoatingRemoved => table.coating.is_some(),
        Variable::TrialTime | Variable::ContactTime => has(|row| row.duration.is_some()),
        Variable::Pressure
        | Variable::PressureMean
        | Variable::Rate
        | Variable::DoseRate
        | Variable::RemovalRate
        | Variable::DoseVolumeRate => true,
        Variable::Time => return Err("acts within a row: what swings with the clock is averaged out".to_owned()),
        _ if row.per != Per::Step => {
            return Err(format!("acts only across the surface: it reads {}, which differs over it", row.name));
        }
        _ => false,
    };
    match variable {
        _ if given => Ok(()),
        Variable::ContactArea | Variable::RemovedDepth => missing("area_mm2"),
        Variable::Dose | Variable::CoatingRemoved => missing("coating_mm"),
        Variable::ToolRadius | Variable::SpindleSpeed | Variable::SpindleSetpoint => missing("radius_mm or a speed"),
        _ => missing("a column"),
    }
}

/// A copy of a model with those effects at their null values that rows cannot show.
pub(super) fn silenced(table: &Table, model: &CompiledModel) -> CompiledModel {
    let mut silent = model.clone();
    for effect in model.effects().filter(|effect| effect.kind == Kind::Effect) {
        if within_reach(table, effect).is_ok() {
            continue;
        }
        for (index, slot) in model.parameters().iter().enumerate().filter(|(_, slot)| slot.owner == effect.name) {
            silent.set(index, slot.null.unwrap_or(model.value(index)));
        }
    }
    silent
}

impl RowEvidence<'_> {
    /// Whether an effect can be judged on this table.
    ///
    /// # Errors
    /// Why it cannot: it acts only across the surface, needs what no column gives, or moves all rows alike.
    pub fn acts(&self, effect: &Effect) -> Result<(), String> {
        within_reach(self.table, effect)?;
        let builtin = Library::builtin();
        let own = (builtin.find(&effect.name) != Some(effect))
            .then(|| builtin.with(&[(effect.file.clone(), effect.text.clone())]))
            .transpose();
        let own = own.map_err(|error| error.to_string())?;
        let library = own.as_ref().unwrap_or(builtin);
        let with = self.scaled(Model::new(self.table.process).with(&effect.name), library)?;
        let mut compiled = compile(&with, library)?;
        let typical = self.predicted(&compiled).map_err(|error| error.to_string())?;
        for (index, slot) in compiled.parameters().to_vec().iter().enumerate() {
            if slot.owner == effect.name {
                compiled.set(index, slot.null.unwrap_or(compiled.value(index)));
            }
        }
        let without = self.predicted(&compiled).map_err(|error| error.to_string())?;
        match self.shape(&without, &typical) {
            (change, _) if change < PREDICTION_CHANGE_LEAST => Err("changes nothing in these rows".to_owned()),
            (_, shape) if shape < PREDICTION_CHANGE_LEAST => {
                Err("moves all rows alike: it cannot be told from the rate constant".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// How far the logarithms of two predictions are apart in calibration rows: at most, and at most after each group's
    /// mean is taken off.
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

    /// The free parameters of a model that this table can tell from each other's absence, and a sentence for each of the
    /// others. Of those that move all rows alike only the first, the rate constant, is kept.
    ///
    /// # Errors
    /// A model that cannot be evaluated.
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

    /// A model with the rate constant, and its bounds, where the table's median row needs them, and with reference
    /// pressures and speeds at the medians of the rows. What the model itself states is left as it is.
    ///
    /// # Errors
    /// A model that the library does not know, or that cannot be evaluated.
    pub fn scaled(&self, mut model: Model, library: &Library) -> Result<Model, String> {
        for (name, middle) in [
            ("reference_pressure", self.median_of(|row| row.pressure.or(row.force.map(|force| force / NOMINAL_AREA)))),
            ("reference_speed", self.median_of(|row| Some(row.speed.unwrap_or(NOMINAL_SPEED)))),
        ] {
            for owner in model.effects.iter().map(|part| part.name.clone()).collect::<Vec<_>>() {
                let has = library.find(&owner).is_some_and(|effect| effect.parameter(name).is_some());
                if let Some(middle) = middle.filter(|_| has && model.values(&owner, name).is_empty()) {
                    model.set(&owner, name, &[middle]);
                }
            }
        }
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

    /// What the table leaves open, and what columns measure.
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
        if table.process == Process::Sanding && table.coating.is_none() {
            let thickness = 1e6 * NOMINAL_COATING;
            notes.push(format!(
                "no thickness of the coating is given: {thickness} um is assumed, and the rate constant is identified \
                 only times the thickness"
            ));
        }
        if table.process == Process::Sanding && table.rows.iter().any(|row| row.speed.is_none()) {
            notes.push(format!(
                "no speed is given: {NOMINAL_SPEED} m/s is assumed, and the rate constant is identified only times the \
                 speed"
            ));
        }
        if table.groups.len() > 1 {
            notes.push(format!("each of the {} groups has a gain of its own, free in every fit", table.groups.len()));
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

fn compile(model: &Model, library: &Library) -> Result<CompiledModel, String> {
    CompiledModel::new(model, library, RowCounts::default()).map_err(|error| error.to_string())
}
