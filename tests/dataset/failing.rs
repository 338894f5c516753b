//! Parts that cannot be welded, and exceeded limits: each affects only its own items.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::program::{names, run};
use crate::set::{dataset, items, lines, plates, tree};

/// Breaks parts in different ways, by name.
fn break_parts(parts: &Path) {
    let plate = fs::read_to_string(parts.join("a.obj")).expect("a part");
    let files: [(&str, Vec<u8>); 6] = [
        ("nan.obj", plate.replacen("v 0 0 0", "v nan 0 0", 1).into_bytes()),
        ("cut.obj", plate.as_bytes()[..plate.len() / 2].to_vec()),
        ("cut.stl", [&[0u8; 80][..], &100u32.to_le_bytes(), &[1; 70]].concat()),
        ("empty.stl", Vec::new()),
        ("beside.gltf", br#"{"asset":{"version":"2.0"},"buffers":[{"uri":"gone.bin","byteLength":12}]}"#.to_vec()),
        ("flat.obj", b"v 0 0 0\nv 50 0 0\nv 0 50 0\nf 1 2 3\n".to_vec()),
    ];
    for (name, bytes) in &files {
        fs::write(parts.join(name), bytes).expect("a part");
    }
}

#[test]
fn broken_parts_cost_their_own_items_and_are_listed_with_reasons() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = plates(place.path());
    break_parts(&parts);
    let out = place.path().join("set");
    let command = || {
        let mut command = dataset(&parts, &out);
        command.args(["--jobs", "2"]);
        command
    };
    let first = run(&mut command());
    first.is_refused(1, &["items failed", "failures.jsonl", "--resume"]);
    assert_eq!(items(&out).len(), 6, "the good parts are there");
    let failures = lines(&out.join("failures.jsonl"));
    let sources: Vec<&str> = failures.iter().filter_map(|failure| failure["source"].as_str()).collect();
    for name in ["nan.obj", "cut.obj", "cut.stl", "empty.stl", "beside.gltf", "flat.obj"] {
        assert!(sources.iter().any(|source| source.ends_with(name)), "{name} is not among {sources:?}");
    }
    assert!(failures.iter().all(|failure| failure["reason"].as_str().is_some_and(|reason| reason.len() > 20)));
    assert!(failures.iter().all(|failure| failure["stage"] != "crash"), "{failures:?}");
    let before = tree(&out);
    run(command().arg("--resume")).is_refused(1, &["items failed"]);
    assert!(tree(&out) == before, "trying again changed something");
}

#[cfg(unix)]
#[test]
fn the_line_of_a_failure_shows_it_again_and_a_mended_part_ends_it() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = plates(place.path());
    for name in ["a.obj", "b.obj", "below/c.obj"] {
        fs::remove_file(parts.join(name)).expect("it can be removed");
    }
    let bad = parts.join("it's bad.obj");
    fs::write(&bad, "v 0 0 0\nv 50 0 0\nv 0 50 0\nf 1 2 3\n").expect("a part");
    let out = place.path().join("set");
    run(&mut dataset(&parts, &out)).is_refused(1, &["2 of 2 items failed"]);
    let failures = lines(&out.join("failures.jsonl"));
    let line = failures[1]["command"].as_str().expect("a command line");

    let again = place.path().join("again");
    fs::create_dir(&again).expect("a folder");
    let script = line.replacen("robofin", env!("CARGO_BIN_EXE_robofin"), 1);
    let mut shell = Command::new("sh");
    run(shell.args(["-c", &script]).current_dir(&again)).is_refused(1, &["1 of 1 items failed"]);
    let shown: Vec<Value> = lines(&again.join("again/failures.jsonl"));
    assert_eq!((&shown[0]["id"], &shown[0]["reason"]), (&failures[1]["id"], &failures[1]["reason"]));

    fs::remove_dir_all(place.path().join("set")).expect("it can be removed");
    fs::write(&bad, "").expect("a part that cannot be read at all");
    run(&mut dataset(&parts, &out)).is_refused(1, &["failed"]);
    plates(place.path());
    fs::copy(parts.join("a.obj"), &bad).expect("it can be repaired");
    run(dataset(&parts, &out).args(["--resume", "--limit", "1"])).succeeds();
    assert_eq!(lines(&out.join("failures.jsonl")), Vec::<Value>::new());
    assert_eq!(names(&out.join("failures")), Vec::<String>::new());
}

#[cfg(unix)]
#[test]
fn limits_hold_and_are_told_as_such() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = plates(place.path());
    for (flags, word) in
        [(["--time-limit", "0.1"], "--time-limit 0.1"), (["--memory-limit", "0.4"], "--memory-limit 0.4")]
    {
        let out = place.path().join(flags[0]);
        let mut command = crate::program::robofin(["dataset", "--limit", "1", "--resolution", "1024"]);
        let told = run(command.args(flags).arg(&parts).arg("--out").arg(&out));
        told.is_refused(1, &["1 of 1 items failed"]);
        let failures = lines(&out.join("failures.jsonl"));
        assert_eq!(failures[0]["stage"], "limit", "{failures:?}");
        assert!(failures[0]["reason"].as_str().is_some_and(|reason| reason.contains(word)), "{failures:?}");
        assert_eq!(names(&out.join("assets")), Vec::<String>::new(), "nothing is left over");
    }
}

#[cfg(unix)]
#[test]
fn files_that_cannot_grow_fail_their_item_and_leave_nothing_half_done() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (plates(place.path()), place.path().join("set"));
    let inner = dataset(&parts, &out);
    let mut shell = Command::new("sh");
    // Simulates a full disk: writes beyond 32 blocks fail.
    shell.args(["-c", "trap '' XFSZ; ulimit -f 32; exec \"$@\"", "sh"]).arg(inner.get_program()).args(inner.get_args());
    run(&mut shell).is_refused(1, &["6 of 6 items failed"]);
    let failures = lines(&out.join("failures.jsonl"));
    assert!(failures.iter().all(|failure| failure["stage"] == "write"), "{failures:?}");
    assert_eq!(names(&out.join("assets")), Vec::<String>::new());
    run(dataset(&parts, &out).args(["--resume", "--limit", "6"])).succeeds();
    assert_eq!(items(&out).len(), 6);
}
