//! Sets of labelled images: made, interrupted, damaged, repaired, and opened by pycocotools.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::thread::sleep;
use std::time::Duration;

use export::python::{Script, find};
use serde_json::Value;
use tempfile::TempDir;

use crate::program::{names, robofin, run};
use crate::set::{assert_same, lines, tree};

/// Number of images in the small set: one workpiece, three placements, two patterns in two stages, two references.
const IMAGES: usize = 3 * (2 * 2 + 2);

/// Returns `robofin dataset images` for a small, coarse set.
fn images(out: &Path) -> Command {
    images_of(out, ["5", "1.5"])
}

/// Returns the same command with another seed and voxel [mm].
fn images_of(out: &Path, [seed, voxel]: [&str; 2]) -> Command {
    let mut command =
        robofin(["dataset", "images", "--workpieces", "panel", "--placements", "3", "--split-by", "placement"]);
    command.args(["--patterns", "spiral,spots", "--stages", "2", "--size", "64x48"]);
    command.args(["--seed", seed, "--voxel-mm", voxel]).arg("--out").arg(out);
    command
}

/// Returns a small set made in one run; tests must not change it.
fn undisturbed() -> &'static Path {
    static PLACE: LazyLock<(TempDir, PathBuf)> = LazyLock::new(|| {
        let place = tempfile::tempdir().expect("a temporary folder");
        let out = place.path().join("images");
        run(images(&out).args(["--jobs", "2"])).succeeds();
        (place, out)
    });
    &PLACE.1
}

fn copy_of_set(place: &Path) -> PathBuf {
    let out = place.join("images");
    for (name, content) in tree(undisturbed()) {
        let path = out.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("it can be made");
        fs::write(path, content).expect("a copied file");
    }
    fs::create_dir_all(out.join("failures")).expect("it can be made");
    out
}

/// Returns the lines of all splits.
fn rows_of(set: &Path) -> Vec<Value> {
    let files = ["train", "validation", "test"].map(|split| set.join(split).join("metadata.jsonl"));
    files.iter().filter(|file| file.exists()).flat_map(|file| lines(file)).collect()
}

/// Returns the number of images of all splits.
fn image_count(set: &Path) -> usize {
    ["train", "validation", "test"].map(|split| names(&set.join(split).join("images")).len()).into_iter().sum()
}

fn labels(set: &Path, folder: &str, id: &str) -> Vec<u8> {
    let image = image::open(set.join(folder).join(format!("{id}.png"))).expect("a picture");
    assert_eq!((image.width(), image.height()), (64, 48));
    image.as_luma8().expect("one channel").as_raw().clone()
}

#[test]
fn every_image_has_labels_of_known_classes_and_a_line_that_says_what_it_shows() {
    let set = undisturbed();
    let rows = rows_of(set);
    assert_eq!(rows.len(), IMAGES);
    for row in &rows {
        let id = row["id"].as_str().expect("a name");
        let split = row["split"].as_str().expect("a split");
        let picture = image::open(set.join(split).join(row["file_name"].as_str().expect("a path")))
            .expect("a picture")
            .into_rgb8();
        assert_eq!((picture.width(), picture.height()), (64, 48));
        for (folder, key) in [("appearance", "appearance_pixels"), ("dose", "dose_pixels")] {
            let labels = labels(set, folder, id);
            let count = |class: u8| labels.iter().filter(|&&label| label == class).count();
            let counts = [0, 1, 2, 255].map(count);
            assert_eq!(counts.iter().sum::<usize>(), 64 * 48, "{id}: other labels");
            assert_eq!(row[key], serde_json::json!(counts), "{id}");
            match row["treatment"]["kind"].as_str() {
                Some("unsanded") => assert_eq!(counts[1], 0, "{id}"),
                Some("bare") => assert_eq!(counts[2], 0, "{id}"),
                _ => {}
            }
        }
        assert!(row["agreement"].as_f64().expect("a number") > 0.98, "{id}: {row}");
        let scene: Value = serde_json::from_str(row["scene"].as_str().unwrap()).unwrap();
        assert!(scene["camera"]["vertical_field_of_view"].as_f64().is_some_and(|angle| angle > 0.2));
    }
    let splits: BTreeSet<(u64, &str)> = rows
        .iter()
        .map(|row| (row["placement"].as_u64().expect("a number"), row["split"].as_str().expect("one")))
        .collect();
    assert_eq!(splits.len(), 3, "{splits:?}");
}

