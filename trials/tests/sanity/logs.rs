//! Logs in other units, with other signs, of other passes and trials, and keys of `trial.toml` that contradict them.

use std::fs;

use crate::damage::Files;
use crate::kinds::Said::{Noted, Refused};
use crate::kinds::{Kind, assert_reported, first_look};

const T: usize = 0;
const X: usize = 1;
const Y: usize = 2;
const Z: usize = 3;
const FORCE: usize = 4;
const RPM: usize = 5;

const FORCES: &[Kind] = &[
    ("force of the other sign", |t, _| t.column(FORCE, |f| -f), Refused("other sign")),
    ("force in kN", |t, _| t.column(FORCE, |f| 1e-3 * f), Refused("in kN")),
    ("force in mN", |t, _| t.column(FORCE, |f| 1e3 * f), Refused("in mN")),
    ("force 30 % up", |t, _| t.column(FORCE, |f| 1.3 * f), Noted("is the sensor calibrated")),
    ("force 30 % down", |t, _| t.column(FORCE, |f| 0.7 * f), Noted("is the sensor calibrated")),
    ("force zero", |t, _| t.column(FORCE, |_| 0.0), Refused("shows no contact")),
    ("force constant", |t, _| t.column(FORCE, |_| 15.0), Noted("was the sensor connected")),
    ("setpoint doubled", |t, _| t.scale_key("force_setpoint_n", 2.0), Noted("off force_setpoint_n = 30 N")),
];

const PLACES: &[Kind] = &[
    ("z of the tip", |t, _| t.column(Z, |z| z - 50.0), Refused("not its centre")),
    ("z constant", |t, _| t.column(Z, |_| 51.0), Noted("is it measured")),
    ("z in m", |t, _| t.column(Z, |z| 1e-3 * z), Refused("z_mm looks like m")),
    ("path mirrored along x", |t, _| t.column(X, |x| 42.0 - x), Refused("the tool goes along")),
    ("path displaced along x", |t, _| t.column(X, |x| x + 6.0), Refused("6 mm off along x")),
    ("path displaced along y", |t, _| t.column(Y, |y| y + 4.0), Noted("mm beside the path")),
    ("x of the other sign", |t, _| t.column(X, |x| -x), Refused("all contact is at")),
    ("x and y swapped", |t, _| t.rows(|row| row.swap(X, Y)), Refused("log.csv")),
    ("x, y in m", |t, _| [X, Y].iter().for_each(|&at| t.column(at, |v| 1e-3 * v)), Refused("mm/s where the feed is")),
    ("x constant", |t, _| t.column(X, |_| 20.0), Refused("the tool moves at")),
    (
        "all positions in inches",
        |t, _| [X, Y, Z].iter().for_each(|&at| t.column(at, |v| v / 25.4)),
        Refused("mm/s where"),
    ),
];

const TIMES: &[Kind] = &[
    ("time in ms", |t, _| t.column(T, |time| 1e3 * time), Refused("look like ms")),
    (
        "time in ms and no feed",
        |t, _| {
            t.column(T, |time| 1e3 * time);
            t.lines(|line| (!line.starts_with("feed_mm_s")).then(|| line.to_owned()));
        },
        Refused("is t_s in ms"),
    ),
    ("time in minutes", |t, _| t.column(T, |time| time / 60.0), Refused("is the clock wrong")),
    ("time doubled", |t, _| t.column(T, |time| 2.0 * time), Noted("is the clock right")),
    (
        "rows reversed",
        |t, _| {
            t.cells(&t.logs[0], |mut rows| {
                rows[1..].reverse();
                rows
            })
        },
        Refused("runs backwards"),
    ),
    ("a row without a number", |t, _| t.edit(&t.logs[0], |text| text.replacen("\n0.1,", "\nNaN,", 1)), Refused("NaN")),
    ("feed in m/s", |t, _| t.scale_key("feed_mm_s", 1e-3), Refused("in m/s")),
    ("spindle speed in rad/s", |t, _| t.column(RPM, |rpm| 0.104_72 * rpm), Refused("rad/s")),
    ("spindle speed in Hz", |t, _| t.column(RPM, |rpm| rpm / 60.0), Refused("revolutions per second")),
    ("spindle speed halved", |t, _| t.column(RPM, |rpm| 0.5 * rpm), Noted("the column spindle_rpm is 3000")),
];

