//! Content of a data set, which depends on parts and flags alone.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use files::folder::StagedFolder;
use robofin::asset::{self, Extras, FileRecord, Manifest, UsdMode};
use robofin::console::Console;
use robofin::part::{Part, sha256};
use robofin::workpiece::{Fineness, WeldSettings, WeldingOptions, weld_part};
use sdf_bake::SignChoice;
use sdf_bake::read::UnitChoice;
use serde_json::Value;

use crate::program::{files, robofin, run};
use crate::set::{ITEMS, assert_same, dataset, items, lines, plate, plates, undisturbed};

#[test]
fn the_manifest_says_of_each_item_what_its_folder_says() {
    let (parts, set) = undisturbed();
    let rows = lines(&set.join("manifest.jsonl"));
    assert_eq!(rows.len(), ITEMS);
    for row in &rows {
        let folder = set.join(row["folder"].as_str().expect("a folder"));
        let manifest = Manifest::read(&folder).expect("a manifest");
        assert_eq!(row["seed"], manifest.seed);
        assert_eq!(row["source_sha256"], *manifest.source.sha256);
        let part = ["a.obj", "b.obj", "below/c.obj"].iter().find(|name| name.ends_with(&manifest.source.file));
        let bytes = fs::read(parts.join(part.expect("one of the plates"))).expect("the part");
        assert_eq!(sha256(&bytes), manifest.source.sha256);
        let listed = row["files"].as_object().expect("files");
        assert_eq!(listed.len(), files(&folder).len());
        for (name, record) in listed {
            let found = FileRecord::of(&folder.join(name)).expect("a file");
            assert_eq!((&record["sha256"], &record["bytes"]), (&Value::from(found.sha256), &Value::from(found.bytes)));
        }
        let weld = &row["measured"]["welds"][0];
        assert_eq!(weld["length_mm"], manifest.checks["weld_length_mm"], "{weld}");
        assert!(weld.get("curve").is_none() && weld["exposure_min"].as_f64().expect("a number") > 0.4, "{weld}");
        assert!(["easy", "medium", "hard"].contains(&row["difficulty"].as_str().expect("a class")));
    }
    let seeds: BTreeSet<u64> = rows.iter().filter_map(|row| row["seed"].as_u64()).collect();
    assert_eq!(seeds.len(), ITEMS, "each item has a seed of its own");
}

#[test]
fn a_part_of_doubtful_unit_is_named_in_row_and_card() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (place.path().join("parts"), place.path().join("set"));
    fs::create_dir(&parts).expect("a folder");
    fs::write(parts.join("large.obj"), plate(5)).expect("a part");
    // 130 inches are 3.3 m.
    run(dataset(&parts, &out).args(["--unit", "inch", "--limit", "1"])).succeeds();
    let row = &lines(&out.join("manifest.jsonl"))[0];
    let doubt = row["measured"]["unit_doubts"][0].as_str().expect("a doubt");
    assert!(doubt.contains("very large") && doubt.contains("--unit mm"), "{doubt}");
    let card = fs::read_to_string(out.join("README.md")).expect("a card");
    assert!(card.contains("## Doubtful units") && card.contains(&format!("- `large.obj`: {doubt}")), "{card}");
    let usual = fs::read_to_string(undisturbed().1.join("README.md")).expect("a card");
    assert!(!usual.contains("Doubtful units"));
}

#[test]
fn items_of_one_part_share_their_split() {
    let rows = lines(&undisturbed().1.join("manifest.jsonl"));
    let splits: BTreeSet<(&str, &str)> = rows
        .iter()
        .map(|row| (row["source_sha256"].as_str().expect("a hash"), row["split"].as_str().expect("a split")))
        .collect();
    assert_eq!(splits.len(), 3, "{splits:?}");
}

#[test]
fn the_other_files_of_the_catalogue_fit_the_manifest() {
    let set = undisturbed().1;
    let rows = lines(&set.join("manifest.jsonl"));
    let mut table = csv::Reader::from_path(set.join("manifest.csv")).expect("a table");
    let columns = table.headers().expect("a header").clone();
    let length = columns.iter().position(|name| name == "measured.welds.0.length_mm").expect("a column");
    let records: Vec<csv::StringRecord> = table.records().map(|record| record.expect("a line")).collect();
    assert_eq!(records.len(), rows.len());
    for (record, row) in records.iter().zip(&rows) {
        assert_eq!(record[0], *row["id"].as_str().expect("a name"));
        assert_eq!(record[length].parse::<f64>().ok(), row["measured"]["welds"][0]["length_mm"].as_f64());
    }
    let croissant: Value =
        serde_json::from_slice(&fs::read(set.join("croissant.json")).expect("a file")).expect("JSON");
    assert_eq!(croissant["conformsTo"], "http://mlcommons.org/croissant/1.0");
    for file in croissant["distribution"].as_array().expect("files").iter().filter(|file| file.get("sha256").is_some())
    {
        let name = file["contentUrl"].as_str().expect("a name");
        assert_eq!(file["sha256"], FileRecord::of(&set.join(name)).expect("a file").sha256, "{name}");
    }
    assert_eq!(croissant["recordSet"][0]["field"].as_array().expect("fields").len(), columns.len());
    let sheet = image::open(set.join("contact-sheet.png")).expect("a picture");
    assert!(sheet.width() > 1900 && sheet.height() > 700, "{} x {}", sheet.width(), sheet.height());
    let card = fs::read_to_string(set.join("README.md")).expect("a card");
    assert!(card.contains("6 items from 3 parts, 0 failures") && card.contains("--diagonal=48"), "{card}");
}

