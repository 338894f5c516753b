//! Quantities measured along a pass: a state of the same name follows them.

mod common;

use common::{fresh, line, plate};
use effects::{CompiledModel, Dimension, Library, Model, Process, RowCounts};
use robot::{Tool, Wheel};
use sim::{ForceProfile, Measured, Pass, PassSettings, Path, rest, run_pass};

const FORCE: f64 = 15.0;
const REFERENCE: f64 = 0.5;
const CHANGE: f64 = 0.8;

/// The rate is linear in a humidity that only a measurement changes.
const HUMID: &str = r#"
name = "humid"
[parameters.change]
unit = "1"
null = 0.0
range = [-2.0, 2.0]
default = 0.8
[state.humidity]
per = "tool"
unit = "%"
rate = "0"
initial = 50.0
reset = "never"
[modify]
rate = "rate * (1 + change * (humidity - 50 [%]))"
"#;

/// The rate is linear in the logged temperature.
const WARM: &str = r#"
name = "warm"
[parameters.change]
unit = "1/K"
null = 0.0
range = [-1.0, 1.0]
default = 0.02
[modify]
rate = "rate * (1 + change * (temperature_logged - 293.15 [K]))"
"#;

fn model(name: &str, text: &str) -> CompiledModel {
    let library = Library::builtin().with(&[(format!("{name}.toml"), text.to_owned())]).expect("an effect");
    let mut model = Model::new(Process::Grinding).with(name);
    model.set("preston-threshold", "threshold_pressure", &[0.0]);
    CompiledModel::new(&model, &library, RowCounts::default()).expect("a model")
}

fn measured(name: &str, dimension: Dimension, times: &[f64], values: &[f64]) -> Measured {
    Measured { name: name.to_owned(), dimension, times: times.to_vec(), values: values.to_vec() }
}

fn humidity(times: &[f64], values: &[f64]) -> Measured {
    measured("humidity", Dimension::NONE, times, values)
}

/// Volume removed in a pass of 8 mm at 5 mm/s [m³], and the state `humidity` afterwards.
fn removed(model: &CompiledModel, measured: &[Measured]) -> (f64, Option<f64>) {
    let (tool, settings) = (Tool::from(Wheel::cylinder(0.05, 0.006)), PassSettings::default());
    let path = Path::along(&line(-0.004, 0.004, 0.0), 5e-3).expect("a path");
    let (mut grid, mut states) = (plate(0.5e-3, 0.0), fresh(model));
    let pass = Pass { measured, ..Pass::first(&tool, &path, &settings, model) };
    rest(&pass, &mut states, 1.0).expect("a pause");
    let record = run_pass(&mut grid, pass, &mut states, &mut |_| {}).expect("a pass");
    (record.removed_volume, states.tool_state(model, "humid.humidity"))
}

#[test]
fn the_removal_follows_a_column_along_the_pass() {
    let model = model("humid", HUMID);
    let rate = model.law_value("grind_rate").expect("a law");
    let duration = 0.008 / 5e-3;
    // V = k ∫ F (1 + a (h(t) - h_0)) dt for p_c = 0, with h linear from 0.3 to 0.9.
    let (volume, last) = removed(&model, &[humidity(&[0.0, duration], &[0.3, 0.9])]);
    let expected = rate * FORCE * duration * (1.0 + CHANGE * (0.6 - REFERENCE));
    println!("{:.4} of the closed form, last humidity {last:?}", volume / expected);
    assert!((volume / expected - 1.0).abs() < 0.01);
    // The last step began less than a tenth of a second before the end.
    assert!((last.unwrap() - 0.9).abs() < 0.1 / duration * 0.6);
}

