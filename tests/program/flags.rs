//! Invalid flags: exit code 2 with the accepted range, or exit code 1 if it depends on the part.

use crate::program::{asset, bracket, names, robofin, run, weld_bracket};

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
        ("--curvature-per-m", &["-1", "1e9", "nan", "inf"], "0 to 10000"),
        ("--min-exposure", &["2", "-0.5", "nan"], "0 to 1"),
        ("--exposure", &["0.5..2", "-0.5", "0.8..0.2", "0.1..", "a..b"], ""),
        ("--length-mm", &["80..40", "0..50", "40..inf"], ""),
        ("--curvature-max-per-m", &["-1", "nan"], "0 to 10000"),
        ("--min-access", &["2", "-1"], "0 to 1"),
        ("--count", &["0", "-1", "70000"], ""),
        ("--convexity", &["1", "nan"], "-0.2 to 0.25"),
        ("--crater", &["1", "-0.1"], "0 to 0.8"),
        ("--ripple-pitch-mm", &["0", "nan"], "above zero"),
    ] {
        for value in values {
            run(weld_bracket(&out).args([flag, value])).is_refused(2, &[flag, words]);
        }
    }
    run(weld_bracket(&out).args(["--stitch-mm", "20"])).is_refused(2, &["required"]);
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

/// Arguments of a command line, and words of each fault that its refusal must report.
type Refusal<'a> = (&'a [&'a str], &'a [&'a [&'a str]]);

