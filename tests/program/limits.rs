//! Endless work and absurd numbers are refused before any work, with flag or key, value and range.

use std::fs;
use std::path::Path;

use crate::program::{asset, bracket, names, robofin, run, weld_bracket};
use crate::trial_road::trial;

/// Replaces the text of a file.
fn edit(file: &Path, change: impl Fn(&str) -> String) {
    let text = fs::read_to_string(file).expect("a text");
    let changed = change(&text);
    assert_ne!(changed, text, "{} has nothing to change", file.display());
    fs::write(file, changed).expect("a file that can be written");
}

#[test]
fn more_cases_than_anyone_waits_for_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("bench");
    for cases in ["4000000000000", "10001", "0", "-1", "many"] {
        run(robofin(["bench", "diagnose", "--cases", cases, "--out"]).arg(&out))
            .is_refused(2, &["--cases", cases, "1 to 10000"]);
    }
    run(robofin(["bench", "diagnose", "--limit", "0", "--out"]).arg(&out)).is_refused(2, &["--limit", "1 to 10000"]);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_part_of_a_benchmark_runs_its_own_cases_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("bench");
    let bench = |part: &str| {
        let mut command = robofin(["bench", "diagnose", "--families", "N", "--cases", "4", "--out"]);
        run(command.arg(&out).args(["--part", part]))
    };
    for wrong in ["0/2", "3/2", "2", "1/0", "a/b"] {
        bench(wrong).is_refused(2, &["--part", wrong, "as in 2/8"]);
    }
    bench("3/4").succeeds();
    let cases = names(&out);
    assert!(cases.len() == 1 && cases[0].starts_with("N02"), "{cases:?}");
    let written = || fs::metadata(out.join(&cases[0])).and_then(|file| file.modified()).expect("a file");
    let before = written();
    bench("3/4").succeeds();
    assert_eq!((names(&out), written()), (cases.clone(), before), "finished cases are kept, and no table is written");
}

#[test]
fn definitions_that_double_each_other_are_checked_at_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("own.toml");
    let doubled: String = (1..=41).map(|k| format!("a{k} = \"a{} + a{}\"\n", k - 1, k - 1)).collect();
    let text = format!(
        "name = \"own\"\n[parameters.amount]\nunit = \"1\"\nnull = 0.0\nrange = [0.0, 1.0]\n[let]\na0 = \"amount\"\n{doubled}\
         [modify]\nrate = \"rate * (1 + a41)\"\n"
    );
    fs::write(&file, text).expect("a file");
    run(robofin(["effects", "check"]).arg(&file)).succeeds();
}

#[test]
fn a_trial_of_endless_work_is_refused_before_it_is_simulated() {
    let refused = |file: &str, change: &dyn Fn(&str) -> String, words: &[&str]| {
        let (folder, place) = trial();
        edit(&place.join(file), change);
        let out = folder.path().join("out");
        run(robofin(["simulate"]).arg(&place).arg("--out").arg(&out)).is_refused(1, words);
        assert!(!out.exists());
    };
    let manifest = "trial.toml";
    refused(
        manifest,
        &|text| text.replace("period_s = 0.0005", "period_s = 1e-15"),
        &["trial.toml, line", "period_s is 1e-15", "1e-5 to 1.0"],
    );
    refused(
        manifest,
        &|text| text.replace("radius_mm = 20.0", "radius_mm = 1e9"),
        &["trial.toml, line", "radius_mm is 1000000000.0", "0.1 to 1000.0"],
    );
    let passes = |text: &str| {
        let (head, pass) = text.split_once("[[pass]]").expect("a pass");
        let pass = pass.split("[[pass]]").next().expect("the first pass");
        format!("{head}{}", format!("[[pass]]{pass}\n").repeat(20_000))
    };
    refused(manifest, &passes, &["trial.toml", "20000 passes", "at most 1000"]);
    // Many controller steps: an accepted period, over logs with a long pause.
    let slow = |text: &str| {
        let mut rows = text.lines();
        let head = rows.next().expect("a header").to_owned();
        let slowed = rows.map(|row| {
            let (time, rest) = row.split_once(',').expect("a time");
            let time: f64 = time.parse().expect("a number");
            format!("{:?},{rest}", if time < 1.0 { time } else { time + 1e4 })
        });
        std::iter::once(head).chain(slowed).collect::<Vec<_>>().join("\n")
    };
    let (folder, place) = trial();
    edit(&place.join(manifest), |text| text.replace("period_s = 0.0005", "period_s = 0.00001"));
    let logs: Vec<_> = names(&place).into_iter().filter(|name| name.contains("log")).collect();
    assert!(!logs.is_empty());
    logs.iter().for_each(|log| edit(&place.join(log), slow));
    run(robofin(["simulate"]).arg(&place).arg("--out").arg(folder.path().join("out")))
        .is_refused(1, &["steps, and 3e7 are accepted", "period_s"]);
}

