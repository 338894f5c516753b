//! Measured quantities along a trial's passes for formulas, and the reasons why states of a model lack theirs.

use effects::{CompiledModel, Effect, State};
use sim::Measured;
use trials::trial::{Pass, Place, TRIAL_FILE, Trial, TrialColumn, TrialError};

/// All quantities of a trial that have a value along one of its passes.
pub(super) fn measured(trial: &Trial, pass: &Pass) -> Vec<Measured> {
    let rows = &pass.log.rows;
    let start = rows.first().map_or(0.0, |row| row.time);
    let along = |column: &TrialColumn| {
        let values = column.values(&pass.log);
        let times = if values.len() == 1 { vec![0.0] } else { rows.iter().map(|row| row.time - start).collect() };
        let known = times.into_iter().zip(values).filter(|(_, value)| value.is_finite());
        let (times, values) = known.unzip();
        Measured { name: column.name.clone(), dimension: column.dimension, times, values }
    };
    trial.columns.iter().map(along).filter(|measured| !measured.values.is_empty()).collect()
}

/// The first state of an effect that needs a measured column which the trial lacks, with the reason.
pub fn lacking<'e>(trial: &Trial, effect: &'e Effect) -> Option<(&'e State, TrialError)> {
    let held = effect.states.iter().filter(|state| state.is_held());
    held.filter_map(|state| Some((state, unread(trial, effect, state)?))).next()
}

/// Checks that a trial has all columns that a model's states read.
///
/// # Errors
/// [`TrialError`] with the place, the value found and the values accepted.
pub(super) fn check(trial: &Trial, model: &CompiledModel) -> Result<(), Box<TrialError>> {
    model.effects().find_map(|effect| lacking(trial, effect)).map_or(Ok(()), |(_, error)| Err(Box::new(error)))
}

/// Reason why a state cannot be read from a trial.
fn unread(trial: &Trial, effect: &Effect, state: &State) -> Option<TrialError> {
    let (name, reader) = (&state.name, format!("{}.{}", effect.name, state.name));
    let Some(column) = trial.columns.iter().find(|column| column.name == *name) else {
        let names: Vec<&str> = trial.columns.iter().map(|column| column.name.as_str()).collect();
        let known =
            if names.is_empty() { "there is none".to_owned() } else { format!("there are {}", names.join(", ")) };
        let found = format!("no column {name}, which {reader} reads; {known}");
        let accepted = format!("{name} in every log, or {name} = \"1 {}\" in [columns], is expected", state.unit_text);
        return Some(Place::file(&trial.folder.join(TRIAL_FILE)).bad(found, accepted));
    };
    if column.dimension != state.unit.dimension {
        let found = format!("column {name} is in {}, of dimension [{}]", column.unit, column.dimension);
        let accepted = format!(
            "a unit such as {} is expected, as {reader} has it: {name} = \"...\" in [columns] of {TRIAL_FILE} says it",
            state.unit_text
        );
        return Some(column.place.clone().bad(found, accepted));
    }
    let (place, found) = column.hole.clone()?;
    let accepted = format!("a number in every row is expected: {reader} reads it");
    Some(place.bad(format!("column {name}: {found}"), accepted))
}
