//! Limits on inputs: only regular files are read, of the size that their header announces, in the folder of the
//! manifest that names them; and error messages do not quote foreign content.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use tempfile::TempDir;

use crate::program::{Outcome, robofin, run};

/// Words that no message may contain.
const SECRETS: [&str; 3] = ["root:x:0:0", "hunter2", "correct horse battery staple"];

/// Returns a small sealed campaign, made once.
fn campaign() -> &'static Path {
    static FOLDER: LazyLock<TempDir> = LazyLock::new(|| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let out = folder.path().join("trials");
        let synth = ["trial", "synth", "--plan", "paper", "--size", "small", "--sealed", "--seed", "3", "--out"];
        run(robofin(synth).arg(&out)).succeeds();
        folder
    });
    FOLDER.path()
}

/// Copies the campaign, where a test may damage it; returns it with its trial.
fn copy_of_campaign(folder: &Path) -> (PathBuf, PathBuf) {
    let (trials, trial) = (folder.join("trials"), folder.join("trials/trial-1"));
    fs::create_dir_all(&trial).expect("a folder for the copy");
    for below in ["", "trial-1"] {
        let source = campaign().join("trials").join(below);
        for entry in fs::read_dir(source).expect("a folder").map(|entry| entry.expect("an entry")) {
            if entry.path().is_file() {
                fs::copy(entry.path(), trials.join(below).join(entry.file_name())).expect("a copy");
            }
        }
    }
    (trials, trial)
}

#[track_caller]
fn assert_silent(outcome: &Outcome) {
    for secret in SECRETS {
        assert!(!outcome.stderr.contains(secret) && !outcome.stdout.contains(secret), "{}", outcome.stderr);
    }
}

#[cfg(unix)]
fn pipe(place: &Path) {
    let _ = fs::remove_file(place);
    assert!(Command::new("mkfifo").arg(place).status().expect("mkfifo can be run").success());
}

#[cfg(target_os = "linux")]
#[test]
fn meshes_that_are_no_regular_files_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    pipe(&place("pipe.obj"));
    for (name, target) in [("zero.stl", "/dev/zero"), ("round.stl", "round.stl"), ("tty.ply", "/dev/null")] {
        std::os::unix::fs::symlink(target, place(name)).expect("a link");
    }
    let sparse = |name: &str, length: u64| fs::File::create(place(name)).expect("a file").set_len(length);
    sparse("long.stl", 1 << 30).expect("a sparse file");
    sparse("longer.stl", 5 << 30).expect("a sparse file");
    for (name, code, words) in [
        ("pipe.obj", 1, "is a pipe"),
        ("zero.stl", 1, "is a device"),
        ("tty.ply", 1, "is a device"),
        ("round.stl", 2, "no such file"),
        ("long.stl", 1, "announces 84 bytes"),
        ("longer.stl", 1, "at most 2147483648"),
    ] {
        for verb in ["weld", "bake"] {
            let outcome = run(robofin([verb]).arg(place(name)).arg("--out").arg(place("out")));
            outcome.is_refused(code, &[name, words]);
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn measurements_models_and_keys_that_are_no_regular_files_are_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    for name in ["before.csv", "pass1_log.csv", "pass2_after.csv", "trial.toml"] {
        let (trials, trial) = copy_of_campaign(folder.path());
        pipe(&trial.join(name));
        let outcome = run(robofin(["simulate"]).arg(&trial).arg("--out").arg(place("out")));
        let said = outcome.is_refused(1, &[]);
        assert!(said.contains("is a pipe") || name == "trial.toml", "{said}");
        fs::remove_dir_all(trials).expect("it can be removed");
    }
    let (trials, trial) = copy_of_campaign(folder.path());
    pipe(&place("pipe"));
    let simulate = |flag: &str, file: &Path| {
        run(robofin(["simulate"]).arg(&trial).arg(flag).arg(file).arg("--out").arg(place("out")))
    };
    for file in [place("pipe"), PathBuf::from("/dev/zero")] {
        simulate("--model", &file).is_refused(1, &["and a regular file is accepted"]);
        simulate("--batch", &file).is_refused(1, &["and a regular file is accepted"]);
        run(robofin(["press", "--tool", "sphere:radius=5mm", "--force-n", "5"]).arg(&file)).is_refused(1, &["regular"]);
        run(robofin(["render"]).arg(&file).arg("--out").arg(place("x.png"))).is_refused(1, &["a regular file"]);
        run(robofin(["trial", "unseal"]).arg(&trials).arg("--key").arg(&file)).is_refused(2, &["--key"]);
    }
}

#[cfg(unix)]
#[test]
fn a_manifest_names_files_in_its_own_folder_only() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let (_, trial) = copy_of_campaign(folder.path());
    fs::write(place("secret.csv"), SECRETS.join("\n")).expect("it can be written");
    std::os::unix::fs::symlink(place("secret.csv"), trial.join("linked.csv")).expect("a link");
    let manifest = fs::read_to_string(trial.join("trial.toml")).expect("a manifest");
    let absolute = place("secret.csv").display().to_string();
    let simulate = |flags: &[&str]| run(robofin(["simulate"]).args(flags).arg(&trial).arg("--out").arg(place("out")));
    for name in ["/etc/passwd", "/etc/no-such-file", "../../secret.csv", "linked.csv", &absolute] {
        for key in ["before.csv", "pass1_log.csv", "pass2_after.csv", "before_repeat.csv", "material.csv"] {
            assert!(manifest.contains(&format!("\"{key}\"")), "{manifest}");
            let changed = manifest.replace(&format!("\"{key}\""), &format!("\"{name}\""));
            fs::write(trial.join("trial.toml"), changed).expect("it can be written");
            let outcome = simulate(&[]);
            outcome.is_refused(1, &["trial.toml, line", "lies outside", "--allow-outside"]);
            assert_silent(&outcome);
        }
    }
    let changed = manifest.replace("\"before.csv\"", &format!("\"{absolute}\""));
    fs::write(trial.join("trial.toml"), changed).expect("it can be written");
    let outcome = simulate(&["--allow-outside"]);
    outcome.is_refused(1, &["secret.csv, line 1", "text of 10 characters is not a number"]);
    assert_silent(&outcome);
    fs::copy(trial.join("before.csv"), place("secret.csv")).expect("a copy");
    simulate(&["--allow-outside"]).succeeds();
}