#[test]
fn all_wrong_flags_of_a_verb_are_reported_at_once_with_value_and_range() {
    let refusals: [Refusal; 14] = [
        (
            &[
                "weld",
                "no.obj",
                "--out",
                "o",
                "--voxel-mm",
                "0",
                "--band=1",
                "--length-mm",
                "80..40",
                "--crater",
                "deep",
            ],
            &[
                &["--voxel-mm 0:", "above zero"],
                &["--band 1:", "2 to 64"],
                &["--length-mm 80..40:", "80 is above 40"],
                &["--crater deep:", "such as 0.5", "0 to 0.8"],
            ],
        ),
        (
            &["bake", "no.obj", "--out", "o", "--band", "1000", "--resolution", "7", "--jobs", "0", "--unit", "ell"],
            &[&["--band", "2 to 64"], &["--resolution", "8 to 4096"], &["--jobs", "1 to 256"], &["--unit", "m or mm"]],
        ),
        (
            &[
                "press",
                "no.obj",
                "--tool",
                "drill:",
                "--depth-mm",
                "0",
                "--at",
                "here",
                "--stiffness",
                "1",
                "--voxel-mm=-1",
            ],
            &[
                &["--tool drill:", "`drill`"],
                &["--depth-mm 0:", "1e-6 to 1000"],
                &["--at here:", "12.5,-4"],
                &["--stiffness 1:", "1e5 to 1e14"],
                &["--voxel-mm -1:", "above zero"],
            ],
        ),
        (
            &[
                "simulate",
                "no",
                "--out",
                "o",
                "--passes",
                "0",
                "--force-n",
                "-15",
                "--grind-rate",
                "nan",
                "--backend",
                "xpu",
            ],
            &[
                &["--passes 0:", "1 to 200"],
                &["--force-n -15:", "0.001 to 10000"],
                &["--grind-rate nan:", "1e-15 to 1e-6"],
                &["--backend xpu:"],
            ],
        ),
        (
            &[
                "path",
                "no",
                "--out",
                "o",
                "--raster",
                "5,0,1,1",
                "--spacing-mm",
                "0",
                "--feed-mm-s",
                "0",
                "--tool",
                "x",
            ],
            &[
                &["--raster", "X0 < X1"],
                &["--spacing-mm", "0.001 to 1000"],
                &["--feed-mm-s"],
                &["--tool", "a kind and its sizes are missing"],
            ],
        ),
        (
            &[
                "render",
                "no",
                "--out",
                "o",
                "--size",
                "1x1",
                "--camera",
                "0,91",
                "--samples",
                "0",
                "--distortion",
                "1,2",
            ],
            &[
                &["--size", "16 to 4096"],
                &["--camera", "-90 to 90"],
                &["--samples", "1 to 16"],
                &["--distortion", "K3"],
            ],
        ),
        (
            &[
                "dataset",
                "no",
                "--out",
                "o",
                "--per-part",
                "0",
                "--shard",
                "4/3",
                "--time-limit",
                "-1",
                "--shell-mm",
                "1",
            ],
            &[
                &["--per-part 0"],
                &["--shard 4/3", "i/n"],
                &["--time-limit -1", "0.1 to 1e6"],
                &["--shell-mm 1", "bake"],
            ],
        ),
        (
            &[
                "dataset",
                "images",
                "--out",
                "o",
                "--stages",
                "0",
                "--size",
                "9",
                "--voxel-mm",
                "9",
                "--memory-limit",
                "0",
            ],
            &[&["--stages"], &["--size"], &["--voxel-mm", "0.1 to 5"], &["--memory-limit", "0.1 to 10000"]],
        ),
        (
            &["trial", "synth", "--out", "o", "--trials", "65", "--seed=-1", "--effect", "tool-tilt:steep"],
            &[&["--trials 65:", "1 to 64"], &["--seed -1:"], &["--effect tool-tilt:steep:", "PARAMETER=VALUE"]],
        ),
        (
            &["bench", "diagnose", "--out", "o", "--cases", "4000000000000", "--families", "N,Q", "--seed", "x"],
            &[&["--cases", "1 to 10000"], &["--families Q:", "N or S"], &["--seed x:"]],
        ),
        (&["study", "no", "--out", "o", "--seed", "x", "--threads", "0"], &[&["--seed"], &["--threads", "1 to 1024"]]),
        (
            &["calibrate", "no", "--threads", "0", "--out", "o", "--order", "any"],
            &[&["--threads"], &["--order any:", "joint or staged"]],
        ),
        (&["--threads", "0", "diagnose", "no", "--out", "o", "--seed", "x"], &[&["--threads 0:"], &["--seed x:"]]),
        (
            &["compare", "no", "--out", "o", "--section", "z=1", "--section", "x=20mm", "--seed", "1.5"],
            &[&["--section z=1:", "x=20mm"], &["--seed 1.5:"]],
        ),
    ];
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (words, faults) in refusals {
        run(robofin(words).current_dir(folder.path())).is_refused_for_all(faults);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn what_is_wrong_beside_the_values_is_told_with_them() {
    run(&mut robofin(["weld", "--voxel-mm", "0", "--band", "1", "--stitch-mm", "20"])).is_refused_for_all(&[
        &["--voxel-mm"],
        &["--band"],
        &["required"],
    ]);
    run(&mut robofin(["weld", "part.obj", "--out", "o", "--frobnicate", "3", "--voxel-mm", "0"]))
        .is_refused_for_all(&[&["--voxel-mm"], &["--frobnicate"]]);
    run(&mut robofin(["press", "part.obj", "--tool", "pad:radius=0mm"]))
        .is_refused_for_all(&[&["--tool"], &["required"]]);
    run(&mut robofin(["bench", "diagnose", "--out", "o", "--families", "X,N,Y"]))
        .is_refused_for_all(&[&["--families X"], &["--families Y"]]);
    // Arguments after `--` are not flags.
    run(&mut robofin(["bake", "--band", "1", "--out", "o", "--", "--resolution=1"])).is_refused_for_all(&[&["--band"]]);
}

#[test]
fn all_flags_that_do_not_fit_together_are_told_at_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let trials = ["--replay", "--voxel-mm", "1", "--out"];
    run(robofin(["simulate"]).arg(asset()).args(trials).arg(folder.path().join("out")))
        .is_refused_for_all(&[&["--voxel-mm", "only for a trial"], &["--replay", "only for a trial"]]);
    let photograph = ["--table", "--samples", "3", "--read-noise", "5", "--out"];
    run(robofin(["render"]).arg(asset()).args(photograph).arg(folder.path().join("out.png"))).is_refused_for_all(&[
        &["--read-noise 5.0", "--full-well"],
        &["--table", "a drawing"],
        &["--samples", "a drawing"],
        &["a flag of lens or sensor"],
    ]);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_value_of_many_characters_is_not_repeated_whole() {
    let value = "9".repeat(300);
    let refusal =
        run(&mut robofin(["weld", "part.obj", "--out", "o", "--band", &value])).is_refused(2, &["--band 999", "…"]);
    assert!(refusal.chars().count() < 150, "{refusal}");
}
