//! `bake` of folders: each mesh is baked once, even after interruptions.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::program::{Outcome, bracket, files, names, robofin, run};

/// Returns a closed wedge in millimetres as OBJ; each number gives a different mesh.
fn wedge(number: usize) -> String {
    let top = 20.0 + 0.5 * number as f64;
    format!("v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 {top}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
}

/// Writes a folder of `count` wedges, the last of them in a subfolder.
fn wedges(place: &Path, count: usize) -> PathBuf {
    let parts = place.join("parts");
    fs::create_dir_all(parts.join("below")).expect("a folder");
    for number in 0..count {
        let folder = if number + 1 == count { "below" } else { "" };
        fs::write(parts.join(folder).join(format!("wedge-{number:02}.obj")), wedge(number)).expect("a mesh file");
    }
    parts
}

fn bake(parts: &Path, out: &Path) -> Command {
    let mut command = robofin(["bake", "--json", "--resolution", "48"]);
    command.arg(parts).arg("--out").arg(out);
    command
}

fn lines(outcome: &Outcome) -> Vec<Value> {
    outcome.stdout.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

fn cached(outcome: &Outcome) -> Vec<bool> {
    lines(outcome).iter().map(|line| line["cached"].as_bool().expect("it did not fail")).collect()
}

/// Returns the lines without values that depend on the clock.
fn timeless(outcome: &Outcome) -> Vec<Value> {
    let mut lines = lines(outcome);
    for line in lines.iter_mut().filter_map(Value::as_object_mut) {
        line.retain(|key, _| key != "bake_s" && key != "process_s");
    }
    lines
}

#[test]
fn a_folder_becomes_one_field_for_each_content_and_none_twice() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (wedges(place.path(), 3), place.path().join("fields"));
    fs::copy(parts.join("wedge-00.obj"), parts.join("simulation.OBJ")).expect("a copy");
    fs::write(parts.join("notes.txt"), "no mesh").expect("written");
    fs::write(parts.join(".hidden.obj"), "no mesh").expect("written");

    let first = run(&mut bake(&parts, &out)).succeeds();
    let order: Vec<String> =
        lines(&first).iter().map(|line| line["mesh"].as_str().expect("a path").to_owned()).collect();
    let expected = ["below/wedge-02.obj", "simulation.OBJ", "wedge-00.obj", "wedge-01.obj"];
    assert_eq!(order, expected.map(|name| parts.join(name).display().to_string()));
    assert_eq!(cached(&first), [false, false, true, false]);
    for line in lines(&first) {
        let field = fs::read(line["out"].as_str().expect("a path")).expect("the field");
        assert_eq!(line["bytes"].as_u64(), Some(field.len() as u64));
        assert_eq!((&line["sign_method"], &line["open_edges"]), (&"crossings".into(), &0.into()));
        assert!(line["bricks"].as_u64() > Some(0) && line["active_voxels"].as_u64() > Some(0));
    }
    assert_eq!(names(&out).len(), 3 * 2 + 2);
    let index = fs::read_to_string(out.join("index.jsonl")).expect("an index");
    let (index, listed): (Vec<Value>, _) =
        (index.lines().map(|line| serde_json::from_str(line).expect("a line")).collect(), lines(&first));
    for (line, told) in index.iter().zip(&listed) {
        assert_eq!(line["mesh"], told["mesh"]);
        assert_eq!(out.join(line["field"].as_str().expect("a name")).to_str(), told["out"].as_str());
    }
    assert_eq!(index.len(), 4);

    let before = files(&out);
    run(&mut bake(&parts, &out)).is_refused(2, &["fields", "--resume", "--force"]);
    let again = run(bake(&parts, &out).arg("--resume")).succeeds();
    assert_eq!(cached(&again), [true; 4]);
    assert!(files(&out) == before);
}

#[test]
fn one_mesh_that_fails_costs_itself_alone_and_is_tried_again() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (wedges(place.path(), 2), place.path().join("fields"));
    let bad = parts.join("bad.obj");
    fs::write(&bad, "v 0 0 0\nv 1 0 0\nf 1 2 9\n").expect("written");
    let outcome = run(&mut bake(&parts, &out));
    outcome.is_refused(1, &["1 of 3 meshes failed", "--resume"]);
    let told = lines(&outcome);
    assert!(told[0]["error"].as_str().is_some_and(|error| error.contains("bad.obj")), "{told:?}");
    assert!(told[1..].iter().all(|line| line["cached"] == false), "{told:?}");
    assert_eq!(names(&out).len(), 2 * 2 + 2);
    fs::write(&bad, wedge(7)).expect("repaired");
    let outcome = run(bake(&parts, &out).arg("--resume")).succeeds();
    assert_eq!(cached(&outcome), [false, true, true]);
}