#[test]
fn no_error_repeats_what_a_foreign_file_holds() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    let (trials, trial) = copy_of_campaign(folder.path());
    let key = fs::read_to_string(campaign().join("trials.key")).expect("a key");
    let mut other = key.clone().into_bytes();
    other[0] = if other[0] == b'0' { b'1' } else { b'0' };
    let foreign = [
        SECRETS.join("\n"),
        format!("password = \"{}\"\n", SECRETS[2]),
        format!("{{\"format\": \"{}\", \"passes\": \"hunter2\"}}", SECRETS[2]),
        format!("name,{}\n{},1\n", SECRETS[0], SECRETS[1]),
        format!("format = \"{}\"\nname = \"a\"\nprocess = \"{}\"\n", SECRETS[0], SECRETS[2]),
        format!("solid hunter2\nfacet\nvertex {} 1 2\n", SECRETS[0]),
        format!("v 1 2 3\nf {}\n", SECRETS[2]),
        format!("ply\nformat {} 1.0\nend_header\n", SECRETS[0]),
    ];
    for text in &foreign {
        let file = place("foreign");
        fs::write(&file, text).expect("it can be written");
        let trial_flag =
            |flag: &str| run(robofin(["simulate"]).arg(&trial).arg(flag).arg(&file).arg("--out").arg(place("o")));
        let mut refused = vec![trial_flag("--model"), trial_flag("--batch")];
        for verb in ["weld", "bake"] {
            refused.push(run(robofin([verb]).arg(&file).arg("--out").arg(place("o"))));
        }
        refused.push(run(robofin(["trial", "unseal"]).arg(&trials).arg("--key").arg(&file)));
        fs::create_dir_all(place("folder")).expect("a folder");
        for name in ["trial.toml", "table.toml", "asset.json", "dataset.json", "effect.toml"] {
            fs::write(place("folder").join(name), text).expect("it can be written");
            refused.push(run(robofin(["simulate"]).arg(place("folder")).arg("--out").arg(place("o"))));
            refused.push(run(robofin(["validate"]).arg(place("folder"))));
            refused.push(run(robofin(["compare"]).arg(place("folder")).arg("--out").arg(place("o"))));
            refused.push(run(robofin(["effects", "list", "--effects"]).arg(place("folder"))));
            fs::remove_file(place("folder").join(name)).expect("it can be removed");
        }
        for outcome in &refused {
            assert_silent(outcome);
        }
    }
    fs::write(place("foreign.key"), &other).expect("it can be written");
    let outcome = run(robofin(["trial", "unseal"]).arg(&trials).arg("--key").arg(place("foreign.key")));
    let half = String::from_utf8(other[..32].to_vec()).expect("digits");
    assert!(outcome.status.code() != Some(0) && !outcome.stderr.contains(&half), "{}", outcome.stderr);
    fs::write(place("foreign.key"), &other[2..]).expect("it can be written");
    let outcome = run(robofin(["trial", "unseal"]).arg(&trials).arg("--key").arg(place("foreign.key")));
    outcome.is_refused(2, &["text of 62 characters is not a key"]);
    assert!(!outcome.stderr.contains(&half[2..12]), "{}", outcome.stderr);
}