#[test]
fn sanding_goes_on_from_stage_to_stage_and_the_references_are_its_ends() {
    let rows = rows_of(undisturbed());
    let share = |placement: u64, name: &str| {
        let id = format!("panel-p{placement:02}-{name}");
        let row = rows.iter().find(|row| row["id"] == *id).expect("it is there");
        row["exposed_share"].as_f64().expect("a number")
    };
    for placement in 0..3 {
        assert_eq!((share(placement, "unsanded"), share(placement, "bare")), (0.0, 1.0));
        for pattern in ["spiral", "spots"] {
            let [one, two] = [1, 2].map(|stage| share(placement, &format!("{pattern}-s{stage}")));
            assert!(0.02 < one && one < two && two < 0.9, "{pattern} in placement {placement}: {one}, {two}");
        }
    }
}

#[test]
fn neither_jobs_nor_limits_change_a_byte_and_a_killed_run_goes_on() {
    let whole = undisturbed();
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("images");
    run(images(&out).args(["--limit", "2", "--jobs", "1"])).succeeds();
    assert_eq!(image_count(&out), 2);
    for delay in [40, 120, 250] {
        let mut command = images(&out);
        command.args(["--resume", "--jobs", "3"]).stdout(Stdio::null()).stderr(Stdio::null());
        let mut child = command.spawn().expect("the program can be started");
        sleep(Duration::from_millis(delay));
        child.kill().expect("the program can be killed");
        child.wait().expect("the program ends");
    }
    run(images(&out).args(["--resume", "--jobs", "2"])).succeeds();
    assert_same(&out, whole);
}

#[test]
fn a_limited_set_has_both_references_and_a_larger_limit_goes_on_with_it() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("images");
    run(images(&out).args(["--limit", "6", "--jobs", "2"])).succeeds();
    let states = || {
        let rows = rows_of(&out);
        let state = |row: &Value| row["treatment"]["kind"].as_str().expect("a state").to_owned();
        let count = |kind: &str| rows.iter().filter(|row| state(row) == kind).count();
        ["unsanded", "stage", "bare"].map(count)
    };
    assert_eq!(states(), [1, 4, 1], "one of the six treatments each");
    let more = run(images(&out).args(["--limit", "12", "--jobs", "2", "--resume"])).succeeds();
    assert_eq!(states(), [2, 8, 2]);
    assert_eq!(more.stderr.matches("      made  ").count(), 6, "only what was not there: {}", more.stderr);
}

#[test]
fn damage_is_found_and_only_what_is_broken_is_made_again() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let set = copy_of_set(place.path());
    run(robofin(["validate"]).arg(&set)).succeeds();
    let label = set.join("dose/panel-p01-spiral-s2.png");
    let mut bytes = fs::read(&label).expect("a label");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&label, bytes).expect("written");
    fs::remove_file(set.join("records/panel-p00-bare.json")).expect("removed");
    fs::write(set.join("fields/panel-spots/stage-1.nvdb"), "no field").expect("written");
    let told = run(robofin(["validate"]).arg(&set));
    told.is_refused(1, &["broken", "--repair"]);
    for id in ["panel-p01-spiral-s2", "panel-p00-bare", "panel-spots"] {
        assert!(told.stderr.lines().any(|line| line.contains("BROKEN") && line.contains(id)), "{}", told.stderr);
    }
    let repaired = run(robofin(["validate", "--repair"]).arg(&set)).succeeds();
    assert_eq!(repaired.stderr.matches("      made  ").count(), 3, "{}", repaired.stderr);
    assert_same(&set, undisturbed());

    let annotations = set.join("train/dose.json");
    let text = fs::read_to_string(&annotations).expect("text");
    fs::write(&annotations, text.replacen("\"area\":", "\"area\":1", 1)).expect("written");
    run(robofin(["validate"]).arg(&set)).is_refused(1, &["1 faults in the catalogue"]);
}

