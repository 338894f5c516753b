//! Experiments shared by tests, and properties of every experiment.

use std::fs;
use std::sync::LazyLock;

use effects::{Library, Process};
use sdf_bake::HeightMap;
use trials::trial::{Campaign, PassScan, Role, Trial};
use virtual_lab::write::write;
use virtual_lab::{Choice, Experiment, Hidden, Made, Plan, Size};

/// Makes a small experiment of one trial of two equal passes.
pub(crate) fn experiment(process: Process, hidden: &[Hidden]) -> Experiment {
    let base = Experiment::new(process, Library::builtin(), 11).unwrap();
    Experiment { plan: Plan::Paper, trials: 1, size: Size::Small, choice: Choice::These(hidden.to_vec()), ..base }
}

/// Returns grinding without hidden effects.
pub(crate) fn clean() -> &'static Made {
    static CLEAN: LazyLock<Made> = LazyLock::new(|| experiment(Process::Grinding, &[]).make().unwrap());
    &CLEAN
}

/// Returns the heights after a pass.
pub(crate) fn heights(trial: &Trial, pass: usize) -> &HeightMap {
    match &trial.passes[pass].scan {
        PassScan::Heights(map) => map,
        PassScan::Exposure(_) => panic!("heights are expected"),
    }
}

fn same_heights(a: &HeightMap, b: &HeightMap) -> bool {
    let same = |(a, b): (&f64, &f64)| (a.is_nan() && b.is_nan()) || (a - b).abs() < 1e-9;
    a.heights.len() == b.heights.len() && a.heights.iter().zip(&b.heights).all(same)
}

#[test]
fn campaigns_are_read_as_they_were_made() {
    for process in [Process::Grinding, Process::Sanding] {
        let experiment = Experiment { plan: Plan::Varied, trials: 2, ..experiment(process, &[]) };
        let made = experiment.make().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("campaign");
        write(&made, &experiment, &place, None, false).unwrap();
        let read = Campaign::read(&place).unwrap();
        assert_eq!(read.trials.len(), 2);
        for (trial, made) in read.trials.iter().zip(&made.trials) {
            assert_eq!(trial.notes, Vec::<String>::new());
            assert_eq!((&trial.name, &trial.tool, trial.controller), (&made.name, &made.tool, made.controller));
            assert!(same_heights(&trial.scans.before, &made.scans.before));
            assert!(!same_heights(&trial.scans.before, &trial.scans.repeats[0]));
            for (pass, made) in trial.passes.iter().zip(&made.passes) {
                let path = pass.tool_path(&trial.tool);
                let contact = path.contact.expect("a contact");
                let air = (contact.start, path.duration() - contact.end);
                println!("{} {:.2} s, contact from {:.2} s, {:.2} s of air", trial.name, path.duration(), air.0, air.1);
                assert!(air.0 > 0.1 && air.1 > 0.1, "{contact:?}");
                assert!((path.feed / made.feed - 1.0).abs() < 0.05, "{} for {}", path.feed, made.feed);
                match (&pass.scan, &made.scan) {
                    (PassScan::Heights(a), PassScan::Heights(b)) => assert!(same_heights(a, b)),
                    (a, b) => assert_eq!(a, b),
                }
            }
        }
        let roles: Vec<Role> = read.trials.iter().flat_map(|trial| &trial.passes).map(|pass| pass.role).collect();
        assert_eq!(roles, [Role::Calibration, Role::Calibration, Role::Evaluation, Role::Evaluation]);
        let truth = &made.answer.trials["trial-2"];
        assert_eq!(truth.removed_by_law_mm3.len() + truth.exposed_share.len(), 2);
        assert!(truth.removed_by_law_mm3.iter().all(|volume| *volume > 5.0), "{truth:?}");
        assert!(truth.exposed_share.iter().all(|share| (0.02..0.8).contains(share)), "{truth:?}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes_on_any_number_of_threads() {
    let experiment = Experiment { trials: 2, ..experiment(Process::Grinding, &[Hidden::effect("pass-gain")]) };
    let folder = tempfile::tempdir().unwrap();
    let made = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let made = pool.install(|| experiment.make()).unwrap();
        let place = folder.path().join(threads.to_string());
        write(&made, &experiment, &place, None, false).unwrap();
        let mut files: Vec<_> = fs::read_dir(place.join("trial-2")).unwrap().map(|file| file.unwrap().path()).collect();
        files.sort();
        files.push(place.join("answers.json"));
        files.into_iter().map(|file| fs::read(file).unwrap()).collect::<Vec<_>>()
    };
    let (one, two) = (made(1), made(2));
    assert!(one.len() >= 8 && one == two);
    let other = Experiment { seed: 12, ..experiment.clone() }.make().unwrap();
    let same = experiment.make().unwrap();
    assert!(!same_heights(&other.trials[0].scans.before, &same.trials[0].scans.before));
    assert_ne!(other.answer.base, same.answer.base);
    // Each pass has a gain of its own.
    let gains = &same.answer.effects[0].parameters["gain"].values;
    assert!(gains.len() == 4 && gains[0] != gains[1], "{gains:?}");
}
