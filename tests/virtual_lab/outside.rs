//! Unlisted effects, and faults of the scanner.

use std::fs;
use std::path::Path;

use effects::{Library, Process, check_file};
use trials::measure::untouched;
use trials::trial::Trial;
use virtual_lab::outside::EFFECTS;
use virtual_lab::{Choice, Experiment, Hidden};

use crate::made::{clean, experiment, heights};

#[test]
fn every_file_outside_the_library_is_good_listed_and_unknown_to_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("virtual-lab/src/outside");
    let mut files: Vec<String> =
        fs::read_dir(folder).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    assert_eq!(files, EFFECTS.iter().map(|(file, _)| (*file).to_owned()).collect::<Vec<_>>());
    let mut counts = [0; 2];
    for (file, text) in EFFECTS {
        let effect = check_file(file, text).unwrap();
        assert_eq!(format!("{}.toml", effect.name), **file);
        assert!(Library::builtin().find(&effect.name).is_none());
        for (count, process) in counts.iter_mut().zip(Process::ALL) {
            *count += usize::from(effect.acts_in(process));
        }
    }
    assert!(counts[0] >= 6 && counts[1] >= 5, "{counts:?}");
}

/// Returns the root mean square change of the last scan by an effect [m], where the tool was and where it never was.
/// The noise is the same, so it cancels.
fn changed(trial: &Trial) -> (f64, f64) {
    let plain = &clean().trials[0];
    let mut free = vec![true; plain.scans.before.heights.len()];
    for pass in &plain.passes {
        let alone = untouched(&plain.scans.before, &pass.tool_path(&plain.tool), &plain.tool, 0.3e-3);
        free.iter_mut().zip(alone).for_each(|(free, alone)| *free &= alone);
    }
    let pairs = heights(trial, 1).heights.iter().zip(&heights(plain, 1).heights);
    let mut sums = [(0.0, 0.0); 2];
    for (difference, free) in pairs.map(|(a, b)| a - b).zip(free).filter(|(d, _)| d.is_finite()) {
        let (sum, count) = &mut sums[usize::from(free)];
        (*sum, *count) = (*sum + difference * difference, *count + 1.0);
    }
    let rms = |(sum, count): (f64, f64)| f64::sqrt(sum / count);
    (rms(sums[0]), rms(sums[1]))
}

#[test]
fn hidden_effects_show_where_they_act() {
    for (name, everywhere) in [
        ("spatter-patch", false),
        ("grit-loss", false),
        ("axis-wander", false),
        ("thermal-stiffness", false),
        ("stick-slip", false),
        ("plate-warping", true),
        ("stitching", true),
        ("height-gain", true),
    ] {
        let made = experiment(Process::Grinding, &[Hidden::effect(name)]).make().unwrap();
        let (touched, free) = changed(&made.trials[0]);
        println!("{name}: {:.1} µm where the tool was, {:.2} µm elsewhere", touched * 1e6, free * 1e6);
        assert!(touched > 2e-6, "{name}: {touched}");
        assert_eq!(free > 1.5e-6, everywhere, "{name}: {free}");
        let known = Library::builtin().find(name).is_some();
        assert_eq!((made.answer.effects[0].name.as_str(), made.answer.effects[0].in_library), (name, known));
    }
}

#[test]
fn drawn_experiments_hide_all_kinds_of_things_and_the_library_may_grow() {
    let own = "name = \"my-own\"\n[parameters.a]\nunit = \"1\"\nnull = 0.0\nrange = [0.0, 1.0]\n[modify]\nrate = \"rate * (1 - a)\"\n";
    let library = Library::builtin().with(&[("my-own.toml".to_owned(), own.to_owned())]).unwrap();
    let base = Experiment::new(Process::Grinding, &library, 0).unwrap();
    let names = |seed: u64| {
        let drawn = Experiment { choice: Choice::Drawn, seed, ..base.clone() };
        let effects: Vec<_> = drawn.hidden_effects().unwrap();
        effects
    };
    let drawn: Vec<Vec<String>> = (0..60).map(names).collect();
    let outside = |name: &&String| EFFECTS.iter().any(|(file, _)| file.strip_suffix(".toml") == Some(name.as_str()));
    let nothing = drawn.iter().filter(|names| names.is_empty()).count();
    let unknown = drawn.iter().flatten().filter(outside).count();
    let mut different: Vec<&String> = drawn.iter().flatten().collect();
    different.sort();
    different.dedup();
    println!("of 60: nothing in {nothing}, {unknown} outside the library, {} different", different.len());
    assert!((2..25).contains(&nothing) && (2..25).contains(&unknown) && different.len() > 15);
    let mine = Experiment { choice: Choice::These(vec![Hidden::effect("my-own")]), ..base };
    assert_eq!(mine.hidden_effects().unwrap(), ["my-own"]);
}
