//! The shared campaigns simulated with their true laws reproduce another laboratory's simulation.
//!
//! `residual` compares a scan with a simulation that starts from the previous scan: untouched pixels differ by the
//! noise of both scans, √2 times that of one. Residuals are therefore divided by the noise of two scans.

use effects::{CompiledModel, Library, Model};
use robofin::trial_run::residual;
use serde_json::Value;
use trial_simulation::CampaignSimulation;
use trial_simulation::SimulatedPass;
use trials::measure::{despiked, noise_floor};
use trials::trial::{Campaign, Trial};

use crate::shared::campaigns;

const GRINDING: &str = "process = \"grinding\"\n[law.winkler]\nstiffness = \"30 MPa/mm\"\n[law.preston-threshold]\n\
                        grind_rate = \"1.4 mm/(MPa s)\"\nthreshold_pressure = \"0.25 MPa\"\n";
const SANDING: &str = "process = \"sanding\"\n[law.winkler]\nstiffness = \"0.012 MPa/mm\"\n[law.preston-sanding]\n\
                       sanding_rate = \"0.026 1/(MPa mm)\"\n[effect.pad-loading]\nloading_volume = \"260 mm^3\"\n";

/// Simulates the passes of a campaign's trials with a model; also returns its answers; `None` if the campaign is
/// missing.
fn simulated(name: &str, first: usize, model: &str) -> Option<(Vec<Trial>, Vec<Vec<SimulatedPass>>, Value)> {
    let place = campaigns()?;
    let mut trials = Campaign::read(&place.join(name)).unwrap().trials;
    trials.truncate(first);
    let answers: Value = serde_json::from_slice(&std::fs::read(place.join("answers.json")).unwrap()).unwrap();
    let simulation = CampaignSimulation::new(&trials, None, false).unwrap();
    let model = Model::parse("model", model, Library::builtin()).unwrap();
    let passes = simulation.run(&CompiledModel::new(&model, Library::builtin(), simulation.rows()).unwrap()).unwrap();
    Some((trials, passes, answers[name]["trials"].clone()))
}

/// Returns the residual of each pass over the noise of two scans.
fn residuals(trial: &Trial, passes: &[SimulatedPass]) -> Vec<f64> {
    let (before, repeat) = (despiked(&trial.scans.before).0, despiked(&trial.scans.repeats[0]).0);
    let noise = 2f64.sqrt() * noise_floor(&before, &repeat).unwrap().rms;
    (0..passes.len()).map(|pass| residual(trial, &passes[pass], pass).unwrap() / noise).collect()
}

/// Greatest relative difference between the volumes of two laboratories' simulations; the time steps of each cause some
/// tenths of a per cent.
const VOLUME_TOLERANCE: f64 = 0.006;

/// Compares removed volumes, which the answers sum over the passes, with the tolerance [`VOLUME_TOLERANCE`], and
/// residuals with `most` times the noise of two scans.
fn grinding_comes_out(name: &str, effects: &str, most: f64) {
    let Some((trials, passes, answers)) = simulated(name, usize::MAX, &format!("{GRINDING}{effects}")) else { return };
    for (trial, passes) in trials.iter().zip(&passes) {
        let mut removed = 0.0;
        let residuals = residuals(trial, passes);
        for (i, pass) in passes.iter().enumerate() {
            removed += pass.record.removed_volume * 1e9;
            let off = removed / answers[&trial.name]["removed_mm3"][i].as_f64().unwrap() - 1.0;
            println!(
                "{name} {} pass {}: {:+.2} % volume, {:.3} of two scans' noise",
                trial.name,
                i + 1,
                100.0 * off,
                residuals[i]
            );
            assert!(off.abs() < VOLUME_TOLERANCE, "{name} {}: {removed} mm³", trial.name);
            assert!(residuals[i] < most, "{name} {}: {residuals:?}", trial.name);
        }
    }
}

#[test]
fn a_campaign_without_effects_comes_out() {
    grinding_comes_out("open-a", "", 1.3);
}

#[test]
fn a_wheel_that_dulls_comes_out() {
    grinding_comes_out("open-b", "[effect.grit-dulling]\ndulling_volume = \"350 mm^3\"\n", 1.32);
}

#[test]
fn a_tilted_wheel_comes_out_and_only_with_its_sign() {
    grinding_comes_out("open-c", "[effect.tool-tilt]\nroll_angle = \"12 mrad\"\n", 1.2);
    let wrong = format!("{GRINDING}[effect.tool-tilt]\nroll_angle = \"-12 mrad\"\n");
    let Some((trials, passes, _)) = simulated("open-c", 1, &wrong) else { return };
    let residuals = residuals(&trials[0], &passes[0]);
    assert!(residuals.iter().all(|residual| *residual > 3.0), "{residuals:?}");
}

#[test]
fn a_sheet_that_loads_comes_out() {
    let Some((trials, passes, answers)) = simulated("open-d", 1, SANDING) else { return };
    for (i, pass) in passes[0].iter().enumerate() {
        let share = pass.exposed_share.unwrap();
        let expected = answers[&trials[0].name]["exposed_fraction"][i].as_f64().unwrap();
        println!("open-d pass {}: {share:.4} exposed, {expected:.4} in truth", i + 1);
        assert!((share - expected).abs() < 0.01);
    }
}

#[test]
fn a_small_wheel_on_the_scan_of_a_rough_surface_comes_out() {
    // It comes down on single bumps, whose contact is far softer than the patch into which it grows.
    let model = GRINDING.replace("1.4 mm", "0.02 mm").replace("0.25 MPa", "0.1 MPa")
        + "[range]\n\"preston-threshold.grind_rate\" = [\"0.005 mm/(MPa s)\", \"2 mm/(MPa s)\"]\n";
    let Some((trials, passes, _)) = simulated("open-e", usize::MAX, &model) else { return };
    for (trial, passes) in trials.iter().zip(&passes) {
        let residuals = residuals(trial, passes);
        let volumes: Vec<f64> = passes.iter().map(|pass| pass.record.removed_volume * 1e9).collect();
        println!("open-e {}: {volumes:.4?} mm³, {residuals:.3?} of two scans' noise", trial.name);
        assert!(volumes.iter().all(|volume| *volume > 0.1), "{volumes:?}");
        assert!(residuals.iter().all(|residual| *residual < 1.3), "{residuals:?}");
    }
}
