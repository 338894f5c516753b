//! Effects on the force reading: refused where they could not act, and stepped finely enough where they can.

mod common;

use common::{fresh, line, model, plate};
use robot::{Controller, Tool, Wheel};
use sim::{Pass, PassError, PassRecord, PassSettings, Path, rest, run_pass};

const ADMITTANCE: Controller = Controller::Admittance { mass: 2.0, damping: 4000.0, period: 1e-3 };

fn run(effect: &str, settings: PassSettings) -> Result<PassRecord, PassError> {
    let model = model(&format!("process = \"grinding\"\n{effect}"));
    let (tool, mut grid) = (Tool::from(Wheel::cylinder(0.05, 0.006)), plate(1e-3, 0.0));
    let path = Path::along(&line(-0.005, 0.005, 0.0), 5e-3).expect("a path");
    run_pass(&mut grid, Pass::first(&tool, &path, &settings, &model), &mut fresh(&model), &mut |_| {})
}

#[test]
fn a_lag_of_the_force_is_refused_under_an_ideal_controller_by_name() {
    let lag = "[effect.force-lag]\nlag = \"50 ms\"\n";
    let refused = run(lag, PassSettings::default()).expect_err("it could not act");
    assert_eq!(refused, PassError::NoDynamics { effect: "force-lag".to_owned() });
    assert!(refused.to_string().contains("admittance"), "{refused}");
    assert!(run("[effect.force-lag]\nlag = \"0 s\"\n", PassSettings::default()).is_ok());
    assert!(run(lag, PassSettings { controller: Controller::Replay, ..PassSettings::default() }).is_ok());
}

#[test]
fn an_admittance_that_reads_a_past_force_is_stepped_at_its_period() {
    let settings = PassSettings { controller: ADMITTANCE, ..PassSettings::default() };
    let every_period = 2000;
    let quick = run("", settings).expect("a pass");
    assert!(quick.steps < every_period / 4, "{}", quick.steps);
    let lag = run("[effect.force-lag]\nlag = \"50 ms\"\n", settings).expect("a pass");
    assert!((every_period..every_period + 20).contains(&lag.steps), "{}", lag.steps);
    let fine =
        run("[effect.force-lag]\nlag = \"50 ms\"\n", PassSettings { quasi_static: false, ..settings }).expect("a pass");
    assert_eq!(lag, fine);
}

#[test]
fn a_swing_in_time_is_followed_by_either_controller() {
    let chatter = "[effect.chatter]\nsine = \"0.2\"\nfrequency = \"20 Hz\"\n";
    for controller in [Controller::Ideal, ADMITTANCE] {
        let record = run(chatter, PassSettings { controller, ..PassSettings::default() }).expect("a pass");
        assert!(record.steps >= 400, "{}", record.steps);
    }
    // F = F_set (1 + 0.2 sin): the force's rms off the setpoint is 0.2/√2.
    let record = run(chatter, PassSettings::default()).expect("a pass");
    let swing = record.force_rms_error / 15.0 * 2f64.sqrt();
    println!("ideal controller under a swing of 0.2 at 20 Hz: {swing:.4}");
    assert!((swing / 0.2 - 1.0).abs() < 0.02, "{swing}");
}

#[test]
fn states_recover_in_a_pause() {
    let model = model(
        "process = \"sanding\"\n[effect.pad-loading]\nloading_volume = \"100 mm^3\"\nclearing_rate = \"0.01 1/s\"\n\
         [effect.thermal-softening]\ntime_constant = \"8 s\"\n",
    );
    let (tool, mut grid) = (Tool::from(robot::Pad { radius: 0.01 }), plate(1e-3, 0.0));
    let path = Path::along(&line(-0.005, 0.005, 0.0), 5e-3).expect("a path");
    let settings = PassSettings::default();
    let pass = Pass::first(&tool, &path, &settings, &model);
    let mut states = fresh(&model);
    run_pass(&mut grid, pass, &mut states, &mut |_| {}).expect("a pass");
    let of = |states: &effects::States| {
        let names = ["pad-loading.loaded_volume", "thermal-softening.temperature_rise"];
        names.map(|name| states.tool_state(&model, name).expect(name))
    };
    let before = of(&states);
    assert!(before.iter().all(|value| *value > 0.0), "{before:?}");
    rest(&Pass { number: 2, trial_time: 40.0, ..pass }, &mut states, 30.0).expect("a pause");
    let after = of(&states);
    for (i, exact) in [(-30.0f64 * 0.01).exp(), (-30.0f64 / 8.0).exp()].into_iter().enumerate() {
        let left = after[i] / before[i];
        println!("after a pause of 30 s: {left:.6} left, exact {exact:.6}");
        assert!((left / exact - 1.0).abs() < 1e-3, "{left} {exact}");
    }
    let mut none = states.clone();
    rest(&pass, &mut none, 0.0).expect("no pause");
    assert_eq!(none, states);
}

#[test]
fn a_contact_too_soft_for_its_setpoint_is_no_air() {
    let soft = model("process = \"sanding\"\n[law.winkler]\nstiffness = \"1e5 Pa/m\"\n");
    let (tool, mut grid) = (Tool::from(robot::Pad { radius: 0.01 }), plate(1e-3, 0.0));
    let path = Path::along(&line(-0.005, 0.005, 0.0), 5e-3).expect("a path");
    let settings = PassSettings { search_reach: 2e-3, ..PassSettings::default() };
    let pass = Pass::first(&tool, &path, &settings, &soft);
    let refused = run_pass(&mut grid, pass, &mut fresh(&soft), &mut |_| {}).expect_err("π r² K 2 mm = 0.06 N");
    assert_eq!(refused, PassError::TooSoft { setpoint: 15.0, reach: 2e-3 });
    assert!(refused.to_string().contains("15 N within 2 mm"), "{refused}");
}