#[test]
fn what_cannot_be_made_is_listed_with_the_line_that_shows_it_again() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("images");
    run(images_of(&out, ["5", "0.2"]).args(["--limit", "4", "--time-limit", "0.1"]))
        .is_refused(1, &["failed", "failures.jsonl", "--resume"]);
    let failures = lines(&out.join("failures.jsonl"));
    let first = failures.iter().find(|failure| failure["id"] == "panel").expect("the workpiece took too long");
    assert_eq!(first["stage"], "limit");
    let command = first["command"].as_str().expect("a line");
    assert!(command.contains("dataset images --seed=5 --workpieces=panel"), "{command}");
    assert!(command.ends_with("--only panel --out again"), "{command}");
    let is_unsanded = |failure: &&Value| failure["id"].as_str().is_some_and(|id| id.ends_with("-unsanded"));
    let waiting = failures.iter().find(is_unsanded).expect("it needs the panel");
    assert!(waiting["reason"].as_str().is_some_and(|reason| reason.contains("needs panel")), "{waiting}");
}

#[test]
fn nonsense_is_refused_with_what_would_be_accepted() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("images");
    for (flag, value, words) in [
        ("--placements", "0", "1 to 99"),
        ("--stages", "100", "1 to 99"),
        ("--size", "64", "WIDTHxHEIGHT"),
        ("--voxel-mm", "0", "accepted"),
        ("--workpieces", "spaceship", "bracket, panel, tee"),
        ("--looks", "glitter", "texture, swirl"),
        ("--split-by", "day", "placement"),
        ("--workpieces", "panel,panel", "twice"),
        ("--limit", "0", "1 or more"),
        ("--only", "panel-p99-bare", "no"),
        ("--patterns", "zigzag", "spiral"),
    ] {
        let mut command = robofin(["dataset", "images"]);
        let told = run(command.arg("--out").arg(&out).arg(format!("{flag}={value}")));
        assert_eq!(told.status.code(), Some(2), "{flag} {value}: {}", told.stderr);
        assert!(told.stderr.contains(flag) && told.stderr.contains(words), "{flag} {value}: {}", told.stderr);
    }
    assert!(!out.exists());
    run(&mut images(undisturbed())).is_refused(2, &["is a data set already", "--resume"]);
    run(images_of(undisturbed(), ["6", "1.5"]).arg("--resume")).is_refused(2, &["seed", "5 there, and 6 now"]);
}

#[test]
fn files_for_scenes_are_refused_by_name_with_what_is_accepted() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let [out, picture, meshes] = ["images", "hall.hdr", "meshes"].map(|name| place.path().join(name));
    std::fs::write(&picture, "no picture").expect("a file");
    let output = run(images(&out).arg("--environment").arg(&picture));
    output.is_refused(1, &["hall.hdr", "Radiance format (.hdr, RGBE) is accepted"]);
    std::fs::create_dir(&meshes).expect("a folder");
    // A pyramid without one of its sides.
    let corners = "v 0 0 0\nv 10 0 0\nv 10 10 0\nv 0 10 0\nv 5 5 10\n";
    let open = format!("{corners}f 1 3 2\nf 1 4 3\nf 1 2 5\nf 2 3 5\nf 3 4 5\n");
    std::fs::write(meshes.join("flap.obj"), open).expect("a file");
    let output = run(images(&out).arg("--clutter").arg(&meshes));
    output.is_refused(1, &["--clutter", "flap.obj", "3 boundary edges, and a closed mesh is accepted"]);
    std::fs::write(meshes.join("flap.obj"), "f 1 2 3\n").expect("a file");
    run(images(&out).arg("--clutter").arg(&meshes)).is_refused(1, &["flap.obj"]);
    assert!(!out.exists());
    // A closed mesh is used, and the other one is named.
    std::fs::write(
        meshes.join("pyramid.obj"),
        format!("{corners}f 1 3 2\nf 1 4 3\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"),
    )
    .expect("a file");
    let output = run(images(&out).arg("--clutter").arg(&meshes).args(["--limit", "1"])).succeeds();
    assert!(output.stderr.contains("left out") && output.stderr.contains("flap.obj"), "{}", output.stderr);
    let recipe = std::fs::read_to_string(out.join("dataset.json")).expect("the recipe");
    assert!(recipe.contains("pyramid.obj") && recipe.contains("flap.obj"), "{recipe}");
}

