//! Damage to a data set is found, named, and repaired without changing the other items.

use std::fs;
use std::path::Path;

use crate::program::{Outcome, robofin, run};
use crate::set::{ITEMS, assert_same, copy_of_set, items, tree, undisturbed};

fn validate(set: &Path, more: &[&str]) -> Outcome {
    run(robofin(["validate"]).arg(set).args(more))
}

#[test]
fn a_whole_set_holds() {
    let told = validate(undisturbed().1, &["--json"]).succeeds();
    let answer = told.answer();
    assert_eq!((&answer["valid"], &answer["items"]), (&true.into(), &ITEMS.into()));
    assert!(answer["checks"].as_u64() > Some(20 * ITEMS as u64), "{answer}");
}

#[test]
fn broken_items_are_found_and_only_they_are_made_again() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let set = copy_of_set(place.path());
    let folders = items(&set);
    let mut field = fs::read(folders[0].join("phi.nvdb")).expect("a field");
    let middle = field.len() / 2;
    field[middle] ^= 1;
    fs::write(folders[0].join("phi.nvdb"), field).expect("written");
    fs::remove_dir_all(&folders[1]).expect("it can be removed");
    fs::remove_file(folders[2].join("asset.json")).expect("it can be removed");
    fs::write(folders[3].join("notes.txt"), "mine").expect("written");
    let untouched = fs::metadata(folders[4].join("phi.nvdb")).and_then(|file| file.modified()).expect("a time");

    let told = validate(&set, &[]);
    told.is_refused(1, &["4 of 6 items broken", "--repair"]);
    let named = |place: usize| folders[place].file_name().expect("a name").to_string_lossy().into_owned();
    for (place, word) in [(0, "phi.nvdb"), (1, "no such folder"), (2, "asset.json"), (3, "notes.txt")] {
        let line = format!("{}: ", named(place));
        assert!(told.stderr.lines().any(|text| text.contains(&line) && text.contains(word)), "{}", told.stderr);
    }
    let repaired = validate(&set, &["--repair"]).succeeds();
    assert_eq!(repaired.stderr.matches("      made  ").count(), 4, "{}", repaired.stderr);
    assert_same(&set, undisturbed().1);
    let now = fs::metadata(folders[4].join("phi.nvdb")).and_then(|file| file.modified()).expect("a time");
    assert_eq!(now, untouched, "a whole item was made again");
}

#[test]
fn a_catalogue_that_does_not_say_what_the_items_say_is_found() {
    for (name, from, to) in [
        ("manifest.jsonl", "\"split\":\"", "\"split\":\"x"),
        ("manifest.csv", "id,split", "id,spilt"),
        ("README.md", "6 items", "7 items"),
        ("croissant.json", "\"version\"", "\"Version\""),
    ] {
        let place = tempfile::tempdir().expect("a temporary folder");
        let set = copy_of_set(place.path());
        let text = fs::read_to_string(set.join(name)).expect("text");
        assert!(text.contains(from), "{name}");
        fs::write(set.join(name), text.replacen(from, to, 1)).expect("written");
        let told = validate(&set, &[]);
        told.is_refused(1, &["0 of 6 items broken, 1 faults"]);
        assert!(told.stderr.contains(&format!("{name}: differs in line")), "{}", told.stderr);
        validate(&set, &["--repair"]).succeeds();
        assert_same(&set, undisturbed().1);
    }
}

#[test]
fn a_file_changed_together_with_its_hash_is_found_too() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let set = copy_of_set(place.path());
    let manifest = items(&set)[0].join("asset.json");
    let text = fs::read_to_string(&manifest).expect("a manifest");
    fs::write(&manifest, text.replacen("\"seed\": ", "\"seed\": 1", 1)).expect("written");
    let told = validate(&set, &[]);
    told.is_refused(1, &["1 of 6 items broken"]);
    assert!(told.stderr.contains("its seed is"), "{}", told.stderr);
}

#[test]
fn a_marker_that_contradicts_itself_repairs_nothing() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let set = copy_of_set(place.path());
    let marker = set.join("dataset.json");
    let text = fs::read_to_string(&marker).expect("a marker");
    fs::write(&marker, text.replacen("\"seed\": 7", "\"seed\": 8", 1)).expect("written");
    validate(&set, &[]).is_refused(1, &["6 of 6 items broken"]);
    let before = tree(&set);
    validate(&set, &["--repair"]).is_refused(1, &["dataset.json", "flags do not lead to"]);
    assert!(tree(&set) == before, "it was changed");
    fs::write(&marker, "{}").expect("written");
    validate(&set, &[]).is_refused(1, &["dataset.json", "robofin-dataset/1"]);
}

#[test]
fn sources_that_moved_are_asked_for() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let set = copy_of_set(place.path());
    let marker = set.join("dataset.json");
    let (parts, whole) = undisturbed();
    let text = fs::read_to_string(&marker).expect("a marker");
    let elsewhere = place.path().join("elsewhere");
    fs::create_dir(&elsewhere).expect("a folder");
    fs::write(elsewhere.join("other.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a part");
    fs::write(&marker, text.replace(&*parts.to_string_lossy(), &elsewhere.to_string_lossy())).expect("written");
    fs::write(items(&set)[0].join("welds.json"), "{}").expect("written");
    validate(&set, &["--repair"]).is_refused(1, &["is not below the folders searched", "--from"]);
    let from = parts.to_string_lossy().into_owned();
    validate(&set, &["--repair", "--from", &from]).succeeds();
    assert!(tree(&set.join("assets")) == tree(&whole.join("assets")));
}

#[test]
fn only_sets_can_be_repaired() {
    let item = items(undisturbed().1).remove(0);
    validate(&item, &["--repair"]).is_refused(2, &["--repair", "dataset.json"]);
    validate(&item, &["--usd", "off"]).succeeds();
}
