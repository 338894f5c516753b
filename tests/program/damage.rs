//! `validate` detects every damage, and not by the hashes alone.

use std::fs;
use std::path::Path;

use robofin::asset::{MANIFEST_FILE, Manifest, record_files, write_json};
use serde_json::{Value, json};

use crate::program::{Outcome, copy_of_asset, names, robofin, run};

/// Rewrites the manifest with the hashes of the folder's current files.
fn forge_manifest(asset: &Path) {
    let mut manifest = Manifest::read(asset).expect("a manifest");
    manifest.files = record_files(asset).expect("a folder");
    manifest.files.remove(MANIFEST_FILE);
    write_json(&asset.join(MANIFEST_FILE), &manifest).expect("a manifest");
}

fn validated(asset: &Path) -> Outcome {
    run(robofin(["validate", "--json", "--usd", "off"]).arg(asset))
}

/// Lists files and rules of the failed checks.
fn failures(outcome: &Outcome) -> Vec<String> {
    let answer = outcome.answer();
    let checks = answer["checks"].as_array().expect("a list of checks").clone();
    let failed = checks.iter().filter(|check| check["passed"] == false);
    let text = |value: &Value| value.as_str().expect("text").to_owned();
    failed
        .map(|check| format!("{}: {} ({})", text(&check["file"]), text(&check["rule"]), text(&check["found"])))
        .collect()
}

/// Damages a copy; returns the failed checks with the old manifest and with one that has the new hashes.
fn damaged(damage: impl Fn(&Path)) -> [Vec<String>; 2] {
    [false, true].map(|forged| {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let asset = copy_of_asset(folder.path());
        damage(&asset);
        if forged {
            forge_manifest(&asset);
        }
        let outcome = validated(&asset);
        outcome.is_refused(1, &["checks failed"]);
        failures(&outcome)
    })
}

fn rewrite(path: &Path, change: impl Fn(&mut Vec<u8>)) {
    let mut bytes = fs::read(path).expect("a file");
    change(&mut bytes);
    fs::write(path, bytes).expect("it can be written");
}

fn edit_json(path: &Path, change: impl Fn(&mut Value)) {
    let mut value: Value = serde_json::from_slice(&fs::read(path).expect("a file")).expect("JSON");
    change(&mut value);
    write_json(path, &value).expect("it can be written");
}

#[track_caller]
fn assert_named(found: &[String], words: &str) {
    assert!(found.iter().any(|line| line.contains(words)), "{words:?} is missing in {found:#?}");
}

#[test]
fn a_forged_manifest_without_damage_is_valid() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = copy_of_asset(folder.path());
    forge_manifest(&asset);
    validated(&asset).succeeds();
}

#[test]
fn a_flipped_bit_in_any_file_is_noticed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = copy_of_asset(folder.path());
    for name in names(&asset).iter().filter(|name| *name != MANIFEST_FILE) {
        for place in [0, 1, 2] {
            let flip = |bytes: &mut Vec<u8>| {
                let at = place * (bytes.len() - 1) / 2;
                bytes[at] ^= 0x10;
            };
            rewrite(&asset.join(name), flip);
            let outcome = validated(&asset);
            outcome.is_refused(1, &[]);
            assert_named(&failures(&outcome), &format!("{name}: has the size and hash"));
            rewrite(&asset.join(name), flip);
        }
    }
    validated(&asset).succeeds();
}

#[test]
fn a_field_with_bad_bytes_is_noticed_without_the_hash() {
    for name in ["phi.nvdb", "weld.nvdb"] {
        let [_, forged] = damaged(|asset| {
            rewrite(&asset.join(name), |bytes| {
                // One bit of compressed bytes may leave the decompressed content unchanged.
                let at = bytes.len() / 2;
                bytes[at..at + 256].iter_mut().for_each(|byte| *byte ^= 0x55);
            });
        });
        assert_named(&forged, "can be opened");
    }
}

