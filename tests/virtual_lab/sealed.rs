//! The command: seals open with their own key only and reveal nothing before, and refusals state the remedy.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use trials::trial::Campaign;

fn robofin(arguments: &[&str], out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robofin"));
    command.args(["trial", "synth"]).args(arguments).arg("--out").arg(out).output().unwrap()
}

fn unseal(folder: &Path, key: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robofin"));
    command.args(["trial", "unseal", "--json"]).arg(folder).arg("--key").arg(key).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

#[track_caller]
fn is_refused(output: &Output, code: i32, words: &[&str]) {
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{error}");
    for word in words {
        assert!(error.contains(word), "{word:?} is missing in: {error}");
    }
}

const SMALL: [&str; 6] = ["--size", "small", "--plan", "paper", "--seed", "5"];

/// Asserts that no name and no text of a sealed folder reveals the effect, its size or the seed.
#[track_caller]
fn reveals_nothing(folder: &Path) {
    let mut files = 0;
    for entry in walkdir::WalkDir::new(folder) {
        let entry = entry.unwrap();
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(!name.contains("tilt") && name != "answers.json", "{name}");
        if entry.file_type().is_file() {
            let content = text(&fs::read(entry.path()).unwrap());
            assert!(["tilt", "9.125", "\"seed\""].iter().all(|word| !content.contains(word)), "{name}");
            files += 1;
        }
    }
    assert!(files >= 9, "{files}");
}

#[test]
fn a_sealed_campaign_opens_with_its_key_only_and_reveals_nothing_before() {
    let folder = tempfile::tempdir().unwrap();
    let place = |name: &str| folder.path().join(name);
    let flags = [&SMALL[..], &["--sealed", "--effect", "tool-tilt:roll_angle=9.125 mrad"]].concat();
    let sealed = robofin(&flags, &place("example"));
    assert!(sealed.status.success(), "{}", text(&sealed.stderr));
    let plain = robofin(&[&SMALL[..], &["--sealed"]].concat(), &place("other"));
    assert!(plain.status.success());
    let said = text(&sealed.stderr) + &text(&sealed.stdout);
    assert!(said.contains("example.key") && !said.contains("tilt"), "{said}");
    reveals_nothing(&place("example"));
    let size_of = |name: &str| fs::metadata(place(name).join("sealed.json")).unwrap().len();
    assert_eq!(size_of("example"), size_of("other"));

    let opened = unseal(&place("example"), &place("example.key"));
    assert!(opened.status.success(), "{}", text(&opened.stderr));
    let answer: Value = serde_json::from_slice(&opened.stdout).unwrap();
    assert_eq!(answer["measurements_unchanged"], true);
    assert_eq!(answer["answer"]["effects"][0]["name"], "tool-tilt");
    assert_eq!(answer["answer"]["effects"][0]["parameters"]["roll_angle"]["values"][0], "9.125");

    // The same seed gives the same key, and a wrong key does not open the seal.
    assert_eq!(fs::read(place("example.key")).unwrap(), fs::read(place("other.key")).unwrap());
    fs::write(place("wrong.key"), "0".repeat(64)).unwrap();
    is_refused(&unseal(&place("example"), &place("wrong.key")), 1, &["sealed.json", "does not open it"]);
    fs::write(place("no.key"), "open sesame").unwrap();
    let refused = unseal(&place("example"), &place("no.key"));
    is_refused(&refused, 2, &["--key", "text of 11 characters", "64 hexadecimal digits"]);
    assert!(!text(&refused.stderr).contains("sesame"), "a key is never repeated");
    is_refused(&unseal(&place("example"), &place("absent.key")), 2, &["absent.key"]);
    is_refused(&unseal(folder.path(), &place("example.key")), 2, &["sealed.json", "trial synth --sealed"]);

    let log = place("example").join("trial-1/pass1_log.csv");
    fs::write(&log, fs::read_to_string(&log).unwrap().replace("6000", "6001")).unwrap();
    let opened = unseal(&place("example"), &place("example.key"));
    let answer: Value = serde_json::from_slice(&opened.stdout).unwrap();
    assert_eq!(answer["measurements_unchanged"], false);
    assert!(text(&opened.stderr).contains("CHANGED"));
}

#[test]
fn what_cannot_be_hidden_is_refused_with_what_could() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    for (flags, words) in [
        (&["--effect", "grit-duling"][..], &["grit-duling", "grit-dulling"][..]),
        (&["--effect", "grit-dulling:volume=3 mm^3"], &["volume", "dulling_volume"]),
        (&["--effect", "grit-dulling:dulling_volume=-5 mm^3"], &["dulling_volume", "-5 mm^3", "a size such as"]),
        (&["--effect", "tool-tilt:roll_angle"], &["roll_angle", "PARAMETER=VALUE"]),
        (&["--effect", "tool-tilt:roll_angle=3 kg"], &["roll_angle", "kg"]),
        (&["--process", "sanding", "--effect", "wheel-wear"], &["wheel-wear", "sanding"]),
        (&["--effect", "chatter", "--effect", "chatter"], &["chatter", "twice"]),
        (&["--trials", "0"], &["--trials 0", "1 to 64"]),
        (&["--trials", "1000"], &["--trials 1000", "1 to 64"]),
        (&["--random", "--effect", "chatter"], &["--random", "--effect"]),
        (&["--plan", "zigzag"], &["--plan", "zigzag", "steps"]),
        (&["--effects", "/nowhere/at/all"], &["--effects", "no such folder"]),
    ] {
        is_refused(&robofin(flags, &out), 2, words);
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    fs::create_dir(&out).unwrap();
    fs::write(out.join("thesis.txt"), "years of work").unwrap();
    is_refused(&robofin(&SMALL, &out), 2, &["already exists", "--force"]);
    is_refused(&robofin(&["--force"], &out), 2, &["laboratory.json", "--force does not replace it"]);
    assert_eq!(fs::read_to_string(out.join("thesis.txt")).unwrap(), "years of work");
}

#[test]
fn the_bundled_campaign_can_be_read_and_is_the_one_that_was_sealed() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns/first-look");
    let campaign = Campaign::read(&folder).unwrap();
    assert!(campaign.trials.len() == 3 && campaign.trials.iter().all(|trial| trial.notes.is_empty()));
    let opened = unseal(&folder, &folder.with_extension("key"));
    let answer: Value = serde_json::from_slice(&opened.stdout).unwrap();
    assert_eq!(answer["measurements_unchanged"], true);
    assert_eq!(answer["answer"]["effects"].as_array().unwrap().len(), 1);
}
