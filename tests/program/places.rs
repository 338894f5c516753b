//! Output paths: nothing is overwritten, nothing incomplete is left.

use std::fs;
use std::path::Path;

use crate::program::{asset, bracket, copy_of_asset, files, names, robofin, run, weld_bracket};

#[test]
fn a_folder_that_is_there_is_kept() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let copy = copy_of_asset(folder.path());
    let before = files(&copy);
    let outcome = run(&mut weld_bracket(&copy));
    outcome.is_refused(2, &["asset", "already exists", "--force"]);
    assert!(files(&copy) == before, "it was changed");

    let file = folder.path().join("file");
    fs::write(&file, "mine").expect("it can be written");
    run(&mut weld_bracket(&file)).is_refused(2, &["file", "already exists"]);
    for verb in ["simulate", "render"] {
        run(robofin([verb]).arg(asset()).arg("--out").arg(&file)).is_refused(2, &["file", "already exists"]);
    }
    run(robofin(["bake"]).arg(bracket()).arg("--out").arg(&file)).is_refused(2, &["file", "already exists"]);
    run(robofin(["demo", "--out"]).arg(&copy)).is_refused(2, &["asset", "already exists"]);
    assert_eq!(fs::read(&file).expect("it is there"), b"mine");
    assert_eq!(names(folder.path()), ["asset", "file"]);
}

#[test]
fn force_replaces_what_is_ours_and_nothing_else() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let copy = copy_of_asset(folder.path());
    fs::write(copy.join("welds.json"), "damaged").expect("it can be written");
    run(weld_bracket(&copy).arg("--force")).succeeds();
    assert!(files(&copy) == files(asset()), "it is new");

    fs::create_dir(place("thesis")).expect("it can be made");
    fs::write(place("thesis/chapter-1.txt"), "years of work").expect("it can be written");
    run(weld_bracket(&place("thesis")).arg("--force")).is_refused(2, &["thesis", "asset.json", "not a result"]);
    for out in ["thesis", "asset"] {
        let simulate = &mut robofin(["simulate", "--force"]);
        run(simulate.arg(asset()).arg("--out").arg(place(out))).is_refused(2, &[out, "grind.json", "not a result"]);
        let render = &mut robofin(["render", "--force", "--size", "16x16"]);
        run(render.arg(asset()).arg("--out").arg(place(out))).is_refused(2, &[out, "render.json", "not a result"]);
        let bake = &mut robofin(["bake", "--force"]);
        run(bake.arg(bracket()).arg("--out").arg(place(out))).is_refused(2, &[out, "is a folder", "a file"]);
    }
    assert_eq!(names(&place("thesis")), ["chapter-1.txt"]);
    assert_eq!(names(folder.path()), ["asset", "thesis"]);
}

#[cfg(target_os = "linux")]
#[test]
fn places_that_cannot_be_written_are_named_before_the_work() {
    let file = bracket().join("asset");
    for out in [Path::new("/proc/robofin/out"), Path::new("/proc/out"), file.as_path()] {
        let outcome = run(&mut weld_bracket(out));
        outcome.is_refused(1, &["cannot"]);
        assert!(!outcome.stderr.contains("winding number"), "it was baked in vain: {}", outcome.stderr);
        let outcome = run(robofin(["simulate"]).arg(asset()).arg("--out").arg(out));
        outcome.is_refused(1, &["cannot"]);
        assert!(!outcome.stderr.contains("pass 1"), "it was ground in vain: {}", outcome.stderr);
        for verb in ["bake", "render"] {
            let source = if verb == "render" { asset().to_owned() } else { bracket() };
            run(robofin([verb]).arg(source).arg("--out").arg(out)).is_refused(1, &["cannot"]);
        }
    }
    for out in ["/proc/robofin/out", "/proc/out"] {
        let outcome = run(robofin(["trial", "synth", "--size", "small", "--out", out]).arg("--sealed"));
        outcome.is_refused(1, &["cannot"]);
        assert!(!outcome.stderr.contains("measured"), "it was simulated in vain: {}", outcome.stderr);
        let render = &mut robofin(["render", "--out", &format!("{out}.png")]);
        let outcome = run(render.arg(folder_without_asset()));
        outcome.is_refused(1, &["/proc", "cannot"]);
    }
    run(&mut weld_bracket(Path::new("/"))).is_refused(2, &["already exists"]);
}

/// Returns a source that cannot be drawn; an error that names it shows that the work has begun.
#[cfg(target_os = "linux")]
fn folder_without_asset() -> &'static Path {
    Path::new("/dev")
}

#[test]
fn missing_parents_are_made() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let deep = folder.path().join("a/b/c");
    run(robofin(["bake", "--resolution", "32"]).arg(bracket()).arg("--out").arg(deep.join("phi.nvdb"))).succeeds();
    assert_eq!(names(&deep), ["phi.nvdb"]);
}