#[test]
fn a_damaged_manifest_is_refused() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = copy_of_asset(folder.path());
    let manifest = asset.join(MANIFEST_FILE);
    let sound = fs::read(&manifest).expect("a manifest");
    for (text, words) in
        [("", "not a manifest"), ("{}", "not a manifest"), ("[1", "not a manifest"), ("\0", "not a manifest")]
    {
        fs::write(&manifest, text).expect("it can be written");
        validated(&asset).is_refused(1, &["asset.json", words, "robofin-asset/1"]);
    }
    fs::write(&manifest, &sound).expect("it can be written");
    edit_json(&manifest, |value| value["format"] = json!("robofin-asset/2"));
    validated(&asset).is_refused(1, &["asset.json", "robofin-asset/2", "robofin-asset/1"]);
    fs::write(&manifest, [0xff, 0xfe]).expect("it can be written");
    validated(&asset).is_refused(1, &["asset.json"]);
}

#[test]
fn a_manifest_that_names_other_figures_is_noticed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = copy_of_asset(folder.path());
    for key in ["weld_volume_mm3", "weld_length_mm"] {
        let change = |factor: f64| {
            edit_json(&asset.join(MANIFEST_FILE), |value| {
                value["checks"][key] = json!(value["checks"][key].as_f64().expect("a number") * factor);
            });
        };
        change(1.5);
        let outcome = validated(&asset);
        outcome.is_refused(1, &[]);
        assert_named(&failures(&outcome), key);
        change(1.0 / 1.5);
    }
}

#[test]
fn a_removed_file_is_noticed() {
    let names = ["phi.nvdb", "preview.png", "surface.glb", "weld.nvdb", "welded.glb", "welds.json", "workpiece.glb"];
    for name in names {
        let [honest, forged] = damaged(|asset| fs::remove_file(asset.join(name)).expect("it was there"));
        assert_named(&honest, "the file is missing");
        assert_named(&forged, name);
    }
}

#[test]
fn an_extra_file_is_noticed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = copy_of_asset(folder.path());
    fs::write(asset.join("notes.txt"), "mine").expect("it can be written");
    let outcome = validated(&asset);
    outcome.is_refused(1, &[]);
    assert_named(&failures(&outcome), "notes.txt");
}

#[test]
fn an_extra_folder_is_noticed_by_its_name() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = copy_of_asset(folder.path());
    fs::create_dir(asset.join("grind")).expect("it can be made");
    let outcome = validated(&asset);
    outcome.is_refused(1, &[]);
    let found = failures(&outcome);
    assert_named(&found, "grind");
    assert_eq!(found.len(), 1, "the other files are still checked: {found:#?}");
}

#[test]
fn changed_numbers_of_the_truth_are_noticed_without_the_hash() {
    let scaled = |value: &Value| json!(value.as_f64().expect("a number") * 1.05);
    let figures = [
        "volume_mm3",
        "length_mm",
        "exposure_mean",
        "exposure_min",
        "access_mean",
        "geodesic_curvature_rms_per_m",
        "geodesic_curvature_max_per_m",
    ];
    for figure in figures {
        let [_, forged] = damaged(|asset| {
            edit_json(&asset.join("welds.json"), |truth| {
                let value = scaled(&truth["welds"][0][figure]);
                truth["welds"][0][figure] = value;
            });
        });
        assert_named(&forged, "weld 1");
    }
}

#[test]
fn a_changed_curve_is_noticed_without_the_hash() {
    let changes: [(&str, Value); 5] = [
        ("position", json!([0.0, 0.0, 0.0])),
        ("normal", json!([0.0, 0.0, 2.0])),
        ("arc_length", json!(-1.0)),
        ("exposure", json!(1.5)),
        ("tangent", json!([1.0, 1.0, 1.0])),
    ];
    for (list, value) in changes {
        let [_, forged] = damaged(|asset| {
            edit_json(&asset.join("welds.json"), |truth| truth["welds"][0]["curve"][list][3] = value.clone());
        });
        assert_named(&forged, "weld 1");
    }
}

