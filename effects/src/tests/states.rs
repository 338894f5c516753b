//! Compares states with closed forms.

use crate::tests::compiled;
use crate::{CompiledModel, Hook, Lanes, Library, Model, Process, Reset, RowCounts, States, StepValues, Variable};

/// Evaluates the rate hook in one lane with a base rate of 1 um/s.
fn rate_factor(model: &CompiledModel, step: &StepValues, states: &States) -> f64 {
    let rate = 1e-9 * 1e6;
    let mut out = [0.0];
    let lanes = Lanes::new(1).with(Variable::Pressure, &[1e6]).with(Variable::RemovedDepth, &[0.0]);
    model.at(Hook::Rate, step, states).run(&lanes, &mut out).unwrap();
    out[0] / rate
}

#[test]
fn dulling_is_the_exponential_of_the_ground_volume() {
    let mut model = compiled(&Model::new(Process::Grinding).with("grit-dulling"));
    let index = model.index("grit-dulling.dulling_volume").unwrap();
    let mut states = States::new(&model, 0);
    let mut step = StepValues::new();
    step.set(Variable::RemovalRate, 8e-9).set(Variable::Force, 15.0).set(Variable::SlidingSpeed, 31.4);
    for _ in 0..1000 {
        states.advance(&model, 0.01, &step, &Lanes::new(0)).unwrap();
    }
    // W = 80 mm³ of 350 mm³
    let factor = rate_factor(&model, &step, &states);
    assert!((factor - (-80.0f64 / 350.0).exp()).abs() < 1e-12, "{factor}");
    model.set(index, 160e-9);
    let factor = rate_factor(&model, &step, &states);
    assert!((factor - (-0.5f64).exp()).abs() < 1e-12, "{factor}");

    states.reset(&model, Reset::Trial);
    assert!(rate_factor(&model, &step, &states) < 0.7, "a new workpiece does not dress the wheel");
    states.reset(&model, Reset::FreshTool);
    assert_eq!(rate_factor(&model, &step, &states), 1.0);
}

#[test]
fn loading_is_the_exponential_of_the_coating_volume() {
    let mut model = Model::new(Process::Sanding).with("pad-loading");
    model.set("pad-loading", "loading_volume", &[260e-9]);
    let model = compiled(&model);
    let mut states = States::new(&model, 0);
    let mut step = StepValues::new();
    step.set(Variable::DoseVolumeRate, 1e-8);
    (0..130).for_each(|_| states.advance(&model, 0.1, &step, &Lanes::new(0)).unwrap());
    let lanes = Lanes::new(1).with(Variable::Pressure, &[1e4]).with(Variable::SlipSpeed, &[2.0]);
    let mut out = [0.0];
    model.at(Hook::Dose, &step, &states).run(&lanes, &mut out).unwrap();
    let expected = 2e-5 * 1e4 * 2.0 * (-0.5f64).exp();
    assert!((out[0] / expected - 1.0).abs() < 1e-12, "{}", out[0]);
}

#[test]
fn relaxations_are_exact_for_any_step() {
    let model = compiled(&Model::new(Process::Grinding).with("thermal-softening"));
    let mut step = StepValues::new();
    step.set(Variable::Force, 15.0).set(Variable::SlidingSpeed, 31.4);
    let target: f64 = 1.0 * 0.28 * 15.0 * 31.4;
    for (steps, dt) in [(1, 7.0), (7, 1.0), (700, 0.01)] {
        let mut states = States::new(&model, 0);
        (0..steps).for_each(|_| states.advance(&model, dt, &step, &Lanes::new(0)).unwrap());
        let heated = states.tool_state(&model, "thermal-softening.temperature_rise").unwrap();
        let expected = target * (1.0 - (-7.0f64 / 5.0).exp());
        assert!((heated / expected - 1.0).abs() < 1e-12, "{steps} steps: {heated}, not {expected}");
        states.advance(&model, 11.0, &step.at_rest(), &Lanes::new(0)).unwrap();
        let cooled = states.tool_state(&model, "thermal-softening.temperature_rise").unwrap();
        assert!((cooled / (heated * (-11.0f64 / 5.0).exp()) - 1.0).abs() < 1e-12, "{cooled}");
    }
}