#[test]
fn a_item_is_what_weld_makes_of_its_part_and_seed() {
    let (parts, set) = undisturbed();
    let row = &lines(&set.join("manifest.jsonl"))[1];
    let name = row["source"].as_str().expect("a name");
    let part = [parts.join(name), parts.join("below").join(name)].into_iter().find(|path| path.is_file());
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("asset");
    let options = WeldingOptions {
        seed: row["seed"].as_u64().expect("a seed"),
        fineness: Fineness::Diagonal(48),
        band_voxels: 3.0,
        sign: SignChoice::Auto,
        wishes: WeldSettings::default(),
    };
    let (part, silent) = (Part::load(&part.expect("the part"), UnitChoice::Auto).expect("a part"), Console::silent());
    let workpiece = weld_part(part, &options, &silent).expect("a welded part");
    let folder = StagedFolder::fresh(&out).expect("a folder");
    let extras =
        Extras { density: None, models: false, vdb: false, usd: UsdMode::Off, preview: (16, 12), samples_per_side: 1 };
    asset::write(&workpiece, &options, folder, extras, &silent).expect("an asset");
    let (mut alone, mut item) = (files(&out), files(&set.join(row["folder"].as_str().expect("a folder"))));
    // The two pictures differ in size, and the manifest holds the picture's hash.
    for name in ["preview.png", "asset.json"] {
        alone.remove(name).expect("it is there");
        item.remove(name).expect("it is there");
    }
    assert!(alone == item, "{:?}, {:?}", alone.keys(), item.keys());
}

#[test]
fn neither_jobs_nor_shards_nor_limits_nor_names_change_a_byte() {
    let (parts, whole) = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("set");
    run(dataset(parts, &out).args(["--jobs", "1", "--limit", "2"])).succeeds();
    assert_eq!(items(&out).len(), 2);
    for shard in ["2/2", "1/2"] {
        run(dataset(parts, &out).args(["--jobs", "3", "--resume", "--shard", shard])).succeeds();
    }
    assert_same(&out, whole);

    let renamed = place.path().join("renamed");
    fs::create_dir(&renamed).expect("a folder");
    fs::rename(plates(place.path()).join("a.obj"), renamed.join("z.obj")).expect("it can be renamed");
    let other = place.path().join("other");
    run(&mut dataset(&renamed, &other)).succeeds();
    let bytes = |set: &Path, item: &Path| fs::read(set.join("assets").join(item).join("phi.nvdb")).expect("a field");
    for item in items(&other) {
        let name = Path::new(item.file_name().expect("a name"));
        assert!(bytes(&other, name) == bytes(whole, name), "{}", name.display());
    }
}

#[test]
fn another_seed_gives_other_welds_under_the_same_names() {
    let (parts, set) = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("set");
    let mut command = robofin(["dataset", "--item", "1", "--limit", "1", "--seed", "8", "--diagonal", "48"]);
    run(command.arg(parts).arg("--out").arg(&out)).succeeds();
    let item = items(&out).remove(0);
    let same_name = set.join("assets").join(item.file_name().expect("a name"));
    let truth = |folder: &Path| fs::read(folder.join("welds.json")).expect("a truth file");
    assert_ne!(truth(&item), truth(&same_name));
}

#[test]
fn a_dry_run_names_the_items_and_makes_nothing() {
    let (parts, set) = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("set");
    let planned = run(dataset(parts, &out).args(["--dry-run", "--json"])).succeeds();
    assert!(!out.exists());
    let names: BTreeSet<String> = planned
        .stdout
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON")["item"].as_str().expect("a name").to_owned())
        .collect();
    let made = crate::program::names(&set.join("assets"));
    assert!(names.iter().eq(&made), "{names:?} planned, {made:?} made");
    let again = run(dataset(parts, set).args(["--dry-run"])).succeeds();
    assert!(again.stderr.contains("0 items would be made, 6 are there"), "{}", again.stderr);
}

#[test]
fn a_pipe_gets_a_line_for_each_item_with_the_time_left() {
    let (parts, _) = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("set");
    let told = run(dataset(parts, &out).args(["--limit", "3", "--json"])).succeeds();
    for count in ["1/3", "2/3", "3/3"] {
        assert_eq!(told.stderr.matches(&format!("{count} ")).count(), 1, "{}", told.stderr);
    }
    assert!(told.stderr.contains(" left") && told.stderr.contains("items an hour"), "{}", told.stderr);
    let answers: Vec<Value> = told.stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(answers.len(), 4, "three items and the summary");
    assert_eq!(answers[3]["made"], 3);
    assert!(answers[..3].iter().all(|answer| answer["ending"] == "made" && answer["cpu_s"].as_f64() > Some(0.0)));
}
