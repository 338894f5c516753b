//! Variables that the formulas of an effect read, and a check of whether rows of a table provide them.

use std::collections::BTreeSet;

use effects::{
    CompiledModel, Effect, Expr, Formula, Holder, Hook, Kind, Motion, Node, Op, Per, Reset, Rows, State, Variable,
};

use super::table_noise::is_timed;
use super::table_steps::{measuring, temperature};
use trials::table::{Removed, Table};

/// Hooks that rows support.
pub(super) const HOOKS: [Hook; 4] = [Hook::Spindle, Hook::Force, Hook::Rate, Hook::Dose];

/// Collector of the variables that a formula reads, through definitions and states.
struct Reads<'a> {
    table: &'a Table,
    effect: &'a Effect,
    /// Values of parameters that no fit varies.
    fixed: &'a dyn Fn(&str) -> Option<f64>,
    variables: BTreeSet<Variable>,
    seen: BTreeSet<String>,
    /// True in the formula of a state, where an unknown constant speed only changes the unit.
    in_state: bool,
}

impl Reads<'_> {
    /// Collects the names in a formula that can change its value. Terms that are divided by an infinite parameter or
    /// multiplied by zero are off.
    fn names<'e>(&self, tree: &'e Expr, names: &mut Vec<&'e str>) {
        let fixed = |tree: &Expr| match &tree.node {
            Node::Name(name) => (self.fixed)(name),
            _ => None,
        };
        match &tree.node {
            Node::Number(..) => {}
            Node::Name(name) => names.push(name),
            Node::Apply(Op::Div, parts) if fixed(&parts[1]).is_some_and(f64::is_infinite) => {}
            Node::Apply(Op::Mul, parts) if parts.iter().any(|part| fixed(part) == Some(0.0)) => {}
            Node::Apply(_, parts) => parts.iter().for_each(|part| self.names(part, names)),
        }
    }

    fn add(&mut self, formula: &Formula) {
        let effect = self.effect;
        let mut names = Vec::new();
        self.names(&formula.tree, &mut names);
        for name in names {
            if effect.parameter(name).is_some() || !self.seen.insert(name.to_owned()) {
                continue;
            }
            if let Some(definition) = effect.definitions.iter().find(|definition| definition.name == name) {
                self.add(&definition.formula);
            } else if let Some(state) = effect.states.iter().find(|state| state.name == name) {
                if measuring(self.table, &effect.name, state).is_some() {
                    continue;
                }
                self.in_state = true;
                match &state.motion {
                    Motion::Rate(rate) => self.add(rate),
                    Motion::Relax { target, time } => {
                        self.add(target);
                        self.add(time);
                    }
                }
                self.in_state = false;
            } else if !(self.in_state && name == Variable::SlidingSpeed.name() && has_no_speed(self.table)) {
                self.variables.extend(Variable::ALL.iter().find(|variable| variable.name() == name));
            }
        }
    }
}

fn has_no_speed(table: &Table) -> bool {
    table.rows.iter().all(|row| row.speed.is_none())
}

/// Checks that the formulas of an effect for rows read only variables that rows provide.
///
/// - `fixed`: values of parameters that no fit varies
pub(super) fn within_reach(table: &Table, effect: &Effect, fixed: &dyn Fn(&str) -> Option<f64>) -> Result<(), String> {
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
    let mut reads = Reads { table, effect, fixed, variables: BTreeSet::new(), seen: BTreeSet::new(), in_state: false };
    changes.iter().for_each(|change| reads.add(&change.formula));
    let variables = std::mem::take(&mut reads.variables);
    let states: Vec<_> = effect.states.iter().filter(|state| reads.seen.contains(&state.name)).collect();
    if states.iter().any(|state| state.per != Holder::Tool) {
        return Err("acts only across the surface: it remembers each place of tool or workpiece".to_owned());
    }
    let integrated: Vec<&State> =
        states.iter().filter(|state| measuring(table, &effect.name, state).is_none()).copied().collect();
    if !integrated.is_empty() && changes.iter().any(|change| change.hook == Hook::Force) {
        return Err("acts within a row: the logged force is a mean in which it is averaged out".to_owned());
    }
    integrated.iter().try_for_each(|state| integrates(table, state))?;
    variables.into_iter().try_for_each(|variable| gives(table, variable))
}

/// Checks that a table can integrate a state of the tool.
fn integrates(table: &Table, state: &State) -> Result<(), String> {
    if table.rows.iter().any(|row| row.duration.is_none()) {
        return Err(format!("remembers {}, which needs a duration", state.name));
    }
    let lasts = matches!(state.reset, Reset::FreshTool | Reset::Never);
    if lasts && !table.in_time && !table.rows.iter().all(|row| row.fresh) {
        return Err(format!("remembers {} from row to row, and their order is not that of time", state.name));
    }
    let reads_removal = match &state.motion {
        Motion::Rate(rate) => rate.tree.names().iter().any(|(name, _)| name.ends_with("removal_rate")),
        Motion::Relax { .. } => true,
    };
    if is_timed(table) && !reads_removal {
        return Err(format!("remembers {}, and the time is what was measured: every row removes the same", state.name));
    }
    Ok(())
}

/// Checks that a table provides a variable.
fn gives(table: &Table, variable: Variable) -> Result<(), String> {
    let has = |value: fn(&trials::table::Row) -> bool| table.rows.iter().all(value);
    let row = variable.row();
    let missing = |what: &str| Err(format!("reads {}, for which {what} is missing in the table", row.name));
    let given = match variable {
        Variable::Force | Variable::ForceSetpoint | Variable::ForceReading => has(|row| row.force.is_some()),
        Variable::ContactArea => table.area.is_some(),
        Variable::SlidingSpeed | Variable::SlipSpeed => has(|row| row.speed.is_some()),
        Variable::TrialTime if !table.in_time => {
            return Err("reads the time since the first row, and the order of the rows is not that of time".to_owned());
        }
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

/// Library values of the parameters of an effect that fits do not vary.
pub(super) fn held<'e>(effect: &'e Effect, process: effects::Process) -> impl Fn(&str) -> Option<f64> + 'e {
    move |name: &str| {
        let parameter = effect.parameter(name).filter(|parameter| !parameter.free.of(process))?;
        Some(parameter.default.of(process))
    }
}

/// A copy of a model in which effects that rows cannot show are at their null values.
pub(super) fn silenced(table: &Table, model: &CompiledModel) -> CompiledModel {
    let mut silent = model.clone();
    for effect in model.effects().filter(|effect| effect.kind == Kind::Effect) {
        let value = |name: &str| {
            let slot =
                model.parameters().iter().position(|slot| slot.owner == effect.name && slot.parameter == name)?;
            (!model.parameters()[slot].free).then(|| model.value(slot))
        };
        if within_reach(table, effect, &value).is_ok() {
            continue;
        }
        for (index, slot) in model.parameters().iter().enumerate().filter(|(_, slot)| slot.owner == effect.name) {
            silent.set(index, slot.null.unwrap_or(model.value(index)));
        }
    }
    silent
}