#[test]
fn paths_with_sizes_beyond_any_tool_are_refused_and_no_row_is_infinite() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("path.csv");
    for (tool, value) in [
        ("wheel:radius=1e308m,width=20mm", "1e308m"),
        ("wheel:radius=50mm,width=1e308m", "1e308m"),
        ("wheel:radius=inf mm,width=20mm", "inf mm"),
        ("pad:radius=1e-9mm", "1e-9mm"),
        ("pad:radius=-5mm", "-5mm"),
    ] {
        run(robofin(["path", "--tool", tool]).arg(asset()).arg("--out").arg(&out))
            .is_refused(2, &["--tool", value, "0.1 to 1000.0 mm"]);
    }
    for raster in ["-1e308,0,1e308,1", "0,0,inf,1", "0,0,1e9,1"] {
        run(robofin(["path", "--raster", raster, "--spacing-mm", "1"]).arg(asset()).arg("--out").arg(&out))
            .is_refused(2, &["--raster", "within 1e5"]);
    }
    run(robofin(["path", "--raster=-5000,-5000,5000,5000", "--spacing-mm", "0.001"])
        .arg(asset())
        .arg("--out")
        .arg(&out))
    .is_refused(1, &["--spacing-mm of 0.001", "1e7 are accepted"]);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn flags_that_were_accepted_without_a_meaning_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    let drawing = folder.path().join("out.png");
    for (flags, words) in [
        (&["--samples", "0"][..], &["--samples", "0", "1 to 16"][..]),
        (&["--samples", "17"], &["--samples", "17", "1 to 16"]),
        (&["--turntable", "1"], &["--turntable", "1", "2 to 720"]),
        (&["--camera", "0,91"], &["--camera", "0,91", "-90 to 90"]),
        (&["--grind-along", "0,0,0"], &["--grind-along", "X,Y,Z"]),
    ] {
        for out in [&out, &drawing] {
            run(robofin(["render"]).arg(asset()).args(flags).arg("--out").arg(out)).is_refused(2, words);
        }
    }
    run(robofin(["render", "--turntable", "720", "--size", "4096x4096", "--samples", "16"])
        .arg(asset())
        .arg("--out")
        .arg(&out))
    .is_refused(2, &["--turntable", "3.1e12 samples", "1e11 are accepted"]);
    run(robofin(["render", "--read-noise", "5"]).arg(asset()).arg("--out").arg(&out))
        .is_refused(2, &["--read-noise 5.0", "--full-well", "10 to 1e9"]);
    run(robofin(["render", "--samples", "3"]).arg(asset()).arg("--out").arg(&drawing))
        .is_refused(2, &["--samples", "a drawing"]);
    for jobs in ["0", "257", "-1", "1.5"] {
        run(robofin(["validate", "--jobs", jobs]).arg(asset())).is_refused(2, &["--jobs", jobs, "1 to 256"]);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn what_is_asked_of_a_bead_is_checked_before_the_part_is_baked_and_by_the_flag_s_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    for (code, flags, words) in [
        (2, &["--pores", "1001"][..], &["--pores", "1001", "0 to 1000"][..]),
        (2, &["--pores", "-1"], &["--pores", "-1", "0 to 1000"]),
        (2, &["--spatter", "4000000000"], &["--spatter", "0 to 1000"]),
        (2, &["--burn-through", "11"], &["--burn-through", "0 to 10"]),
        (
            1,
            &["--width-mm", "20", "--ripple-pitch-mm", "300"],
            &["--ripple-pitch-mm:", "300.0 mm", "5.0 mm to 200.0 mm"],
        ),
        (1, &["--ripple-pitch-mm", "4.9"], &["--ripple-pitch-mm 4.9", "voxel of 2.5000 mm", "5.0000 mm or more"]),
        (
            1,
            &["--width-mm", "20", "--weave-mm", "11", "--weave-pitch-mm", "100"],
            &["--weave-mm:", "11.0 mm", "0.0 mm to 10.0 mm"],
        ),
        (1, &["--width-mm", "20", "--weave-mm", "5", "--weave-pitch-mm", "10"], &["--weave-pitch-mm:", "10.0 mm"]),
        (
            1,
            &["--width-mm", "20", "--stitch-mm", "10", "--stitch-pitch-mm", "90"],
            &["--stitch-mm:", "10.0 mm", "20.0 mm"],
        ),
        (
            1,
            &["--width-mm", "20", "--stitch-mm", "30", "--stitch-pitch-mm", "40"],
            &["--stitch-pitch-mm:", "40.0 mm", "60.0 mm"],
        ),
        (1, &["--width-mm", "20", "--toe-radius-mm", "80"], &["--toe-radius-mm 80.0", "0 to", "are accepted"]),
        (1, &["--width-mm", "20", "--correlation-mm", "1"], &["--correlation-mm:", "1.0 mm", "10.0 mm"]),
        (
            1,
            &["--exposure-reach-mm", "1e-300", "--curvature-per-m", "9", "--curvature-max-per-m", "1"],
            &["--curvature-per-m:", "0.95"],
        ),
    ] {
        let outcome = run(weld_bracket(&out).args(flags));
        outcome.is_refused(code, words);
        assert!(!outcome.stderr.contains("bake  "), "the part was baked: {}", outcome.stderr);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn numbers_of_three_hundred_digits_are_never_printed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    for flag in ["--length-mm", "--width-mm", "--height-mm", "--min-exposure", "--voxel-mm", "--exposure-reach-mm"] {
        for value in ["1e300", "1e-300", "-1e300"] {
            let mut command = robofin(["weld", "--usd", "off", flag, value]);
            let outcome = run(command.arg(bracket()).arg("--out").arg(&out));
            let long = outcome.stderr.split(|c: char| !c.is_ascii_digit()).map(str::len).max();
            assert!(long.is_some_and(|digits| digits < 30), "{flag} {value}: {}", outcome.stderr);
        }
    }
}

#[test]
fn words_that_are_no_number_are_named_in_plain_words() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("out");
    for (flag, value, words) in [
        ("--voxel-mm", "fine", "a number such as"),
        ("--width-mm", "1,5", "a number such as"),
        ("--resolution", "-1", "a whole number from 8 to 4096"),
        ("--count", "0", "a whole number from 1 to 1000"),
    ] {
        let mut command = robofin(["weld", flag, value]);
        let message = run(command.arg(bracket()).arg("--out").arg(&out)).is_refused(2, &[flag, value, words]);
        assert!(!message.contains("literal") && !message.contains("..="), "{message}");
    }
}

