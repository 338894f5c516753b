//! Campaigns made by another laboratory's simulation.

use std::path::PathBuf;
use std::time::Instant;

use effects::Process;
use robot::{Controller, Tool};
use trials::trial::{Campaign, PassScan};

use crate::shared_folder::shared;

/// Returns the shared campaigns, if they exist.
pub(crate) fn campaigns() -> Option<PathBuf> {
    shared("campaigns")
}

#[test]
fn shared_campaigns_are_read_completely() {
    let Some(place) = campaigns() else { return };
    for (name, process, trials, passes) in [
        ("open-a", Process::Grinding, 4, 8),
        ("open-b", Process::Grinding, 4, 8),
        ("open-c", Process::Grinding, 1, 2),
        ("open-d", Process::Sanding, 4, 8),
    ] {
        let started = Instant::now();
        let campaign = Campaign::read(&place.join(name)).unwrap();
        println!("{name}: {} trials in {:.1?}", campaign.trials.len(), started.elapsed());
        assert_eq!(campaign.trials.len(), trials);
        assert_eq!(campaign.trials.iter().map(|trial| trial.passes.len()).sum::<usize>(), passes);
        for trial in &campaign.trials {
            assert_eq!(trial.process, process);
            assert!(trial.notes.is_empty(), "{name}: {:?}", trial.notes);
            assert_eq!(trial.scans.repeats.len(), 1);
            for pass in &trial.passes {
                let path = pass.tool_path(&trial.tool);
                let contact = path.contact.expect("a contact");
                assert!(contact.end - contact.start > 0.8 * path.duration(), "{name}: {contact:?}");
                assert!((path.feed / pass.feed - 1.0).abs() < 0.02, "{name}: {} for {}", path.feed, pass.feed);
                match (&pass.scan, &trial.tool.shape) {
                    (PassScan::Heights(map), Tool::Wheel(_)) => assert_eq!(map.pixels, trial.scans.before.pixels),
                    (PassScan::Exposure(mask), Tool::Pad(_)) => assert_eq!(mask.pixels, trial.scans.before.pixels),
                    other => panic!("{name}: {other:?}"),
                }
            }
        }
        let admittance = matches!(campaign.trials[0].controller, Controller::Admittance { .. });
        assert_eq!(admittance, process == Process::Grinding);
    }
}
