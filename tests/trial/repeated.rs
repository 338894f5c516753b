//! A model that was just simulated is known, and nothing else is taken for it.

use std::path::Path;

use effects::{CompiledModel, Library, Model};
use trial_simulation::{CampaignSimulation, SimulatedPass};
use trials::trial::{Campaign, Trial};

const MODEL: &str = "process = \"grinding\"\n[law.winkler]\nstiffness = \"20 MPa/mm\"\n[law.preston-threshold]\n\
                     grind_rate = \"1.2 mm/(MPa s)\"\nthreshold_pressure = \"0.1 MPa\"\n";

/// The first trials of the bundled campaign; the second one goes on with the tool of the first.
fn trials() -> Vec<Trial> {
    let place = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look");
    let mut trials = Campaign::read(&place).unwrap().trials;
    trials.truncate(2);
    trials[1].fresh = false;
    trials
}

fn prepared(trials: &[Trial]) -> (CampaignSimulation<'_>, CompiledModel) {
    let simulation = CampaignSimulation::new(trials, Some(1e-3), false).unwrap();
    let model = Model::parse("model", MODEL, Library::builtin()).unwrap();
    let model = CompiledModel::new(&model, Library::builtin(), simulation.rows()).unwrap();
    (simulation, model)
}

/// Number of passes of each trial, and all numbers of their records and scans, in words.
fn words(passes: &[Vec<SimulatedPass>]) -> (Vec<usize>, String) {
    (passes.iter().map(Vec::len).collect(), format!("{passes:?}"))
}

#[test]
fn the_same_model_again_gives_the_same_numbers_for_fewer_passes_too() {
    let trials = trials();
    let (simulation, model) = prepared(&trials);
    let fresh = |passes: &[usize]| words(&prepared(&trials).0.run_first(&model, passes).unwrap());
    let all: Vec<usize> = trials.iter().map(|trial| trial.passes.len()).collect();
    let made = words(&simulation.run(&model).unwrap());
    assert_eq!(made, fresh(&all));
    assert_eq!(words(&simulation.run(&model).unwrap()), made);
    // The second trial depends on how far the tool was used in the first.
    for fewer in [[all[0], 1], [1, 0], [1, 1]] {
        assert_eq!(words(&simulation.run_first(&model, &fewer).unwrap()), fresh(&fewer), "{fewer:?}");
    }
}

#[test]
fn another_value_or_a_limit_of_steps_is_not_the_same() {
    let trials = trials();
    let (mut simulation, model) = prepared(&trials);
    let made = words(&simulation.run(&model).unwrap());
    let mut other = model.clone();
    other.set(0, model.value(0) * (1.0 + 1e-9));
    assert!(model.is_same(&prepared(&trials).1) && !model.is_same(&other));
    assert_ne!(words(&simulation.run(&other).unwrap()), made);
    simulation.limit_steps(Some(1));
    let error = simulation.run(&model).unwrap_err().to_string();
    assert!(error.contains("trial-1") && error.contains("steps"), "{error}");
    simulation.limit_steps(None);
    assert_eq!(words(&simulation.run(&model).unwrap()), made);
}
