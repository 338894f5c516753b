//! Errors that scanner and robot add to the measurements.

use effects::{CompiledModel, Model, Process};
use sdf_bake::HeightMap;
use trial_simulation::CampaignSimulation;
use trial_simulation::{SimulatedPass, exposed_share};
use trials::measure::{DegreesOfFreedom, NoiseFloor, centre_and_sigma, despiked, noise_floor, register, untouched};
use trials::trial::{PassScan, Trial};
use virtual_lab::{Experiment, Hidden, Instrument, Made, Plan};

use crate::made::{clean, experiment, heights};

fn floor_of(trial: &Trial) -> NoiseFloor {
    noise_floor(&despiked(&trial.scans.before).0, &despiked(&trial.scans.repeats[0]).0).unwrap()
}

/// Simulates the trials of an experiment with its true model.
fn rehearsed(experiment: &Experiment, made: &Made) -> Vec<Vec<SimulatedPass>> {
    let simulation = CampaignSimulation::new(&made.trials, None, false).unwrap();
    let model = Model::parse("answer", &made.answer.model, &experiment.library).unwrap();
    simulation.run(&CompiledModel::new(&model, &experiment.library, simulation.rows()).unwrap()).unwrap()
}

/// Returns the robust deviation of a scan from a simulated one, over that of two scans' noise.
fn deviation(trial: &Trial, pass: usize, simulated: &HeightMap) -> f64 {
    let (measured, _) = despiked(heights(trial, pass));
    let mut free = vec![true; measured.heights.len()];
    for before in &trial.passes[..=pass] {
        let alone = untouched(&trial.scans.before, &before.tool_path(&trial.tool), &trial.tool, 0.1e-3);
        free.iter_mut().zip(alone).for_each(|(free, alone)| *free &= alone);
    }
    let laid = register(&measured, simulated, DegreesOfFreedom::All, |at| free[at]).unwrap();
    let left: Vec<f64> = laid.left(&measured, simulated).into_iter().filter(|left| left.is_finite()).collect();
    centre_and_sigma(&left).unwrap().1 / (2f64.sqrt() * floor_of(trial).sigma)
}

#[test]
fn repeated_scans_have_the_noise_that_was_put_in() {
    // The plane removed by the registration contains a part of the correlated noise of a small map.
    for (instrument, likeness) in [(Instrument::clean(), 0.12), (Instrument::hard(), 0.15)] {
        let experiment = Experiment { plan: Plan::Varied, trials: 3, instrument, ..experiment(Process::Grinding, &[]) };
        let floors: Vec<NoiseFloor> = experiment.make().unwrap().trials.iter().map(floor_of).collect();
        let mean = |value: fn(&NoiseFloor) -> f64| floors.iter().map(value).sum::<f64>() / floors.len() as f64;
        let (sigma, white) = (mean(|floor| floor.sigma), mean(|floor| floor.white));
        let length = mean(|floor| floor.correlation_length);
        println!(
            "noise {:.2} µm for {:.2}, white {:.2} for {:.2}, shared over {:.2} mm for {:.2}",
            sigma * 1e6,
            instrument.noise() * 1e6,
            white * 1e6,
            instrument.white * 1e6,
            length * 1e3,
            instrument.correlation_length * 1e3
        );
        assert!((sigma / instrument.noise() - 1.0).abs() < likeness, "{sigma}");
        assert!((white / instrument.white - 1.0).abs() < 0.2, "{white}");
        assert!((length / instrument.correlation_length - 1.0).abs() < 0.4, "{length}");
    }
}

#[test]
fn scans_lack_and_exaggerate_as_many_pixels_as_they_should() {
    let before = &clean().trials[0].scans.before;
    let (nx, ny) = (before.pixels.nx, before.pixels.ny);
    let rim = 2 * (nx + ny) - 4;
    let holes = (before.missing() - rim) as f64 / before.pixels.len() as f64;
    let spikes = despiked(before).1.len() as f64 / before.pixels.len() as f64;
    println!("{:.2} % in holes, {:.2} % spikes found", 100.0 * holes, 100.0 * spikes);
    assert!((0.006..0.013).contains(&holes) && (0.0005..0.004).contains(&spikes));
    let steps = before.heights.iter().filter(|height| height.is_finite()).map(|height| height * 1e6);
    assert!(steps.map(|step| (step - step.round()).abs()).fold(0.0, f64::max) < 1e-6);
}

