//! Flags that make no sense: exit code 2 and the range, or exit code 1 where the part decides.

use crate::program::{bracket, names, robofin, run, weld_bracket};

fn bake() -> std::process::Command {
    let mut command = robofin(["bake"]);
    command.arg(bracket());
    command
}

#[test]
fn numbers_out_of_range_are_wrong_use_and_say_the_range() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    for (flag, values, words) in [
        ("--voxel-mm", &["0", "-1", "nan", "inf"][..], "above zero"),
        ("--resolution", &["0", "1", "7", "4097", "100000000"], "8 to 4096"),
        ("--band", &["1", "-3", "1000", "nan", "inf"], "2 to 64"),
        ("--threads", &["0", "1025", "100000"], "1 to 1024"),
    ] {
        for value in values {
            run(bake().args([flag, value]).arg("--out").arg(&out)).is_refused(2, &[flag, words]);
        }
    }
    for (flag, values, words) in [
        ("--length-mm", &["0", "-1", "nan", "inf"][..], "above zero"),
        ("--width-mm", &["0", "-1", "nan", "inf"], "above zero"),
        ("--height-mm", &["0", "-1", "nan", "inf"], "above zero"),
        ("--curvature-per-m", &["-1", "1e9", "nan", "inf"], "0.0 to 10000.0"),
        ("--min-exposure", &["2", "-0.5", "nan"], "0 to 1"),
        ("--exposure", &["0.5..2", "-0.5", "0.8..0.2", "0.1..", "a..b"], ""),
        ("--length-mm", &["80..40", "0..50", "40..inf"], ""),
        ("--curvature-max-per-m", &["-1", "nan"], "0.0 to 10000.0"),
        ("--min-access", &["2", "-1"], "0 to 1"),
        ("--count", &["0", "-1", "70000"], ""),
        ("--convexity", &["1", "nan"], "-0.2 to 0.25"),
        ("--crater", &["1", "-0.1"], "0.0 to 0.8"),
        ("--ripple-pitch-mm", &["0", "nan"], "above zero"),
    ] {
        for value in values {
            run(weld_bracket(&out).args([flag, value])).is_refused(2, &[flag, words]);
        }
    }
    run(weld_bracket(&out).args(["--stitch-mm", "20"])).is_refused(2, &["required arguments were not provided"]);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn what_is_no_number_names_the_flag_and_what_was_found() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    for (flag, value) in [
        ("--seed", "-1"),
        ("--seed", "18446744073709551616"),
        ("--seed", "seven"),
        ("--resolution", "-5"),
        ("--resolution", "99999999999"),
        ("--voxel-mm", "fine"),
        ("--threads", "-2"),
        ("--unit", "furlong"),
        ("--sign", "maybe"),
        ("--usd", "perhaps"),
    ] {
        let mut command = robofin(["weld", flag, value]);
        run(command.arg(bracket()).arg("--out").arg(&out)).is_refused(2, &[flag, value]);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn unknown_verbs_and_flags_are_wrong_use() {
    run(&mut robofin(["frobnicate"])).is_refused(2, &["frobnicate"]);
    run(&mut robofin(["weld", "--frobnicate"])).is_refused(2, &["--frobnicate"]);
    run(&mut robofin(["weld"])).is_refused(2, &["required"]);
    run(&mut robofin(["weld", "part.obj", "--out", ""])).is_refused(2, &["--out"]);
    run(&mut robofin(["weld", "part.obj", "--out", "x", "--voxel-mm", "1", "--resolution", "9"]))
        .is_refused(2, &["--voxel-mm", "--resolution"]);
    assert_eq!(run(&mut robofin::<&str>([])).status.code(), Some(2));
    for verb in [
        "demo",
        "weld",
        "bake",
        "simulate",
        "press",
        "render",
        "validate",
        "calibrate",
        "diagnose",
        "study",
        "effects",
        "backends",
    ] {
        let help = run(&mut robofin([verb, "--help"])).succeeds();
        assert!(help.stdout.contains("Usage: robofin"), "{}", help.stdout);
    }
}

#[test]
fn welds_that_fit_nowhere_name_the_dial_that_would_help() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    for (flag, value, words) in [
        ("--length-mm", "1e9", "shorter length"),
        ("--width-mm", "500", "narrower bead"),
        ("--height-mm", "500", "narrower bead"),
    ] {
        let reason = run(weld_bracket(&out).args([flag, value])).is_refused(1, &["no place for the weld", words]);
        assert!(reason.len() < 700, "{reason}");
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_bead_far_below_the_voxel_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    for flag in ["--length-mm", "--width-mm", "--height-mm"] {
        run(weld_bracket(&out).args([flag, "1e-9"]))
            .is_refused(1, &[flag, "voxel of 2.5000 mm", "or more is accepted"]);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_voxel_larger_than_the_part_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    run(bake().args(["--voxel-mm", "1e9"]).arg("--out").arg(&out)).is_refused(1, &["voxel"]);
    run(bake().args(["--voxel-mm", "1e300"]).arg("--out").arg(&out)).is_refused(1, &["voxel"]);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}