const OTHERS: &[Kind] = &[
    ("logs of two passes changed places", |t, _| t.swap(&t.logs[0], &t.logs[1]), Refused("is pass2_log.csv the log")),
    (
        "logs of two passes in one direction changed places",
        |t, _| {
            t.lines(|line| (!line.starts_with("direction")).then(|| line.to_owned()));
            t.swap(&t.logs[0], &t.logs[1]);
        },
        Refused("the two look swapped"),
    ),
    ("the second log is the first", |t, _| t.copy(&t.logs[0], &t.logs[1]), Refused("the same rows as pass1_log.csv")),
    (
        "the first log of another trial",
        |t, o| {
            fs::copy(o.folder.join(&o.logs[0]), t.folder.join(&t.logs[0])).unwrap();
        },
        Refused("log of [[pass]] 1 is the same"),
    ),
];

const KEYS: &[Kind] = &[
    ("pitch a thousand times larger", |t, _| t.scale_key("pitch_mm", 1e3), Refused("mm")),
    ("pitch a thousand times smaller", |t, _| t.scale_key("pitch_mm", 1e-3), Refused("mm")),
    ("pitch doubled", |t, _| t.scale_key("pitch_mm", 2.0), Refused("is origin_mm or pitch_mm off")),
    ("pitch halved", |t, _| t.scale_key("pitch_mm", 0.5), Noted("beside the scans: is pitch_mm")),
    (
        "origin off along y",
        |t, _| t.lines(|line| Some(line.replace("origin_mm = [0.0, -7.2]", "origin_mm = [0.0, -3.2]"))),
        Noted("beside the path"),
    ),
    ("radius ten times larger", |t, _| t.scale_key("radius_mm", 10.0), Refused("10 times too large")),
    ("radius halved", |t, _| t.scale_key("radius_mm", 0.5), Refused("half of the radius")),
    ("width a tenth", |t, _| t.scale_key("width_mm", 0.1), Noted("where the tool never came")),
    (
        "axis along the feed",
        |t, _| {
            t.lines(|line| {
                Some(match line.starts_with("axis") {
                    true => "axis = [1, 0, 0]".to_owned(),
                    false => line.to_owned(),
                })
            })
        },
        Refused("is axis of trial.toml turned by 90°"),
    ),
    ("direction of the other sign", |t, _| t.scale_key("direction", -1.0), Refused("the tool goes along")),
];

#[test]
fn forces_are_told() {
    assert_reported(&first_look(), FORCES);
}

#[test]
fn places_are_told() {
    assert_reported(&first_look(), PLACES);
}

#[test]
fn times_and_speeds_are_told() {
    assert_reported(&first_look(), TIMES);
}

#[test]
fn logs_of_others_are_told() {
    assert_reported(&first_look(), OTHERS);
}

#[test]
fn keys_of_the_manifest_are_told() {
    assert_reported(&first_look(), KEYS);
}

impl Files {
    /// Changes the rows of all logs.
    fn rows(&self, change: impl Fn(&mut Vec<String>)) {
        for log in &self.logs {
            self.cells(log, |mut rows| {
                rows[1..].iter_mut().for_each(&change);
                rows
            });
        }
    }

    /// Changes or removes the lines of `trial.toml`.
    fn lines(&self, change: impl Fn(&str) -> Option<String>) {
        self.edit("trial.toml", |text| text.lines().filter_map(change).map(|line| line + "\n").collect());
    }
}
