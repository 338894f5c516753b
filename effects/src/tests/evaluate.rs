//! Compares the lane programs with direct interpretation, for all effects at once.

use crate::interpret::Environment;
use crate::null::probe;
use crate::scope::Scope;
use crate::tests::compiled;
use crate::{CompiledModel, Effect, Hook, Lanes, Library, Model, Process, States, StepValues, Variable};

/// Lanes of the tests: two full chunks and a partial one.
const COUNT: usize = 150;

/// A model with every effect of a process.
fn everything(process: Process) -> CompiledModel {
    let effects = Library::builtin().effects().iter().filter(|effect| effect.acts_in(process));
    compiled(&effects.fold(Model::new(process), |model, effect| model.with(&effect.name)))
}

/// Values of a step from the probe inputs.
fn step(index: u64) -> StepValues {
    let values = probe(index);
    let mut step = StepValues::new();
    for variable in Variable::ALL.iter().filter(|variable| variable.row().per == crate::Per::Step) {
        step.set(*variable, values[*variable as usize]);
    }
    step
}

/// Probe inputs of every lane: by lane, then by variable.
fn lanes() -> Vec<Vec<f64>> {
    (0..COUNT as u64).map(|lane| probe(2 + lane)).collect()
}

/// Transposes them: by variable, then by lane.
fn columns(lanes: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..Variable::COUNT).map(|variable| lanes.iter().map(|lane| lane[variable]).collect()).collect()
}

fn with_columns<'a>(columns: &'a [Vec<f64>], range: std::ops::Range<usize>) -> Lanes<'a> {
    let variables = Variable::ALL.iter().zip(columns);
    variables.fold(Lanes::new(range.len()), |lanes, (variable, values)| lanes.with(*variable, &values[range.clone()]))
}

/// Value of a hook in one lane, interpreted formula by formula.
fn interpreted(model: &CompiledModel, hook: Hook, mut variables: Vec<f64>, tool: (&States, usize)) -> f64 {
    let library = Library::builtin();
    let laws: Vec<Effect> = model.process().laws().iter().map(|name| library.find(name).unwrap().clone()).collect();
    let defaults = |effect: &Effect| -> Vec<f64> {
        effect.parameters.iter().map(|parameter| parameter.default.of(model.process())).collect()
    };
    let law_parameters: Vec<Vec<f64>> = laws.iter().map(defaults).collect();
    let value = hook.values()[0];
    if let Some(start) = value.start() {
        variables[value as usize] = start;
    }
    let effects = library.effects().iter().filter(|effect| effect.acts_in(model.process()));
    for effect in laws.iter().chain(effects) {
        let state = |state: &crate::State| {
            let name = format!("{}.{}", effect.name, state.name);
            let cells = || tool.0.tool_cell_state(model, &name).unwrap()[tool.1];
            tool.0.tool_state(model, &name).unwrap_or_else(cells)
        };
        let states: Vec<f64> = effect.states.iter().map(state).collect();
        let (parameters, scope) = (defaults(effect), Scope::new(effect, hook, &laws));
        let environment = Environment {
            scope,
            parameters: &parameters,
            law_parameters: &law_parameters,
            variables: &variables,
            states: &states,
        };
        let change = effect.changes.iter().find(|change| change.hook == hook);
        if let Some(change) = change {
            let result = environment.evaluate(&change.formula.tree);
            variables[value as usize] = result;
        }
    }
    variables[value as usize]
}

/// A tool after some steps, with states that differ from their initial values.
fn worn_tool(model: &CompiledModel, cells: usize) -> States {
    let mut states = States::new(model, cells);
    let rows: Vec<Vec<f64>> = (0..cells as u64).map(|cell| probe(300 + cell)).collect();
    let columns = columns(&rows);
    for index in 0..5 {
        states.advance(model, 0.1, &step(200 + index), &with_columns(&columns, 0..cells)).unwrap();
    }
    states
}