#[test]
fn a_dry_run_names_everything_and_makes_nothing() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let out = place.path().join("images");
    let told = run(images(&out).args(["--dry-run", "--json"])).succeeds();
    let ids: Vec<Value> = told.stdout.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert_eq!(ids.len(), 1 + 2 + 3 + IMAGES);
    assert!(ids.iter().all(|answer| answer["is_there"] == false) && !out.exists());
    for (turn, answer) in ids.iter().enumerate() {
        let is_before = |need: &Value| ids[..turn].iter().any(|other| other["task"] == *need);
        assert!(answer["needs"].as_array().is_some_and(|needs| needs.iter().all(is_before)), "{answer}");
    }
    let needs = |answer: &Value| answer["needs"].as_array().map_or(0, Vec::len);
    assert!(needs(&ids[0]) == 0 && ids.iter().map(needs).max() == Some(3), "a workpiece, a simulation and a view");
    let whole = run(robofin(["dataset", "images", "--dry-run", "--json", "--out"]).arg(&out)).succeeds();
    assert_eq!(whole.stdout.lines().count(), 6 + 36 + 24 + 768);
    let quick = robofin(["dataset", "images", "--quick", "--dry-run", "--json"]).current_dir(place.path()).output();
    let quick = String::from_utf8(quick.expect("the program runs").stdout).expect("text");
    let states = ["-unsanded\"", "-s1\"", "-s2\"", "-s3\"", "-s4\"", "-s5\"", "-bare\""];
    let counts = states.map(|state| quick.matches(state).count());
    assert_eq!(counts.iter().sum::<usize>(), 24, "{counts:?}");
    assert!(counts.iter().all(|&count| count > 0), "{counts:?}");
}

#[test]
fn pycocotools_finds_the_masks_areas_and_boxes_of_the_labels() {
    // Written to standard error directly, because the test harness captures `eprintln!`.
    let mut say = |line: &str| writeln!(std::io::stderr(), "{line}").expect("standard error is open");
    let python = match find(Some(&mut say)) {
        Ok(python) => python,
        Err(error) => {
            let promised = std::env::var_os("ROBOFIN_REQUIRE_OUTSIDE").is_some_and(|value| value == "1");
            assert!(!promised, "ROBOFIN_REQUIRE_OUTSIDE=1, but COCO files cannot be tested: {error}");
            return writeln!(std::io::stderr(), "NOT TESTED: COCO files against pycocotools: {error}")
                .expect("it is open");
        }
    };
    let answer = python.run_script(Script::CheckCoco, [undisturbed()]).expect("pycocotools reads the files");
    assert_eq!(answer["faults"], serde_json::json!([]));
    let count = |key: &str| answer[key].as_u64().expect("a number") as usize;
    assert_eq!((count("files"), count("images")), (6, 2 * IMAGES));
    let view = |row: &Value| std::fs::read(undisturbed().join(row["view"].as_str().unwrap())).unwrap();
    let shows_tool = |row: &Value| serde_json::from_slice::<Value>(&view(row)).unwrap()["tool"].is_object();
    let tools = rows_of(undisturbed()).iter().filter(|&row| shows_tool(row)).count();
    assert!(tools > 0 && tools < IMAGES, "{tools}");
    // The workpiece in every image, both classes in the four stages of a placement and one in its references, no weld.
    assert_eq!(count("annotations"), 2 * (IMAGES + 3 * (2 * 4 + 2) + tools));
}