#[test]
fn what_is_no_number_is_noticed_without_the_hash() {
    for text in ["null", "NaN", "\"12\"", "1e999"] {
        let [_, forged] = damaged(|asset| {
            rewrite(&asset.join("welds.json"), |bytes| {
                let truth = String::from_utf8(bytes.clone()).expect("text");
                let (before, after) = truth.split_once("\"volume_mm3\": ").expect("a volume");
                let (_, after) = after.split_once(',').expect("another entry");
                *bytes = format!("{before}\"volume_mm3\": {text},{after}").into_bytes();
            });
        });
        assert_named(&forged, "not a truth file");
    }
}

#[test]
fn a_truth_file_of_an_earlier_version_is_refused_with_the_field_it_lacks() {
    let without = |path: &'static str| {
        damaged(move |asset| {
            edit_json(&asset.join("welds.json"), |truth| {
                let (parent, field) = path.rsplit_once('/').expect("a path");
                let parent = truth.pointer_mut(parent).and_then(Value::as_object_mut);
                parent.expect("an object").remove(field).expect("the field is there");
            });
        })
    };
    for (path, field) in [("/welds/0/joint", "joint"), ("/welds/0/requested/exposure_reach_mm", "exposure_reach_mm")] {
        let [_, forged] = without(path);
        for words in
            ["welds.json: not a truth file", "is made again by `robofin weld`", &format!("missing field `{field}`")]
        {
            assert_named(&forged, words);
        }
    }
    // Files of earlier versions have no toe radius, and their toes are sharp.
    let folder = tempfile::tempdir().expect("a temporary folder");
    let asset = copy_of_asset(folder.path());
    edit_json(&asset.join("welds.json"), |truth| {
        truth["welds"][0].as_object_mut().expect("an object").remove("toe_radius_mm").expect("the field is there");
    });
    forge_manifest(&asset);
    validated(&asset).succeeds();
}

#[test]
fn welds_without_truth_and_truth_without_welds_are_noticed_without_the_hash() {
    let [_, forged] = damaged(|asset| edit_json(&asset.join("welds.json"), |truth| truth["welds"] = json!([])));
    assert_named(&forged, "weld");
    let [_, forged] = damaged(|asset| edit_json(&asset.join("welds.json"), |truth| truth["welds"][0]["id"] = json!(2)));
    assert_named(&forged, "weld 2");
    let [_, forged] = damaged(|asset| {
        edit_json(&asset.join("welds.json"), |truth| {
            let twice = truth["welds"][0].clone();
            truth["welds"].as_array_mut().expect("a list").push(twice);
        });
    });
    assert_named(&forged, "id");
}

#[test]
fn truncated_fields_are_noticed_without_the_hash() {
    for name in ["phi.nvdb", "weld.nvdb"] {
        for share in [0, 1, 2] {
            let [_, forged] =
                damaged(|asset| rewrite(&asset.join(name), |bytes| bytes.truncate(share * (bytes.len() - 1) / 2)));
            assert_named(&forged, name);
        }
    }
}

#[test]
fn swapped_files_are_noticed_without_the_hash() {
    for (one, two) in [("workpiece.glb", "welded.glb"), ("phi.nvdb", "weld.nvdb")] {
        let [_, forged] = damaged(|asset| {
            fs::rename(asset.join(one), asset.join("spare")).expect("it was there");
            fs::rename(asset.join(two), asset.join(one)).expect("it was there");
            fs::rename(asset.join("spare"), asset.join(two)).expect("it was there");
        });
        assert_named(&forged, one);
    }
    let [_, forged] = damaged(|asset| {
        fs::copy(asset.join("workpiece.glb"), asset.join("welded.glb")).expect("it was there");
    });
    assert_named(&forged, "welded.glb holds 1 meshes");
}

#[test]
fn what_is_no_asset_is_refused_with_what_would_be() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    validated(folder.path()).is_refused(1, &["asset.json", "made by `robofin weld`"]);
    validated(&folder.path().join("absent")).is_refused(1, &["absent", "made by `robofin weld`"]);
    let file = folder.path().join("file");
    fs::write(&file, "x").expect("it can be written");
    validated(&file).is_refused(1, &["file", "made by `robofin weld`"]);
}
