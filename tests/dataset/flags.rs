//! Wrong use is reported before any work.

use std::fs;
use std::path::Path;

use crate::program::{bracket, names, run};
use crate::set::{dataset, plates, tree, undisturbed};

#[test]
fn nonsense_is_refused_with_what_would_be_accepted() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (plates(place.path()), place.path().join("set"));
    for (flag, values, words) in [
        ("--shard", &["0/3", "4/3", "1/0", "half", "-1/2", ""][..], "i/n"),
        ("--jobs", &["0", "257"], "1 to 256"),
        ("--limit", &["0"], "1 or more"),
        ("--time-limit", &["0", "-1", "nan", "1e9"], "accepted"),
        ("--memory-limit", &["0", "-1", "inf"], "accepted"),
        ("--diagonal", &["7", "5000"], "8 to 4096"),
        ("--min-exposure", &["1.5"], "0 to 1"),
        ("--shell-mm", &["1"], "robofin bake"),
    ] {
        for value in values {
            let mut command = crate::program::robofin(["dataset"]);
            let told = run(command.arg(&parts).arg("--out").arg(&out).arg(format!("{flag}={value}")));
            told.is_refused(2, &[flag, words]);
        }
    }
    for (flag, value) in [("--per-part", "0"), ("--per-part", "-3"), ("--item", "10000"), ("--seed", "many")] {
        let mut command = crate::program::robofin(["dataset"]);
        run(command.arg(&parts).arg("--out").arg(&out).args([flag, value])).is_refused(2, &[flag]);
    }
    assert_eq!(names(place.path()), ["parts"]);
}

#[test]
fn folders_that_are_missing_or_hold_no_mesh_are_named() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (empty, out) = (place.path().join("empty"), place.path().join("set"));
    fs::create_dir(&empty).expect("a folder");
    run(&mut dataset(&place.path().join("absent"), &out)).is_refused(2, &["absent", "no such file or folder"]);
    run(&mut dataset(&empty, &out)).is_refused(2, &["empty", "without a mesh file"]);
    assert_eq!(names(place.path()), ["empty"]);
}

#[test]
fn what_is_there_is_kept_unless_it_is_the_same_set() {
    let (parts, set) = undisturbed();
    let before = tree(set);
    run(&mut dataset(parts, set)).is_refused(2, &["is a data set already", "--resume"]);
    let mut other =
        crate::program::robofin(["dataset", "--per-part", "2", "--seed", "8", "--diagonal", "48", "--resume"]);
    run(other.arg(parts).arg("--out").arg(set))
        .is_refused(2, &["was started with other flags", "seed is 7 there, and 8 now"]);
    let mut other =
        crate::program::robofin(["dataset", "--per-part", "2", "--seed", "7", "--diagonal", "49", "--resume"]);
    run(other.arg(parts).arg("--out").arg(set)).is_refused(2, &["was started with other flags", "options"]);
    assert!(tree(set) == before, "it was changed");

    let place = tempfile::tempdir().expect("a temporary folder");
    fs::write(place.path().join("thesis.txt"), "years of work").expect("written");
    for more in [&[][..], &["--resume"]] {
        run(dataset(parts, place.path()).args(more)).is_refused(2, &["dataset.json", "not a data set"]);
    }
    assert_eq!(names(place.path()), ["thesis.txt"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_place_that_cannot_be_written_is_named_before_the_work() {
    let (parts, _) = undisturbed();
    for out in [Path::new("/proc/set"), &bracket().join("set")] {
        let told = run(&mut dataset(parts, out));
        told.is_refused(1, &["cannot make this folder", "set"]);
        assert!(told.stdout.is_empty(), "{}", told.stdout);
    }
}