#[test]
fn damage_to_an_entry_is_noticed_and_repaired() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (wedges(place.path(), 1), place.path().join("fields"));
    run(&mut bake(&parts, &out)).succeeds();
    let whole = files(&out);
    let name = |suffix: &str| whole.keys().find(|name| name.ends_with(suffix) && name.len() > 60).expect("an entry");
    let (field, record) = (out.join(name(".nvdb")), out.join(name(".json")));
    let (field_bytes, record_bytes) = (&whole[name(".nvdb")], &whole[name(".json")]);
    let altered = |bytes: &[u8], at: usize| {
        let mut bytes = bytes.to_vec();
        bytes[at] ^= 1;
        bytes
    };
    let text = String::from_utf8(record_bytes.clone()).expect("text");
    let other_facts = text.replacen("\"bricks\": ", "\"bricks\": 1", 1).into_bytes();
    assert_ne!(&other_facts, record_bytes);
    for (path, content) in [
        (&field, Some(field_bytes[..field_bytes.len() - 1].to_vec())),
        (&field, Some(altered(field_bytes, field_bytes.len() / 2))),
        (&field, Some(Vec::new())),
        (&field, None),
        (&record, Some(record_bytes[..record_bytes.len() / 2].to_vec())),
        (&record, Some(other_facts)),
        (&record, None),
    ] {
        match content {
            Some(bytes) => fs::write(path, bytes).expect("it can be damaged"),
            None => fs::remove_file(path).expect("it can be removed"),
        }
        let outcome = run(bake(&parts, &out).arg("--resume")).succeeds();
        assert_eq!(cached(&outcome), [false], "{}", path.display());
        assert!(files(&out) == whole, "{} is repaired", path.display());
    }
}

#[test]
fn jobs_change_nothing_but_the_time() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = wedges(place.path(), 6);
    fs::copy(parts.join("wedge-03.obj"), parts.join("simulation.obj")).expect("a copy");
    let of = |jobs: &str| {
        let out = place.path().join("fields");
        let outcome = run(bake(&parts, &out).args(["--jobs", jobs])).succeeds();
        let found = (timeless(&outcome), files(&out));
        fs::remove_dir_all(&out).expect("ours");
        found
    };
    let alone = of("1");
    for jobs in ["2", "7"] {
        assert!(of(jobs) == alone, "--jobs {jobs}");
    }
}

#[test]
fn two_processes_share_the_work() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (wedges(place.path(), 8), place.path().join("fields"));
    let start = || run(bake(&parts, &out).args(["--resume", "--jobs", "2"]));
    let (one, two) = std::thread::scope(|scope| {
        let other = scope.spawn(start);
        (start().succeeds(), other.join().expect("no panic").succeeds())
    });
    for (mine, theirs) in cached(&one).into_iter().zip(cached(&two)) {
        assert!(mine != theirs, "each mesh is baked by one of them");
    }
    assert_eq!(names(&out).len(), 8 * 2 + 2, "{:?}", names(&out));
}

#[test]
fn what_is_finished_survives_a_kill_at_any_moment() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (wedges(place.path(), 6), place.path().join("fields"));
    let undisturbed = place.path().join("undisturbed");
    run(&mut bake(&parts, &undisturbed)).succeeds();
    let mut finished = BTreeMap::new();
    for moment in 1..40 {
        let mut child = bake(&parts, &out)
            .args(["--resume", "--jobs", "2"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program can be started");
        std::thread::sleep(Duration::from_millis(4 * moment));
        child.kill().expect("it can be killed");
        child.wait().expect("it ends");
        for (name, written) in &finished {
            assert_eq!(modified(&out.join(name)), *written, "{name} was finished, and written again");
        }
        finished = entries(&out, &files(&undisturbed));
        if finished.len() == 6 {
            break;
        }
    }
    fs::write(out.join(".cache.json.part-1"), "{").expect("what a kill leaves while the folder is marked");
    let outcome = run(bake(&parts, &out).arg("--resume")).succeeds();
    assert_eq!(cached(&outcome).iter().filter(|cached| **cached).count(), finished.len());
    assert!(files(&out) == files(&undisturbed), "nothing is left over: {:?}", names(&out));
}

fn modified(path: &Path) -> std::time::SystemTime {
    fs::metadata(path).and_then(|file| file.modified()).expect("the file is there")
}

/// Returns the existing records with their modification times; asserts that each has its complete field.
fn entries(out: &Path, whole: &BTreeMap<String, Vec<u8>>) -> BTreeMap<String, std::time::SystemTime> {
    if !out.exists() {
        return BTreeMap::new();
    }
    let is_record = |name: &String| name.ends_with(".json") && !name.starts_with('.') && name != "cache.json";
    let records = names(out).into_iter().filter(is_record);
    let times = records.map(|record| {
        let field = record.replace(".json", ".nvdb");
        assert!(fs::read(out.join(&field)).expect("its field") == whole[&field], "{field} is whole");
        let written = modified(&out.join(&record));
        (record, written)
    });
    times.collect()
}

#[test]
fn a_buffer_beside_a_gltf_counts_as_content() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (place.path().join("parts"), place.path().join("fields"));
    fs::create_dir(&parts).expect("a folder");
    let json = r#"{"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "buffers":[{"uri":"part.bin","byteLength":144}],"bufferViews":[{"buffer":0,"byteLength":144}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":12,"type":"VEC3","min":[0,0,0],"max":[1,1,1]}]}"#;
    fs::write(parts.join("part.gltf"), json).expect("written");
    let buffer = |top: f32| -> Vec<u8> {
        let corners = [[0.0, 0.0, 0.0], [0.02, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, top]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        faces.iter().flatten().flat_map(|&corner: &usize| corners[corner]).flat_map(f32::to_le_bytes).collect()
    };
    for (top, expected) in [(0.02, false), (0.03, false), (0.02, true)] {
        fs::write(parts.join("part.bin"), buffer(top)).expect("written");
        let outcome = run(bake(&parts, &out).arg("--resume")).succeeds();
        assert_eq!(cached(&outcome), [expected], "{top}");
    }
}

#[test]
fn a_cache_inside_its_own_source_is_no_source() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = wedges(place.path(), 2);
    let out = parts.join("fields");
    assert_eq!(cached(&run(&mut bake(&parts, &out)).succeeds()), [false; 2]);
    assert_eq!(cached(&run(bake(&parts, &out).arg("--resume")).succeeds()), [true; 2]);
}