#[test]
fn a_sheet_to_be_welded_is_not_told_of_shells() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let sheet = folder.path().join("sheet.obj");
    let vertices: String = (0..9).map(|i| format!("v {} {} 0\n", 25 * (i % 3), 25 * (i / 3))).collect();
    fs::write(&sheet, vertices + "f 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\nf 5 6 9 8\n").expect("a file");
    let out = folder.path().join("out");
    let weld = run(robofin(["weld", "--resolution", "64"]).arg(&sheet).arg("--out").arg(&out));
    let message = weld.is_refused(1, &["sheet.obj", "a solid part is needed"]);
    assert!(!message.contains("--shell-mm"), "{message}");
    run(robofin(["bake", "--resolution", "64"]).arg(&sheet).arg("--out").arg(&out)).is_refused(1, &["--shell-mm T"]);
}

#[test]
fn a_cause_is_told_once() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("part.gltf");
    fs::write(
        &file,
        r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"missing.bin","byteLength":36}],"bufferViews":[],"meshes":[]}"#,
    )
    .expect("a file");
    for verb in ["weld", "bake"] {
        let out = folder.path().join("out");
        let message = run(robofin([verb]).arg(&file).arg("--out").arg(out)).is_refused(1, &["missing.bin"]);
        assert_eq!(message.matches("No such file").count(), 1, "{message}");
    }
}
