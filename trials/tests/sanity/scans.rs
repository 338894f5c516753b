//! Scans that are copied, mirrored, swapped, in another unit or of another trial.

use std::fs;

use crate::damage::Files;
use crate::kinds::Said::{Noted, Refused};
use crate::kinds::{Kind, assert_reported, first_look};

const COPIED: &[Kind] = &[
    (
        "repeat is the last scan made again",
        |t, _| t.scanned_again(t.last(), &t.repeat, 2e-3),
        Refused("made after a pass"),
    ),
    ("repeat is the last scan", |t, _| t.copy(t.last(), &t.repeat), Refused("the same heights as")),
    ("repeat is before", |t, _| t.copy(&t.before, &t.repeat), Refused("the same heights as before.csv")),
    (
        "repeat is before with little noise",
        |t, _| t.scanned_again(&t.before, &t.repeat, 1e-4),
        Refused("the same heights as before.csv"),
    ),
    (
        "repeat is before, rounded to 10 µm",
        |t, _| t.rounded(&t.before, &t.repeat),
        Refused("the same heights as before.csv"),
    ),
    ("repeat is before, tilted", |t, _| t.tilted(&t.before, &t.repeat), Refused("share their noise")),
    ("after is before", |t, _| t.copy(&t.before, &t.scans[0]), Refused("the same heights as before.csv")),
    ("after is before made again", |t, _| t.scanned_again(&t.before, &t.scans[0], 2e-3), Noted("removed nothing")),
    ("the second scan is the first", |t, _| t.copy(&t.scans[0], &t.scans[1]), Refused("the same heights as pass1")),
    (
        "the second scan is the first with little noise",
        |t, _| t.scanned_again(&t.scans[0], &t.scans[1], 1e-4),
        Refused("the same heights as pass1_after.csv"),
    ),
    (
        "the second scan is the first made again",
        |t, _| t.scanned_again(&t.scans[0], &t.scans[1], 2e-3),
        Noted("removed nothing"),
    ),
    ("before and the first scan changed places", |t, _| t.swap(&t.before, &t.scans[0]), Refused("look swapped")),
    ("the scans of two passes changed places", |t, _| t.swap(&t.scans[0], &t.scans[1]), Refused("look swapped")),
];

const MIRRORED: &[Kind] = &[
    ("before mirrored along x", |t, _| t.mirror_x(&t.before), Refused("before.csv: against")),
    ("before mirrored along y", |t, _| t.mirror_y(&t.before), Refused("mirrored along y")),
    ("before turned", |t, _| t.turn(&t.before), Refused("half a turn")),
    ("repeat mirrored along x", |t, _| t.mirror_x(&t.repeat), Refused("before_repeat.csv: against")),
    ("the first scan mirrored along y", |t, _| t.mirror_y(&t.scans[0]), Refused("pass1_after.csv: against")),
    ("the last scan mirrored along x", |t, _| t.mirror_x(t.last()), Refused("pass2_after.csv: against")),
    (
        "all scans after passes mirrored along x",
        |t, _| t.scans.iter().for_each(|s| t.mirror_x(s)),
        Refused("mirrored along x"),
    ),
    (
        "all scans mirrored along x",
        |t, _| t.maps().iter().for_each(|s| t.mirror_x(s)),
        Refused("all scans are mirrored along x"),
    ),
    ("all scans turned", |t, _| t.maps().iter().for_each(|s| t.turn(s)), Refused("log")),
    ("the first scan displaced by three pixels", |t, _| t.shift(&t.scans[0], 3, 2), Refused("0.90 mm along x")),
    ("repeat displaced by six pixels", |t, _| t.shift(&t.repeat, 6, 3), Refused("before_repeat.csv")),
];

