//! Runs that are killed, and runs that write to the same place.

#[cfg(unix)]
use std::path::Path;
#[cfg(unix)]
use std::process::Command;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::program::{asset, bracket, files, names, robofin, run, weld_bracket};

#[test]
fn two_runs_at_once_leave_one_whole_asset() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("asset");
    let (one, two) = std::thread::scope(|scope| {
        let other = scope.spawn(|| run(&mut weld_bracket(&out)));
        (run(&mut weld_bracket(&out)), other.join().expect("no panic"))
    });
    let codes = [&one, &two].map(|outcome| outcome.status.code());
    assert!(codes.contains(&Some(0)), "{} {}", one.stderr, two.stderr);
    for outcome in [one, two].iter().filter(|outcome| outcome.status.code() != Some(0)) {
        let code = outcome.status.code().expect("it was not killed");
        outcome.is_refused(code, &["asset"]);
    }
    assert_eq!(names(folder.path()), ["asset"], "nothing is left over");
    assert!(files(&out) == files(asset()), "it is whole");
}

#[test]
fn a_killed_run_leaves_nothing_under_the_final_name() {
    // A picture, a field and a folder take long enough here to be interrupted.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("asset");
    let mut unfinished = 0;
    for delay in [30, 100, 300, 600, 900, 1200] {
        let mut command = robofin(["weld", "--seed", "7", "--usd", "off", "--resolution", "128"]);
        command.arg(bracket()).arg("--out").arg(&out).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the program can be started");
        sleep(Duration::from_millis(delay));
        child.kill().expect("the program can be killed");
        let finished = child.wait().expect("the program ends").success();
        assert_eq!(out.exists(), finished, "after {delay} ms");
        let left = names(folder.path());
        for name in left.iter().filter(|name| *name != "asset") {
            assert!(name.starts_with(".asset.part-"), "{left:?}");
            std::fs::remove_dir_all(folder.path().join(name)).expect("it can be removed");
        }
        unfinished += usize::from(!finished);
        if finished {
            break;
        }
    }
    assert!(unfinished > 0, "all runs were finished before they were killed");
}

/// Sends a signal to a run once it has begun to write; returns its exit code and the files that remain.
#[cfg(unix)]
fn signalled(command: &mut Command, (signal, folder): (&str, &Path)) -> (Option<i32>, Vec<String>) {
    let before = names(folder);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program can be started");
    let started = Instant::now();
    while names(folder) == before && started.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(1));
    }
    assert_ne!(names(folder), before, "nothing was begun");
    let sent = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().expect("kill can be run");
    assert!(sent.success());
    let code = child.wait().expect("the program ends").code();
    (code, names(folder))
}

#[cfg(unix)]
#[test]
fn a_signal_ends_a_run_with_its_number_and_leaves_nothing() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let flags = ["--usd", "off", "--resolution", "256"];
    for (signal, code) in [("INT", 130), ("TERM", 143), ("HUP", 129)] {
        let mut weld = robofin(["weld", "--seed", "7"]);
        weld.args(flags).arg(bracket()).arg("--out").arg(place("asset"));
        assert_eq!(signalled(&mut weld, (signal, folder.path())), (Some(code), Vec::new()), "weld, {signal}");
    }
    run(robofin(["trial", "synth", "--size", "small", "--out"]).arg(place("trials"))).succeeds();
    for verb in ["compare", "calibrate", "study"] {
        let mut command = robofin([verb]);
        command.arg(place("trials")).arg("--out").arg(place("result"));
        let ended = signalled(&mut command, ("TERM", folder.path()));
        assert_eq!(ended, (Some(143), vec!["trials".to_owned()]), "{verb}");
    }
    let mut bake = robofin(["bake", "--resolution", "512"]);
    bake.arg(bracket()).arg("--out").arg(place("field.nvdb"));
    assert_eq!(signalled(&mut bake, ("INT", folder.path())), (Some(130), vec!["trials".to_owned()]), "bake");
}

#[test]
fn a_study_that_was_killed_goes_on_and_ends_with_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    run(robofin(["trial", "synth", "--plan", "paper", "--size", "small", "--out"]).arg(place("trials"))).succeeds();
    let step = |out: &str| {
        let mut command = robofin(["study", "--step"]);
        command.arg(place("trials")).arg("--out").arg(place(out));
        command
    };
    // The first step compares, the second fits.
    let _ = ["killed", "whole"].map(|out| run(&mut step(out)).succeeds());
    let before = files(&place("killed"));
    let kept = place("killed.unfinished").join("simulations.bin");
    for least in [1, 20_000] {
        let mut child = step("killed").stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it can be started");
        let started = Instant::now();
        while std::fs::metadata(&kept).map_or(0, |file| file.len()) < least
            && child.try_wait().expect("it can be waited for").is_none()
            && started.elapsed() < Duration::from_secs(120)
        {
            sleep(Duration::from_millis(5));
        }
        child.kill().expect("the program can be killed");
        assert!(!child.wait().expect("the program ends").success(), "it ended before it was killed");
        assert!(files(&place("killed")) == before, "what was finished before is kept");
    }
    let resumed = run(&mut step("killed")).succeeds();
    assert!(resumed.stderr.contains("predictions of an interrupted run"), "{}", resumed.stderr);
    run(&mut step("whole")).succeeds();
    assert!(files(&place("killed")) == files(&place("whole")), "the bytes differ");
    assert_eq!(names(folder.path()), ["killed", "trials", "whole"], "nothing is left over");
}

#[cfg(unix)]
#[test]
fn a_run_for_a_place_that_another_run_writes_ends_before_its_work() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("asset");
    let mut first = robofin(["weld", "--seed", "7", "--usd", "off", "--resolution", "256"]);
    first.arg(bracket()).arg("--out").arg(&out).stdout(Stdio::null()).stderr(Stdio::null());
    let mut first = first.spawn().expect("the program can be started");
    let started = Instant::now();
    while names(folder.path()).is_empty() && started.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(1));
    }
    let second = run(weld_bracket(&out).arg("--force"));
    second.is_refused(1, &["asset", "another run is writing"]);
    assert!(!second.stderr.contains("winding number"), "it was baked in vain: {}", second.stderr);
    first.kill().expect("the program can be killed");
    first.wait().expect("the program ends");
}

#[test]
fn what_a_killed_run_left_does_not_stop_the_next() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("asset");
    let mut command = weld_bracket(&out);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program can be started");
    let started = Instant::now();
    while names(folder.path()).is_empty() && started.elapsed() < Duration::from_secs(60) {
        sleep(Duration::from_millis(1));
    }
    child.kill().expect("the program can be killed");
    child.wait().expect("the program ends");
    let left = names(folder.path());
    assert!(left.len() == 1 && left[0].starts_with(".asset.part-"), "{left:?}");
    run(&mut weld_bracket(&out)).succeeds();
    assert!(files(&out) == files(asset()), "it is whole");
    assert_eq!(names(folder.path()), ["asset"], "what the killed run left is gone");
}
