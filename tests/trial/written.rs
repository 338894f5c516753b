//! Written files are read back unchanged.

use robot::Controller;
use sdf_bake::HeightMap;
use trials::trial::{Campaign, ForceInput, PassScan, Trial, write_trial};

use crate::files::{edit, folder, grinding, noted, sanding};

fn same_heights(a: &HeightMap, b: &HeightMap) -> bool {
    let near = |(a, b): (&f64, &f64)| (a.is_nan() && b.is_nan()) || (a - b).abs() < 0.6e-9;
    a.heights.len() == b.heights.len() && a.heights.iter().zip(&b.heights).all(near)
}

fn returned(trial: &Trial) -> Trial {
    let folder = tempfile::tempdir().unwrap();
    write_trial(trial, folder.path()).unwrap();
    Trial::read(folder.path()).unwrap()
}

#[test]
fn a_controller_without_mass_returns() {
    let controller = Controller::Admittance { mass: 0.0, damping: 1500.0, period: 5e-4 };
    assert_eq!(returned(&Trial { controller, ..grinding() }).controller, controller);
}

#[test]
fn a_logged_force_that_leads_returns() {
    let returned = returned(&Trial { controller: Controller::Ideal, force_input: ForceInput::Log, ..grinding() });
    assert_eq!((returned.controller, returned.force_input), (Controller::Ideal, ForceInput::Log));
}

#[test]
fn a_grinding_trial_returns() {
    let (trial, read) = (grinding(), returned(&grinding()));
    assert_eq!(
        (&read.name, read.process, &read.tool, read.fresh, read.controller, read.coating),
        (&trial.name, trial.process, &trial.tool, trial.fresh, trial.controller, trial.coating)
    );
    assert!(same_heights(&trial.scans.before, &read.scans.before));
    assert!(same_heights(&trial.scans.repeats[0], &read.scans.repeats[0]));
    assert_eq!(trial.scans.material.unwrap().labels, read.scans.material.unwrap().labels);
    let (pass, again) = (&trial.passes[0], &read.passes[0]);
    assert_eq!((pass.role, pass.force_setpoint, pass.direction), (again.role, again.force_setpoint, again.direction));
    assert!((pass.feed - again.feed).abs() < 1e-12 && (pass.spindle_speed - again.spindle_speed).abs() < 1e-6);
    assert_eq!((pass.log.rows.len(), again.log.has_approach), (again.log.rows.len(), true));
    for (row, other) in pass.log.rows.iter().zip(&again.log.rows) {
        assert!((row.position - other.position).length() < 2e-9 && (row.time - other.time).abs() < 1e-6);
        assert!((row.force - other.force).abs() < 1e-6 && row.approach == other.approach);
    }
    assert_eq!(pass.log.covariates, again.log.covariates);
    assert!(again.log.temperature.iter().all(|t| t.is_nan()) && !again.log.temperature.is_empty());
    let (PassScan::Heights(map), PassScan::Heights(other)) = (&pass.scan, &again.scan) else { panic!("heights") };
    assert!(same_heights(map, other));
}

#[test]
fn a_sanding_trial_returns() {
    let (trial, read) = (sanding(), returned(&sanding()));
    assert_eq!((&read.tool, read.controller), (&trial.tool, trial.controller));
    assert!((read.coating.unwrap() - trial.coating.unwrap()).abs() < 1e-15);
    assert_eq!(trial.passes[0].scan, read.passes[0].scan);
}

/// Makes the grinding trial with different readings.
fn measured_again(number: usize, name: &str) -> Trial {
    let mut trial = Trial { name: name.into(), ..grinding() };
    let by = 1e-6 * number as f64;
    let lifted = |map: &mut sdf_bake::HeightMap| map.heights.iter_mut().for_each(|height| *height += by);
    lifted(&mut trial.scans.before);
    trial.scans.repeats.iter_mut().for_each(lifted);
    for pass in &mut trial.passes {
        pass.log.rows.iter_mut().for_each(|row| row.force += 0.01 * number as f64);
        if let trials::trial::PassScan::Heights(map) = &mut pass.scan {
            lifted(map);
        }
    }
    trial
}

#[test]
fn a_campaign_is_its_trials_in_the_order_of_their_names() {
    let folder = tempfile::tempdir().unwrap();
    for (number, name) in ["trial-2", "trial-10", "notes", "trial-1"].into_iter().enumerate() {
        let place = folder.path().join(name);
        std::fs::create_dir(&place).unwrap();
        if name != "notes" {
            write_trial(&measured_again(number, name), &place).unwrap();
        }
    }
    edit(&folder.path().join("trial-10"), "trial.toml", |text| text.replace("fresh = true", "fresh = false"));
    let campaign = Campaign::read(folder.path()).unwrap();
    let names: Vec<&str> = campaign.trials.iter().map(|trial| trial.name.as_str()).collect();
    assert_eq!(names, ["trial-1", "trial-10", "trial-2"]);
    assert_eq!(campaign.trials.iter().map(|trial| trial.fresh).collect::<Vec<_>>(), [true, false, true]);

    let alone = Campaign::read(&folder.path().join("trial-1")).unwrap();
    assert_eq!(alone.trials.len(), 1);
    edit(&folder.path().join("trial-10"), "trial.toml", |text| text.replace("width_mm = 20", "width_mm = 19"));
    let error = Campaign::read(folder.path()).unwrap_err().to_string();
    assert!(error.contains("trial-10") && error.contains("not fresh and differs"), "{error}");
    let error = Campaign::read(&folder.path().join("notes")).unwrap_err().to_string();
    assert!(error.contains("no trial.toml"), "{error}");
}

#[test]
fn what_a_pass_does_not_say_is_taken_from_its_log() {
    let folder = folder();
    edit(folder.path(), "trial.toml", |text| {
        let dropped = ["feed_mm_s", "spindle_rpm", "direction"];
        text.lines().filter(|line| !dropped.iter().any(|key| line.starts_with(key))).collect::<Vec<_>>().join("\n")
    });
    let pass = &noted(folder.path(), &["pass1_log.csv", "feed_mm_s", "taken from here"]).passes[0];
    assert!((pass.feed - 0.005).abs() < 1e-6 && (pass.spindle_speed - 628.3185).abs() < 1e-3, "{}", pass.feed);
    assert_eq!(pass.direction, glam::DVec3::X);
}
