//! `simulate` with absurd process parameters: a refusal that names the flag, never a hang.

use crate::program::{asset, names, robofin, run};

#[test]
fn process_values_out_of_range_are_wrong_use_and_say_the_range() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("ground");
    for (flag, values) in [
        ("--stiffness", &["1e30", "1e-9", "-1", "nan", "inf"][..]),
        ("--force-n", &["1e9", "1e-30", "0", "-15", "nan"]),
        ("--grind-rate", &["1", "1e-30", "nan"]),
        ("--wheel-radius-mm", &["0.001", "1e9", "0", "nan"]),
        ("--wheel-width-mm", &["0.001", "1e9", "-20"]),
        ("--feed-mm-s", &["1e9", "1e-9", "0", "inf"]),
        ("--passes", &["0", "1000000"]),
        ("--threshold-mpa", &["-1", "1e9", "nan"]),
    ] {
        for value in values {
            let outcome = run(robofin(["simulate", flag, value]).arg(asset()).arg("--out").arg(&out));
            outcome.is_refused(2, &[flag, " to ", "accepted"]);
        }
        run(robofin(["simulate", flag, "many"]).arg(asset()).arg("--out").arg(&out)).is_refused(2, &[flag, "many"]);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_process_that_takes_millions_of_steps_is_refused_by_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("ground");
    let outcome = run(robofin(["simulate", "--feed-mm-s", "0.001"]).arg(asset()).arg("--out").arg(&out));
    outcome.is_refused(1, &["steps", "--feed-mm-s"]);
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn a_wheel_smaller_than_a_voxel_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("ground");
    for flag in ["--wheel-radius-mm", "--wheel-width-mm"] {
        let outcome = run(robofin(["simulate", flag, "0.5"]).arg(asset()).arg("--out").arg(&out));
        outcome.is_refused(1, &[flag, "voxel of 2.5000 mm"]);
    }
    assert_eq!(names(folder.path()), Vec::<String>::new());
}

#[test]
fn the_ends_of_the_accepted_ranges_finish() {
    for flags in [
        ["--force-n", "10000"],
        ["--force-n", "0.001"],
        ["--stiffness", "1e14"],
        ["--grind-rate", "1e-6"],
        ["--feed-mm-s", "10000"],
        ["--wheel-radius-mm", "1000"],
        ["--wheel-width-mm", "1000"],
        ["--stiffness", "1e5"],
        ["--threshold-mpa", "10000"],
    ] {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let out = folder.path().join("ground");
        let outcome = run(robofin(["simulate", "--passes", "1"]).args(flags).arg(asset()).arg("--out").arg(&out));
        match outcome.status.code() {
            Some(0) => assert_eq!(names(folder.path()), ["ground"]),
            _ => {
                let reason = outcome.is_refused(1, &[]);
                eprintln!("{flags:?}: {reason}");
                assert_eq!(names(folder.path()), Vec::<String>::new());
            }
        }
    }
}

#[test]
fn what_is_no_asset_cannot_be_ground_or_drawn() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let (empty, out) = (folder.path().join("empty"), folder.path().join("out"));
    std::fs::create_dir(&empty).expect("it can be made");
    for verb in ["simulate", "render"] {
        run(robofin([verb]).arg(&empty).arg("--out").arg(&out))
            .is_refused(1, &["asset.json", "made by `robofin weld`"]);
        run(robofin([verb]).arg(folder.path().join("absent")).arg("--out").arg(&out)).is_refused(1, &["absent"]);
    }
    assert_eq!(names(folder.path()), ["empty"]);
}

#[test]
fn pictures_have_a_size_within_bounds() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for size in
        ["1x1", "0x0", "4097x16", "8192x8192", "640", "x", "-1x5", "640x480x3", "99999999999999999999x16", "nanx16"]
    {
        let outcome = run(robofin(["render", &format!("--size={size}")])
            .arg(asset())
            .arg("--out")
            .arg(folder.path().join("p.png")));
        outcome.is_refused(2, &["--size", "from 16 to 4096"]);
    }
    run(robofin(["render", "--size", "16x16"]).arg(asset()).arg("--out").arg(folder.path().join("p.png"))).succeeds();
    assert_eq!(names(folder.path()), ["p.png"]);
}

#[test]
fn files_that_are_no_field_cannot_be_drawn() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let field = std::fs::read(asset().join("phi.nvdb")).expect("a field");
    let labels = std::fs::read(asset().join("weld.nvdb")).expect("a field");
    let files: [(&str, &[u8], &str); 5] = [
        ("empty.nvdb", b"", "empty.nvdb"),
        ("text.nvdb", b"once upon a time in a file without a field, and then some more", "NanoVDB0"),
        ("cut.nvdb", &field[..field.len() / 2], "cut.nvdb"),
        ("short.nvdb", &field[..20], "short.nvdb"),
        ("labels.nvdb", &labels, "no grid `phi`"),
    ];
    for (name, bytes, words) in files {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("it can be written");
        run(robofin(["render"]).arg(path).arg("--out").arg(folder.path().join("p.png"))).is_refused(1, &[words]);
    }
    assert!(!folder.path().join("p.png").exists());
}