#[test]
fn one_value_holds_for_the_whole_pass_and_none_leaves_the_state_at_its_initial_value() {
    let model = model("humid", HUMID);
    let (plain, initial) = removed(&model, &[]);
    let (damp, state) = removed(&model, &[humidity(&[0.0], &[0.75])]);
    assert_eq!((initial, state), (Some(0.5), Some(0.75)));
    assert!((damp / plain / (1.0 + CHANGE * 0.25) - 1.0).abs() < 0.005, "{damp} {plain}");
    let same = removed(&model, &[humidity(&[0.0, 0.3, 9.0], &[0.5, 0.5, 0.5])]);
    assert_eq!(same, (plain, initial), "a column that never changes is a value, to the last bit");
    let other = removed(&model, &[measured("humidity", Dimension::whole([0, 0, 0, 1]), &[0.0], &[0.75])]);
    assert_eq!(other, (plain, initial), "a quantity of another dimension is not read");
}

#[test]
fn the_logged_temperature_is_what_the_log_says() {
    let model = model("warm", WARM);
    let kelvin = Dimension::whole([0, 0, 0, 1]);
    let (plain, _) = removed(&model, &[]);
    let (warm, _) = removed(&model, &[measured("temperature", kelvin, &[0.0, 1.6], &[303.15, 313.15])]);
    assert!((warm / plain / (1.0 + 0.02 * 15.0) - 1.0).abs() < 0.01, "{warm} {plain}");
}

#[test]
fn the_removal_follows_a_force_along_the_pass() {
    let model = model("humid", HUMID);
    let (tool, settings) = (Tool::from(Wheel::cylinder(0.05, 0.006)), PassSettings::default());
    let path = Path::along(&line(-0.004, 0.004, 0.0), 5e-3).expect("a path");
    let duration = path.duration();
    // A ramp from 5 N to 25 N with a ripple of 10 % and 12 Hz; no step is short enough to resolve it.
    let force = |time: f64| 5.0 + 20.0 * time / duration + 1.5 * (std::f64::consts::TAU * 12.0 * time).sin();
    let times = (0..=1600).map(|k| k as f64 / 1600.0 * duration);
    let course = ForceProfile::new(times.map(|time| (time, force(time))), 0.0);
    let removed = |force: Option<&ForceProfile>| {
        let (mut grid, mut states) = (plate(0.5e-3, 0.0), fresh(&model));
        let pass = Pass { force, ..Pass::first(&tool, &path, &settings, &model) };
        run_pass(&mut grid, pass, &mut states, &mut |_| {}).expect("a pass").removed_volume
    };
    // V = k ∫ F dt for p_c = 0, within 0.3 %, the error that the lattice leaves under a constant force.
    let (found, constant) = (removed(Some(&course)), removed(None));
    let expected = constant * course.mean(0.0..duration) / FORCE;
    let rate = model.law_value("grind_rate").expect("a law");
    println!("{:.5} of it, which has {:.5} of k F T", found / expected, constant / (rate * FORCE * duration));
    assert!((found / expected - 1.0).abs() < 0.004, "{}", found / expected);
    let pass = Pass { force: Some(&course), ..Pass::first(&tool, &path, &settings, &model) };
    assert_eq!(sim::gpu::refusal(&pass).as_deref(), Some("a force setpoint that changes in the course of a pass"));
}

#[test]
fn the_device_refuses_a_column_that_changes_by_its_name() {
    let model = model("humid", HUMID);
    let (tool, settings) = (Tool::from(Wheel::cylinder(0.05, 0.006)), PassSettings::default());
    let path = Path::along(&line(-0.004, 0.004, 0.0), 5e-3).expect("a path");
    let refusal =
        |measured: &[Measured]| sim::gpu::refusal(&Pass { measured, ..Pass::first(&tool, &path, &settings, &model) });
    let said = refusal(&[humidity(&[0.0, 1.0], &[0.3, 0.4])]).expect("a refusal");
    assert!(said.contains("humidity"), "{said}");
    assert_eq!(refusal(&[humidity(&[0.0], &[0.3])]), None);
    let unread = measured("batch", Dimension::NONE, &[0.0, 1.0], &[1.0, 2.0]);
    assert_eq!(refusal(&[unread]), None, "what no formula reads does not matter");
}
