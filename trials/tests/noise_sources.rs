//! The noise of trials without a repeated scan, compared with that of their repeated scans.

#[path = "../../tests/common/shared_folder.rs"]
mod shared_folder;

use std::path::{Path, PathBuf};

use shared_folder::shared;
use trials::measure::{NoiseSource, ScanNoise};
use trials::trial::{Campaign, Trial};

/// Campaigns with ground surfaces: the bundled one and those of another laboratory.
fn campaigns() -> Vec<Campaign> {
    let bundled = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/campaigns/first-look");
    let foreign = shared("campaigns").into_iter().flat_map(|folder| ["open-a", "open-e"].map(|name| folder.join(name)));
    let places: Vec<PathBuf> = std::iter::once(bundled).chain(foreign).collect();
    let read = |place: &PathBuf| Campaign::read(place).unwrap_or_else(|error| panic!("{error}"));
    places.iter().map(read).collect()
}

fn without_repeats(trials: &[Trial], which: impl Fn(usize) -> bool) -> Vec<Trial> {
    let mut trials = trials.to_vec();
    trials.iter_mut().enumerate().filter(|(k, _)| which(*k)).for_each(|(_, trial)| trial.scans.repeats.clear());
    trials
}

fn noise(trials: &[Trial]) -> Vec<ScanNoise> {
    ScanNoise::of_campaign(trials).expect("the noise of every trial")
}

#[test]
fn what_no_tool_touched_shows_the_noise_of_a_repeated_scan() {
    let (mut worst, mut count) = (0f64, 0);
    for campaign in campaigns() {
        let (known, seen) = (noise(&campaign.trials), noise(&without_repeats(&campaign.trials, |_| true)));
        for (known, seen) in known.iter().zip(&seen) {
            let ratio = seen.floor.sigma / known.floor.sigma;
            println!("{:?}: {:.3} of {:.2} µm by {:?}", campaign.folder, ratio, 1e6 * known.floor.sigma, seen.source);
            assert_eq!(known.source, NoiseSource::Repeat);
            assert!(seen.source.is_lower_bound());
            worst = worst.max((ratio - 1.0).abs());
            count += 1;
        }
    }
    println!("{count} trials, off by at most {:.1} %", 100.0 * worst);
    assert!(count >= 3 && worst < 0.25, "off by {worst}");
}

#[test]
fn a_trial_takes_the_noise_of_another_on_its_own_pixels() {
    for campaign in campaigns().into_iter().filter(|campaign| campaign.trials.len() > 1) {
        let last = campaign.trials.len() - 1;
        let mut trials = without_repeats(&campaign.trials, |k| k == last);
        let all = noise(&trials);
        assert_eq!(all[last].source, NoiseSource::OtherTrial(trials[0].name.clone()));
        assert_eq!(all[last].left.pixels, all[0].left.pixels);
        assert!(all[last].left.heights.iter().zip(&all[0].left.heights).all(|(a, b)| a.to_bits() == b.to_bits()));
        let before = &mut trials[last].scans.before;
        (before.pixels.nx, before.heights) = (before.pixels.nx - 1, vec![0.0; before.heights.len() - before.pixels.ny]);
        let narrower = &noise(&trials)[last].left;
        assert_eq!(narrower.pixels, trials[last].scans.before.pixels);
        assert_eq!(narrower.height(3, 5).to_bits(), all[0].left.height(3, 5).to_bits());
    }
}

#[test]
fn one_scan_alone_shows_noise_and_texture() {
    for campaign in campaigns() {
        let known = noise(&campaign.trials);
        let mut alone = without_repeats(&campaign.trials, |_| true);
        alone.iter_mut().for_each(|trial| trial.passes.clear());
        for (known, alone) in known.iter().zip(noise(&alone)) {
            let share = alone.floor.sigma / known.floor.sigma;
            println!("{:?}: {share:.3} of {:.2} µm", campaign.folder, 1e6 * known.floor.sigma);
            assert_eq!(alone.source, NoiseSource::OneScan);
            // The plates of open-e have the texture of a real surface.
            let most = if campaign.folder.ends_with("open-e") { f64::INFINITY } else { 1.05 };
            assert!((0.6..most).contains(&share), "{share}");
        }
    }
}