#[test]
fn the_true_model_reproduces_a_ground_campaign() {
    let experiment = experiment(Process::Grinding, &[]);
    let (trial, simulated) = (&clean().trials[0], &rehearsed(&experiment, clean())[0]);
    let mut volumes_off = Vec::new();
    for (pass, simulated) in simulated.iter().enumerate() {
        let truth = clean().answer.trials["trial-1"].removed_by_law_mm3[pass];
        let off = simulated.record.removed_volume * 1e9 / truth - 1.0;
        let PassScan::Heights(scan) = &simulated.scan else { panic!("heights are expected") };
        let deviation = deviation(trial, pass, scan);
        println!("pass {}: {:+.2} % volume, {deviation:.2} of two scans' noise", pass + 1, 100.0 * off);
        assert!(off.abs() < 0.015, "{off}");
        assert!(deviation < 1.3, "{deviation}");
        assert_ne!(off, 0.0, "the measurements are the model's own");
        volumes_off.push(off);
    }
    // A single volume may agree at random.
    assert!(volumes_off.iter().any(|off| off.abs() > 1e-4), "{volumes_off:?}");
}

#[test]
fn the_true_model_reproduces_a_sanded_panel() {
    let experiment = experiment(Process::Sanding, &[Hidden::effect("pad-loading")]);
    let made = experiment.make().unwrap();
    for (pass, simulated) in rehearsed(&experiment, &made)[0].iter().enumerate() {
        let PassScan::Exposure(mask) = &made.trials[0].passes[pass].scan else { panic!("a mask is expected") };
        let (truth, seen) = (made.answer.trials["trial-1"].exposed_share[pass], exposed_share(mask));
        let share = simulated.exposed_share.unwrap();
        println!("pass {}: {truth:.4} exposed in truth, {seen:.4} scanned, {share:.4} simulated", pass + 1);
        assert!((share - truth).abs() < 0.015 && (seen - truth).abs() < 0.02);
    }
}

#[test]
fn a_log_tells_what_the_robot_believed() {
    let hidden = [Hidden::effect("force-bias").with("bias", "3 N"), Hidden::effect("spindle-droop")];
    let made = experiment(Process::Grinding, &hidden).make().unwrap();
    let mean = |made: &Made, value: fn(&robot::LogRow) -> f64| {
        let pass = &made.trials[0].passes[0];
        let contact = pass.tool_path(&made.trials[0].tool).contact.unwrap();
        let rows = pass.log.rows.iter().filter(|row| row.time > contact.start + 0.5 && row.time < contact.end - 0.1);
        let values: Vec<f64> = rows.map(value).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let (biased, plain) = (mean(&made, |row| row.force), mean(clean(), |row| row.force));
    let speeds = (mean(&made, |row| row.spindle_speed), made.trials[0].passes[0].spindle_speed);
    println!("{plain:.2} N logged, {biased:.2} N with 3 N of bias; {:.1} rad/s of {:.1}", speeds.0, speeds.1);
    // Admittance control on a falling surface holds a little less than its setpoint.
    assert!((plain - 15.0).abs() < 1.0 && (biased - plain).abs() < 0.5);
    assert!((speeds.0 / speeds.1 - 1.0).abs() < 1e-3);
    let volume = |made: &Made| made.answer.trials["trial-1"].removed_by_law_mm3[0];
    let only_bias = experiment(Process::Grinding, &hidden[..1]).make().unwrap();
    assert!(volume(&only_bias) > 1.1 * volume(clean()), "{}", volume(&only_bias));
    // The same seed gives the same noise: the scans before are the same.
    let same = |(a, b): (&f64, &f64)| a == b || (a.is_nan() && b.is_nan());
    let before = |made: &'static Made| &made.trials[0].scans.before.heights;
    assert!(before(clean()).iter().zip(&made.trials[0].scans.before.heights).all(same));
}
