//! Simulation speed of trials, in CPU seconds of one core: `cargo bench --bench simulate`.
//!
//! Reads the campaigns beside the project, or those of `ROBOFIN_SHARED`.

use std::path::PathBuf;
use std::time::Instant;

use effects::{CompiledModel, Library, Model, RowCounts};
use robot::Controller;
use sim::{Clock, Phase};
use trial_simulation::Simulation;
use trials::trial::{Campaign, Trial};

/// Base laws with values close to those of the campaigns.
const GRINDING: &str = r#"process = "grinding"
[law.winkler]
stiffness = "30 MPa/mm"
[law.preston-threshold]
grind_rate = "1.4 mm/(MPa s)"
threshold_pressure = "0.25 MPa"
"#;
const SANDING: &str = r#"process = "sanding"
[law.winkler]
stiffness = "0.012 MPa/mm"
[law.preston-sanding]
sanding_rate = "0.026 1/(MPa mm)"
"#;

/// Number of runs, of which the fastest counts: other programs on the machine can only slow a run down.
const RUNS: usize = 5;

fn main() {
    let shared = std::env::var_os("ROBOFIN_SHARED").map_or_else(|| PathBuf::from("../shared"), PathBuf::from);
    for (name, text) in [("open-a", GRINDING), ("open-d", SANDING)] {
        println!("{name}");
        let folder = shared.join("campaigns").join(name);
        let Ok(campaign) = Campaign::read(&folder) else {
            println!("{}: no campaign there, nothing measured", folder.display());
            continue;
        };
        let model = Model::parse("the base law", text, Library::builtin()).expect("a model");
        let model = CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model");
        for trial in &campaign.trials {
            measure(trial, &model);
        }
    }
}

fn measure(trial: &Trial, model: &CompiledModel) {
    let pitch = trial.scans.before.pixels.pitch;
    let clocks = [Clock::default(), Clock::default()];
    let mut simulation = Simulation::new(trial, pitch, false).expect("a simulation");
    let start = cpu_seconds();
    let part = Simulation::new(trial, pitch, false).expect("a simulation").part;
    let baking = cpu_seconds() - start;
    run(&format!("{}, quasi-static", trial.name), &mut simulation, model, &clocks[0]);
    simulation.change_settings(|settings| {
        settings.quasi_static = false;
        if let Controller::Admittance { period, .. } = &mut settings.controller {
            *period = 1e-3;
        }
    });
    if std::env::var_os("QUASI").is_none() && matches!(trial.controller, Controller::Admittance { .. }) {
        run(&format!("{}, admittance at 1 ms", trial.name), &mut simulation, model, &clocks[1]);
    }
    println!("  part from the scan in {baking:.3} s, {:.1} MB", part.bytes() as f64 / 1e6);
}

/// Runs a trial several times for its shortest time, and once more for the time of each phase.
fn run<'a>(name: &str, simulation: &mut Simulation<'a>, model: &CompiledModel, clock: &'a Clock) {
    forget_peak();
    let runs = [(); RUNS].map(|()| run_once(simulation, model));
    let (steps, seconds) = (runs[0].0, runs.iter().map(|run| run.1).fold(f64::INFINITY, f64::min));
    let peak = peak_bytes() / 1e6;
    println!(
        "{name}: {:.1} s in {seconds:.3} CPU s, {:.0} times real time, {steps} steps, {:.0} µs each, {peak:.0} MB at most",
        simulation.duration(0),
        simulation.duration(0) / seconds,
        seconds / steps as f64 * 1e6
    );
    simulation.clock = Some(clock);
    let start = Instant::now();
    run_once(simulation, model);
    let all = start.elapsed().as_secs_f64();
    simulation.clock = None;
    let shares = Phase::ALL.map(|phase| format!("{} {:.0} %", label(phase), clock.seconds(phase) / all * 100.0));
    let rest = all - Phase::ALL.iter().map(|&phase| clock.seconds(phase)).sum::<f64>();
    println!("  {}, scan and other {:.0} %", shares.join(", "), rest / all * 100.0);
}

/// Number of steps of a trial, and their CPU time [s].
fn run_once(simulation: &Simulation, model: &CompiledModel) -> (usize, f64) {
    let start = cpu_seconds();
    let (passes, _) = simulation.run(model, &mut Simulation::fresh_states(model), 0, &mut |_, _| {}).expect("a trial");
    (passes.iter().map(|pass| pass.record.steps).sum(), cpu_seconds() - start)
}

fn label(phase: Phase) -> &'static str {
    match phase {
        Phase::Read => "height fields read",
        Phase::Cells => "cells",
        Phase::Model => "model",
        Phase::Integrate => "integration",
        Phase::Apply => "sums and log",
        Phase::Write => "field written",
    }
}

/// Resets the peak memory of the process.
fn forget_peak() {
    std::fs::write("/proc/self/clear_refs", "5").expect("Linux lets a process forget its peak");
}

/// Peak memory of the process since the reset, campaigns included [bytes].
fn peak_bytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux tells of a process");
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).expect("a peak");
    line.trim().trim_end_matches(" kB").parse::<f64>().expect("kilobytes") * 1024.0
}

/// CPU time of the calling thread [s]; the simulator runs on it alone.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux keeps a thread's CPU time");
    stat.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}
