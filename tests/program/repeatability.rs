//! The same seed gives the same bytes, whatever the number of threads.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use crate::outside::python;
use crate::program::{bracket, files, robofin, run, weld_bracket};

fn made_by(command: impl FnOnce(&Path) -> Command) -> BTreeMap<String, Vec<u8>> {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("asset");
    run(&mut command(&out)).succeeds();
    files(&out)
}

#[track_caller]
fn assert_same(one: &BTreeMap<String, Vec<u8>>, two: &BTreeMap<String, Vec<u8>>) {
    assert!(one.keys().eq(two.keys()), "{:?} and {:?}", one.keys(), two.keys());
    let differing: Vec<&String> =
        one.iter().filter(|(name, bytes)| two[*name] != **bytes).map(|(name, _)| name).collect();
    assert!(differing.is_empty(), "{differing:?} differ");
}

#[test]
fn one_thread_and_two_write_the_same_asset() {
    let with = |key: &'static str, value: &'static str| {
        made_by(|out| {
            let mut command = weld_bracket(out);
            match key.starts_with("--") {
                true => command.args([key, value]),
                false => command.env(key, value),
            };
            command
        })
    };
    let one = with("--threads", "1");
    assert_same(&one, &with("--threads", "2"));
    assert_same(&one, &with("RAYON_NUM_THREADS", "1"));
    assert_same(&one, &with("RAYON_NUM_THREADS", "2"));
}

#[test]
fn another_seed_gives_another_weld() {
    let with = |seed: &'static str| {
        made_by(|out| {
            let mut command = robofin(["weld", "--usd", "off", "--resolution", "64", "--seed", seed]);
            command.arg(bracket()).arg("--out").arg(out);
            command
        })
    };
    let (seven, eight) = (with("7"), with("8"));
    assert_ne!(seven["welds.json"], eight["welds.json"]);
    assert_eq!(seven["workpiece.glb"], eight["workpiece.glb"], "the part is the same");
}

#[test]
fn one_thread_and_two_grind_alike() {
    let with = |threads: &'static str| {
        made_by(|out| {
            let mut command = robofin(["simulate", "--passes", "1", "--threads", threads]);
            command.arg(crate::program::asset()).arg("--out").arg(out);
            command
        })
    };
    assert_same(&with("1"), &with("2"));
}

#[test]
fn assets_with_usd_are_the_same_bytes_too_and_valid() {
    if python("USD files of whole assets").is_none() {
        return;
    }
    let folder = tempfile::tempdir().expect("a temporary folder");
    let weld = |name: &str, threads: &str| {
        let out = folder.path().join(name);
        let mut command =
            robofin(["weld", "--seed", "7", "--resolution", "64", "--usd", "require", "--threads", threads]);
        run(command.arg(bracket()).arg("--out").arg(&out)).succeeds();
        out
    };
    let (one, two) = (weld("one", "1"), weld("two", "2"));
    let content = files(&one);
    assert!(content.contains_key("welded.usdc"));
    assert_same(&content, &files(&two));
    let checked = run(robofin(["validate", "--usd", "require"]).arg(&one)).succeeds();
    assert!(checked.stderr.contains("clean under usd-core"), "{}", checked.stderr);
}