const SCALED: &[Kind] = &[
    ("before in m", |t, _| t.scale(&t.before, 1e-3), Refused("look like m")),
    ("before in µm", |t, _| t.scale(&t.before, 1e3), Refused("look like µm")),
    ("the last scan in m", |t, _| t.scale(t.last(), 1e-3), Refused("look like m")),
    ("all scans in m", |t, _| t.maps().iter().for_each(|s| t.scale(s, 1e-3)), Refused("look like m")),
    ("all scans in inches", |t, _| t.maps().iter().for_each(|s| t.scale(s, 1.0 / 25.4)), Refused("z_mm")),
    ("all scans doubled", |t, _| t.maps().iter().for_each(|s| t.scale(s, 2.0)), Noted("below the surface")),
    ("before doubled", |t, _| t.scale(&t.before, 2.0), Refused("before")),
    ("the last scan doubled", |t, _| t.scale(t.last(), 2.0), Refused("pass2_after.csv")),
    ("before upside down", |t, _| t.scale(&t.before, -1.0), Refused("other sign")),
    ("all scans upside down", |t, _| t.maps().iter().for_each(|s| t.scale(s, -1.0)), Refused("other sign")),
    ("before level", |t, _| t.scale(&t.before, 0.0), Refused("z_mm")),
];

const OTHERS: &[Kind] = &[
    ("repeat of another trial", |t, o| t.take(o, &o.repeat, &t.repeat), Refused("before_repeat.csv")),
    (
        "before of another trial",
        |t, o| t.take(o, &o.before, &t.before),
        Refused("[scan] before is the same as [scan] before"),
    ),
    (
        "before and repeat of another trial",
        |t, o| {
            t.take(o, &o.before, &t.before);
            t.take(o, &o.repeat, &t.repeat);
        },
        Refused("[scan] before is the same"),
    ),
    ("the last scan of another trial", |t, o| t.take(o, o.last(), t.last()), Refused("scan of [[pass]] 2 is the same")),
    (
        "the scans of two trials changed places",
        |t, o| {
            for name in t.maps() {
                fs::rename(t.folder.join(&name), t.folder.join("kept")).unwrap();
                t.take(o, &name, &name);
                fs::copy(t.folder.join("kept"), o.folder.join(&name)).unwrap();
            }
        },
        Refused("were files of the two trials swapped"),
    ),
    (
        "the whole trial is another",
        |t, o| {
            for name in t.maps().iter().chain(&t.logs) {
                t.take(o, name, name);
            }
            t.take(o, "trial.toml", "trial.toml");
        },
        Refused("[scan] before is the same"),
    ),
    (
        "the material map of other metals",
        |t, _| t.numbers(t.material.as_ref().unwrap(), |_, _, label| 1.0 - label),
        Noted("weld metal lies"),
    ),
    (
        "the material map cut",
        |t, _| {
            t.cells(t.material.as_ref().unwrap(), |mut rows| {
                rows.pop();
                rows
            })
        },
        Refused("141 x 48 pixels"),
    ),
];

#[test]
fn copied_and_swapped_scans_are_told() {
    assert_reported(&first_look(), COPIED);
}

#[test]
fn mirrored_and_displaced_scans_are_told() {
    assert_reported(&first_look(), MIRRORED);
}

#[test]
fn scans_in_other_units_are_told() {
    assert_reported(&first_look(), SCALED);
}

#[test]
fn scans_of_other_trials_are_told() {
    assert_reported(&first_look(), OTHERS);
}

impl Files {
    /// Multiplies all heights of a map.
    fn scale(&self, name: &str, factor: f64) {
        self.numbers(name, |_, _, height| factor * height);
    }

    fn turn(&self, name: &str) {
        self.mirror_x(name);
        self.mirror_y(name);
    }

    fn rounded(&self, from: &str, to: &str) {
        self.copy(from, to);
        self.numbers(to, |_, _, height| (height * 1e2).round() * 1e-2);
    }

    fn tilted(&self, from: &str, to: &str) {
        self.copy(from, to);
        self.numbers(to, |row, column, height| height + 1e-4 * row as f64 - 2e-4 * column as f64);
    }

    /// Takes a file of another trial.
    fn take(&self, other: &Self, from: &str, to: &str) {
        fs::copy(other.folder.join(from), self.folder.join(to)).unwrap();
    }
}