#[test]
fn programs_agree_with_interpretation_to_the_last_bit() {
    for process in Process::ALL {
        let model = everything(process);
        let states = worn_tool(&model, 7);
        let (step, lanes) = (step(77), lanes());
        let columns = columns(&lanes);
        let places: Vec<f64> = (0..COUNT).map(|lane| (lane % 7) as f64).collect();
        for hook in [Hook::Shape, Hook::Pressure, Hook::Rate, Hook::Dose, Hook::Height] {
            if !process.has(hook) {
                continue;
            }
            let mut out = vec![f64::NAN; COUNT];
            let call = model.at(hook, &step, &states);
            call.run(&with_columns(&columns, 0..COUNT).with_tool_cell(&places), &mut out).unwrap();
            for (lane, found) in out.iter().enumerate() {
                let mut variables = lanes[lane].clone();
                for variable in Variable::ALL.iter().filter(|variable| !variable.is_lane_at(hook)) {
                    if variable.row().per == crate::Per::Step {
                        variables[*variable as usize] = step.get(*variable);
                    }
                }
                let expected = interpreted(&model, hook, variables, (&states, lane % 7));
                assert_eq!(found.to_bits(), expected.to_bits(), "{hook} lane {lane}: {found:?}, not {expected:?}");
            }
        }
    }
}

#[test]
fn a_lane_gives_the_same_bits_wherever_it_stands() {
    let model = everything(Process::Grinding);
    let states = worn_tool(&model, 7);
    let (step, lanes) = (step(77), lanes());
    let columns = columns(&lanes);
    let places: Vec<f64> = (0..COUNT).map(|lane| lane as f64 * 0.05).collect();
    let run = |from: usize, to: usize| {
        let mut out = vec![0.0; to - from];
        let lanes = with_columns(&columns, from..to).with_tool_cell(&places[from..to]);
        model.at(Hook::Rate, &step, &states).run(&lanes, &mut out).unwrap();
        out
    };
    let whole = run(0, COUNT);
    for split in [1, 2, 3, 5, 31, 63, 64, 65, 128, 149] {
        let parts = [run(0, split), run(split, COUNT)].concat();
        assert_eq!(parts, whole, "split at {split}");
    }
}

#[test]
fn the_order_of_effects_in_the_model_changes_nothing() {
    let names = ["surface-layer", "pass-gain", "random-orbit", "pressure-exponent", "tool-tilt", "pad-loading"];
    let names: Vec<&str> = names.into_iter().filter(|name| *name != "surface-layer").collect();
    let model = |names: &mut dyn Iterator<Item = &&str>| {
        compiled(&names.fold(Model::new(Process::Sanding), |model, name| model.with(name)))
    };
    let (forwards, backwards) = (model(&mut names.iter()), model(&mut names.iter().rev()));
    assert_eq!(forwards.parameters(), backwards.parameters());
    let columns = columns(&lanes());
    let run = |model: &CompiledModel| {
        let mut out = vec![0.0; COUNT];
        let states = States::new(model, 1);
        model.at(Hook::Dose, &step(5), &states).run(&with_columns(&columns, 0..COUNT), &mut out).unwrap();
        out
    };
    assert_eq!(run(&forwards), run(&backwards));
}

#[test]
fn with_all_effects_at_null_the_model_is_the_base_model() {
    for process in Process::ALL {
        let (mut model, base) = (everything(process), compiled(&Model::new(process)));
        let nulls: Vec<(usize, f64)> =
            model.parameters().iter().enumerate().filter_map(|(index, slot)| Some((index, slot.null?))).collect();
        nulls.iter().for_each(|(index, null)| model.set(*index, *null));
        let (states, base_states) = (worn_tool(&model, 3), States::new(&base, 1));
        let (step, columns) = (step(9), columns(&lanes()));
        let places = vec![1.0; COUNT];
        for hook in [Hook::Shape, Hook::Pressure, Hook::Rate, Hook::Dose, Hook::Height] {
            let [mut with, mut without] = [vec![0.0; COUNT], vec![0.0; COUNT]];
            let lanes = with_columns(&columns, 0..COUNT).with_tool_cell(&places);
            model.at(hook, &step, &states).run(&lanes, &mut with).unwrap();
            base.at(hook, &step, &base_states).run(&lanes, &mut without).unwrap();
            assert_eq!(with, without, "{hook} when {}", process.name());
        }
        assert_eq!(model.pose(&step, &states).unwrap(), base.pose(&step, &base_states).unwrap());
        assert_eq!(model.force_reading(&step, &states).unwrap(), step.get(Variable::ForceReading));
        assert_eq!(model.spindle_speed(&step, &states).unwrap(), step.get(Variable::SpindleSpeed));
        assert_eq!(model.exposure_threshold(&step).unwrap(), 1.0);
    }
}
