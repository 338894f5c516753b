//! Bags of ROS 2 that other programs wrote, compared with the formulas of `files/make_bags.py`.

mod damage;

use std::path::{Path, PathBuf};

use instruments::Misread;
use instruments::log::{Channels, guess, guess::Role, read};

const BAGS: [&str; 5] = ["press.db3", "press.mcap", "press_lz4.mcap", "press_zstd.mcap", "big_endian.db3"];

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files").join(name)
}

fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn bag(name: &str) -> Channels {
    read(&path(name), &bytes(name)).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
fn assert_near(log: &Channels, name: &str, wanted: impl Fn(f64) -> f64) {
    let values = log.channel(name).unwrap_or_else(|| panic!("{name} in {:?}", log.names));
    for (k, value) in values.iter().enumerate() {
        let wanted = wanted(0.01 * k as f64);
        assert!((value - wanted).abs() < 1e-9 || value.is_nan() && wanted.is_nan(), "{name} {k}: {value} {wanted}");
    }
}

/// NaN outside the times from `from` to `to`.
fn within(from: f64, to: f64, value: f64, t: f64) -> f64 {
    if (from - 1e-9..to + 1e-9).contains(&t) { value } else { f64::NAN }
}

#[test]
fn bags_of_outside_programs_hold_what_the_formulas_say() {
    for name in BAGS {
        let log = bag(name);
        assert_eq!(log.rows(), 50, "{name}");
        assert_eq!(log.lines[49], 50);
        assert_near(&log, "time", |t| t);
        assert_near(&log, "/tool/pose/pose/position/x", |t| 0.3 + 0.01 * t);
        assert_near(&log, "/tool/pose/pose/position/z", |t| 0.1 + 0.002 * t);
        assert_near(&log, "/tool/pose/pose/orientation/w", |_| 0.8);
        // Forces come from 0.002 s to 0.398 s, and nothing is extrapolated.
        assert_near(&log, "/ft/wrench/force/z", |t| within(0.002, 0.398, -20.0 * t, t));
        assert_near(&log, "/ft/wrench/torque/y", |t| within(0.002, 0.398, 0.2, t));
        assert_near(&log, "/spindle/data", |t| within(0.002, 0.398, 600.0 + t, t));
        assert_near(&log, "/joints/position/b", |t| within(0.002, 0.398, -t, t));
        assert_near(&log, "/array/data/0", |t| within(0.002, 0.398, t, t));
        assert_near(&log, "/tf/tool0/transform/translation/x", |t| within(0.0, 0.45, t, t));
        assert_near(&log, "/twist/twist/angular/z", |t| within(0.0, 0.45, -t, t));
        assert_eq!(log.channel("/joints/velocity/a"), None);
        assert!(log.notes.iter().any(|note| note.contains("/note (std_msgs")), "{:?}", log.notes);
        assert!(log.notes.iter().any(|note| note.contains("on the times of /tool/pose")), "{:?}", log.notes);
    }
}

#[test]
fn every_writer_gives_the_same_channels() {
    let first = bag(BAGS[0]);
    for name in &BAGS[1..] {
        let other = bag(name);
        assert_eq!(first.names, other.names, "{name}");
        assert_eq!(first.units, other.units, "{name}");
        let bits = |log: &Channels| log.values.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&first), bits(&other), "{name}");
    }
}

#[test]
fn guesses_know_the_topics() {
    let guesses = guess(&bag("press.mcap"));
    let best = |role: Role| guesses.best(role).map(|best| (best.name.as_str(), best.unit.as_str(), best.sign));
    assert_eq!(best(Role::Time), Some(("time", "s", 1)));
    assert_eq!(best(Role::X), Some(("/tool/pose/pose/position/x", "m", 1)));
    assert_eq!(best(Role::Z), Some(("/tool/pose/pose/position/z", "m", 1)));
    assert_eq!(best(Role::Force), Some(("/ft/wrench/force/z", "N", -1)));
    assert_eq!(best(Role::Spindle).map(|best| best.0), Some("/spindle/data"));
}

#[test]
fn a_recording_that_was_not_closed_is_read_as_far_as_it_goes() {
    let whole = bytes("press_lz4.mcap");
    let log = read(Path::new("cut.mcap"), &whole[..whole.len() / 2]).expect("half a bag");
    assert!(log.rows() > 10 && log.rows() < 50, "{} rows", log.rows());
    assert!(log.notes.iter().any(|note| note.contains("ends within a record")), "{:?}", log.notes);
}

#[test]
fn a_base_with_other_tables_is_refused() {
    let file = tempfile::NamedTempFile::new().expect("a file");
    let base = rusqlite::Connection::open(file.path()).expect("a base");
    base.execute_batch("CREATE VIEW topics AS SELECT 1; CREATE TABLE messages (id INTEGER);").expect("tables");
    drop(base);
    let bytes = std::fs::read(file.path()).expect("bytes");
    let refusal = read(Path::new("view.db3"), &bytes).expect_err("a view").to_string();
    assert!(refusal.contains("no tables topics and messages"), "{refusal}");
}

#[test]
fn damage_never_panics() {
    for name in BAGS {
        damage::every(&bytes(name), |bytes| match read(Path::new(name), bytes) {
            Ok(log) => assert!(log.values.iter().all(|values| values.len() == log.rows())),
            Err(Misread::Bad { .. }) => {}
            Err(error) => panic!("{error}"),
        });
    }
}