#[test]
fn a_lag_of_zero_reads_as_its_target_and_a_real_one_follows() {
    let mut model = compiled(&Model::new(Process::Grinding).with("force-lag"));
    let lag = model.index("force-lag.lag").unwrap();
    let mut states = States::new(&model, 0);
    let mut step = StepValues::new();
    step.set(Variable::Force, 20.0).set(Variable::ForceReading, 20.0);
    states.advance(&model, 0.05, &step, &Lanes::new(0)).unwrap();
    let reading = model.force_reading(&step, &states).unwrap();
    assert!((reading - 20.0 * (1.0 - (-1.0f64).exp())).abs() < 1e-12, "{reading}");
    model.set(lag, 0.0);
    assert_eq!(model.force_reading(&step, &states).unwrap(), 20.0);
    states.advance(&model, 0.05, &step, &Lanes::new(0)).unwrap();
    assert_eq!(states.tool_state(&model, "force-lag.lagged_force"), Some(20.0));
}

#[test]
fn a_worn_wheel_profile_is_read_between_its_cells() {
    let model = compiled(&Model::new(Process::Grinding).with("wheel-wear"));
    assert!(model.needs_tool_cells() && model.reads_tool_cells(Hook::Shape) && !model.reads_tool_cells(Hook::Rate));
    let mut states = States::new(&model, 3);
    let step = StepValues::new();
    let volume_rates = [0.0, 1e-9, 3e-9];
    let lanes = Lanes::new(3).with(Variable::CellRemovalRate, &volume_rates).with(Variable::CellFaceArea, &[1e-3; 3]);
    (0..10).for_each(|_| states.advance(&model, 1.0, &step, &lanes).unwrap());
    // 10 s · 1e-9 m³/s / (G = 10 · 1e-3 m²)
    let worn = states.tool_cell_state(&model, "wheel-wear.worn_depth").unwrap();
    assert!((worn[1] - 1e-6).abs() < 1e-18 && (worn[2] - 3e-6).abs() < 1e-18, "{worn:?}");
    let mut gap = [0.0; 5];
    let places = [-1.0, 0.5, 1.0, 1.75, 9.0];
    model.at(Hook::Shape, &step, &states).run(&Lanes::new(5).with_tool_cell(&places), &mut gap).unwrap();
    for (found, expected) in gap.iter().zip([0.0, 0.5e-6, 1e-6, 2.5e-6, 3e-6]) {
        assert!((found - expected).abs() < 1e-18, "{gap:?}");
    }
}

#[test]
fn workpiece_cells_keep_states_of_their_own() {
    let text = "name = \"hardening\"\ntitle = \"Hardening\"\nsource = \"none\"\n\n[parameters.amount]\nunit = \"1/J\"\n\
                null = 0.0\nrange = [0.0, 1.0]\n\n[state.work]\nper = \"workpiece_cell\"\nunit = \"J/m^2\"\n\
                rate = \"pressure * slip_speed\"\nmax = 5e6\n\n[modify]\nrate = \"rate / (1 + amount * 1 mm^2 * work)\"\n";
    let library = Library::builtin().with(&[("hardening.toml".to_owned(), text.to_owned())]).unwrap();
    let model = Model::new(Process::Grinding).with("hardening");
    let model = CompiledModel::new(&model, &library, RowCounts::default()).unwrap();
    assert_eq!(model.cell_states()[0].name, "hardening.work");
    let (states, step) = (States::new(&model, 0), StepValues::new());
    let mut work = [0.0, 1e6];
    for _ in 0..4 {
        let old = work;
        let held: [&[f64]; 1] = [&old];
        let lanes = Lanes::new(2).with(Variable::Pressure, &[1e6; 2]).with(Variable::SlipSpeed, &[2.0; 2]);
        model.advance_cells(0.5, (&step, &states), &lanes.with_states(&held), &mut [&mut work]).unwrap();
    }
    assert_eq!(work, [4e6, 5e6]);
    let held: [&[f64]; 1] = [&work];
    let mut rate = [0.0; 2];
    let lanes = Lanes::new(2).with(Variable::Pressure, &[1e6; 2]).with_states(&held);
    model.at(Hook::Rate, &step, &states).run(&lanes, &mut rate).unwrap();
    assert!((rate[1] - 1e-3 / (1.0 + 0.5 * 5.0)).abs() < 1e-15, "{rate:?}");
}

#[test]
fn parameters_per_pass_are_chosen_by_the_step() {
    let mut model = Model::new(Process::Grinding).with("pass-gain");
    model.set("pass-gain", "gain", &[0.1, -0.2]);
    let model = CompiledModel::new(&model, Library::builtin(), RowCounts { passes: 3, scans: 1 }).unwrap();
    assert_eq!(model.value(model.index("pass-gain.gain[2]").unwrap()), -0.2);
    let (states, mut step) = (States::new(&model, 0), StepValues::new());
    for (row, gain) in [0.1f64, -0.2, 0.0].into_iter().enumerate() {
        step.pass_row = row;
        assert!((rate_factor(&model, &step, &states) - gain.exp()).abs() < 1e-15);
    }
}
