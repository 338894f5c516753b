//! The scanner effects of a model in a whole trial, and the same passes scanned again with other values.

use effects::{CompiledModel, Library, Model, RowCounts};
use trial_simulation::{SimulatedPass, Simulation};
use trials::trial::{Campaign, PassScan};

use crate::shared::campaigns;

fn model(effects: &str) -> CompiledModel {
    let model = Model::parse("model.toml", &format!("process = \"grinding\"\n{effects}"), Library::builtin()).unwrap();
    CompiledModel::new(&model, Library::builtin(), RowCounts { passes: 3, scans: 3 }).unwrap()
}

fn heights(scan: &PassScan) -> &[f64] {
    let PassScan::Heights(map) = scan else { panic!("a grinding trial") };
    &map.heights
}

#[test]
fn scans_carry_the_scanner_and_passes_are_seen_again_without_being_simulated() {
    let Some(place) = campaigns() else { return };
    let trial = &Campaign::read(&place.join("open-c")).unwrap().trials[0];
    let simulation = Simulation::new(trial, 2.0 * trial.scans.before.pixels.pitch, false).unwrap();
    let run = |model: &CompiledModel| -> Vec<SimulatedPass> {
        simulation.run(model, &mut Simulation::fresh_states(model), 1, &mut |_, _| {}).unwrap().0
    };
    // The first row belongs to an earlier trial.
    let tilted = model(
        "[effect.scan-tilt]\npiston = [\"1 um\", \"2 um\", \"-3 um\"]\ntilt_x = \"0 rad\"\ntilt_y = \"0 rad\"\n\
         [effect.height-gain]\ngain = \"0 %\"\n",
    );
    let (plain, with) = (run(&model("")), run(&tilted));
    for (pass, piston) in [(0, 2e-6), (1, -3e-6)] {
        let pairs = heights(&with[pass].scan).iter().zip(heights(&plain[pass].scan));
        let off = pairs.map(|(with, plain)| (with - plain - piston).abs()).fold(0.0, f64::max);
        assert!(off < 1e-15, "pass {}: {off}", pass + 1);
        assert_eq!(with[pass].record, plain[pass].record);
        let mut flat = tilted.clone();
        (1..=3).for_each(|row| flat.set(flat.index(&format!("scan-tilt.piston[{row}]")).unwrap(), 0.0));
        assert_eq!(with[pass].surface.reported(&flat).unwrap(), plain[pass].scan);
    }
    let mut grown = tilted.clone();
    grown.set(grown.index("height-gain.gain").unwrap(), 0.01);
    let again = run(&grown);
    for (seen, simulated) in with.iter().zip(&again) {
        assert_eq!(seen.surface.reported(&grown).unwrap(), simulated.scan);
    }
}