#[test]
fn force_empties_a_cache_and_nothing_else() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (wedges(place.path(), 2), place.path().join("fields"));
    run(bake(&parts, &out).args(["--band", "4"])).succeeds();
    fs::write(out.join("notes.txt"), "mine").expect("written");
    let outcome = run(bake(&parts, &out).arg("--force")).succeeds();
    assert_eq!(cached(&outcome), [false; 2]);
    assert_eq!(names(&out).len(), 2 * 2 + 3);
    assert_eq!(fs::read(out.join("notes.txt")).expect("it is there"), b"mine");
}

#[test]
fn places_and_flags_that_do_not_fit_are_wrong_use() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = wedges(place.path(), 1);
    let at = |name: &str| place.path().join(name);
    fs::create_dir(at("empty")).expect("a folder");
    fs::create_dir(at("thesis")).expect("a folder");
    fs::write(at("thesis/chapter.txt"), "years of work").expect("written");
    fs::write(at("file"), "mine").expect("written");
    let before = names(place.path());

    run(&mut bake(&at("absent"), &at("out"))).is_refused(2, &["absent", "no such file"]);
    run(bake(&parts, &at("out")).arg(at("absent"))).is_refused(2, &["absent", "no such file or folder"]);
    run(&mut bake(&at("empty"), &at("out"))).is_refused(2, &["empty", "without a mesh file", ".stl"]);
    run(&mut bake(&parts, &at("file"))).is_refused(2, &["file", "already exists", "folder"]);
    run(&mut bake(&parts, &at("thesis"))).is_refused(2, &["thesis", "already exists"]);
    run(&mut bake(&parts, &parts)).is_refused(2, &["parts", "already exists"]);
    run(bake(&parts, &at("thesis")).arg("--force")).is_refused(2, &["thesis", "cache.json"]);
    run(bake(&parts, &at("thesis")).arg("--resume")).is_refused(2, &["thesis", "cache.json"]);
    run(bake(&parts, &at("out")).args(["--resume", "--force"])).is_refused(2, &["--resume", "--force"]);
    for jobs in ["0", "-1", "1000000", "many"] {
        run(bake(&parts, &at("out")).args(["--jobs", jobs])).is_refused(2, &["--jobs", jobs]);
    }
    run(&mut robofin(["bake", "--out", "out"])).is_refused(2, &["required"]);
    assert_eq!(names(place.path()), before);
    assert_eq!(names(&at("thesis")), ["chapter.txt"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_place_that_cannot_be_written_is_named_before_the_work() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = wedges(place.path(), 1);
    for out in [Path::new("/proc/fields"), &bracket().join("fields")] {
        let outcome = run(&mut bake(&parts, out));
        outcome.is_refused(1, &["cannot", "fields"]);
        assert!(outcome.stdout.is_empty(), "{}", outcome.stdout);
    }
    let out = place.path().join("fields");
    fs::create_dir(&out).expect("a folder");
    fs::write(out.join("cache.json"), "{\"format\":\"robofin-cache/99\"}").expect("written");
    run(bake(&parts, &out).arg("--resume")).is_refused(1, &["cache.json", "robofin-cache/99", "robofin-cache/1"]);
}
