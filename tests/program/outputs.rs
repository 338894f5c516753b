//! Outputs that `--force` may replace: results of the same command, and nothing else, least of all an input.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use crate::program::{asset, bracket, copy_of_asset, files, names, robofin, run, weld_bracket};

/// Asserts that a command with `--force` is refused with these words and leaves `kept` unchanged.
#[track_caller]
fn assert_kept(words: &[&dyn AsRef<OsStr>], kept: &Path, said: &[&str]) {
    let before = fs::read(kept).expect("a file");
    let folder = kept.parent().expect("a folder");
    let there = names(folder);
    let mut command = robofin(words.iter().map(AsRef::as_ref));
    run(command.arg("--force")).is_refused(2, said);
    assert!(fs::read(kept).expect("it is still there") == before, "{} was changed", kept.display());
    assert_eq!(names(folder), there);
}

#[test]
fn force_never_replaces_an_input() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let part = place("part.obj");
    fs::copy(bracket(), &part).expect("a part");
    fs::hard_link(&part, place("hard.obj")).expect("a link");
    fs::create_dir(place("below")).expect("a folder");
    let mut outs = vec![part.clone(), place("hard.obj"), place("below/../part.obj"), folder.path().to_owned()];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&part, place("soft.obj")).expect("a link");
        std::os::unix::fs::symlink(folder.path(), place("round")).expect("a link");
        outs.extend([place("soft.obj"), place("round/part.obj")]);
    }
    for out in &outs {
        for verb in ["weld", "bake"] {
            assert_kept(&[&verb, &part, &"--out", out], &part, &["the input", "part.obj"]);
        }
    }
}

#[test]
fn force_never_replaces_a_file_that_the_command_does_not_write() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let copy = copy_of_asset(folder.path());
    let notes = place("notes.txt");
    fs::write(&notes, "years of work").expect("it can be written");
    for verb in ["compare", "calibrate", "diagnose", "study", "simulate", "weld"] {
        assert_kept(&[&verb, &copy, &"--out", &notes], &notes, &["notes.txt", "is a file"]);
    }
    assert_kept(&[&"trial", &"synth", &"--out", &notes], &notes, &["notes.txt", "is a file"]);
    let picture = place("holiday.png");
    let other = [&[0x89][..], b"PNG\r\n\x1a\n", &[0; 40]].concat();
    fs::write(&picture, other).expect("it can be written");
    let not_ours = "not";
    for out in [&notes, &picture] {
        assert_kept(&[&"bake", &bracket(), &"--out", out], out, &[not_ours, "a field"]);
        assert_kept(&[&"path", &copy, &"--out", out], out, &[not_ours, "a planned path"]);
    }
    assert_kept(&[&"render", &copy, &"--out", &picture], &picture, &[not_ours, "a picture"]);
    for file in ["welds.json", "preview.png", "phi.nvdb"] {
        let file = copy.join(file);
        assert_kept(&[&"path", &copy, &"--out", &file], &file, &["lies in the input"]);
        assert_kept(&[&"bake", &bracket(), &"--out", &file], &file, &["does not replace"]);
    }
    let measured = place("pass1_log.csv");
    let rows = "t_s,x_mm,y_mm,z_mm,force_n,spindle_rpm\n0,0,0,0,14.9,6001\n0.1,1,0,0,15.2,5998\n";
    fs::write(&measured, rows).expect("it can be written");
    assert_kept(&[&"path", &copy, &"--out", &measured], &measured, &["a planned path"]);
    fs::write(place("trials.key"), "my only house key").expect("it can be written");
    let synth: [&dyn AsRef<OsStr>; 5] = [&"trial", &"synth", &"--sealed", &"--out", &place("trials")];
    assert_kept(&synth, &place("trials.key"), &["trials.key", "a key"]);
    let bench: [&dyn AsRef<OsStr>; 4] = [&"bench", &"diagnose", &"--out", &folder.path()];
    run(&mut robofin(bench.iter().map(AsRef::as_ref))).is_refused(2, &["asset", "does not write"]);
}

#[test]
fn force_replaces_what_the_command_wrote_itself() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    for again in [&[][..], &["--force"]] {
        run(robofin(["bake", "--resolution", "32"]).args(again).arg(bracket()).arg("--out").arg(place("field.nvdb")))
            .succeeds();
        run(robofin(["path"]).args(again).arg(asset()).arg("--out").arg(place("plan.csv"))).succeeds();
        run(robofin(["render", "--size", "32x32"]).args(again).arg(asset()).arg("--out").arg(place("view.png")))
            .succeeds();
        run(robofin(["render", "--size", "32x32"]).args(again).arg(asset()).arg("--out").arg(place("photo")))
            .succeeds();
    }
    assert_eq!(names(folder.path()), ["field.nvdb", "photo", "plan.csv", "view.png"]);
}

#[test]
fn a_result_with_a_file_of_the_users_in_it_is_kept() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let copy = copy_of_asset(folder.path());
    fs::write(copy.join("thesis.txt"), "years of work").expect("it can be written");
    let before = files(&copy);
    run(weld_bracket(&copy).arg("--force")).is_refused(2, &["asset", "thesis.txt", "does not write"]);
    assert!(files(&copy) == before, "it was changed");
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_no_outputs() {
    use std::os::unix::fs::FileTypeExt;
    for verb in ["weld", "bake"] {
        let outcome = run(robofin([verb, "--force"]).arg(bracket()).args(["--out", "/dev/null"]));
        outcome.is_refused(2, &["/dev/null"]);
    }
    assert!(fs::metadata("/dev/null").expect("it is there").file_type().is_char_device());
}
