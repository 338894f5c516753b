//! Campaigns of another laboratory: undamaged ones pass, and each of twenty kinds of damage is reported.

use std::path::PathBuf;

use trials::trial::Campaign;

use crate::kinds::{Kind, first_look, said};
use crate::shared_folder::shared;

use crate::kinds::Said::{Noted, Refused};

fn campaigns(names: &str) -> Vec<PathBuf> {
    let Some(place) = shared("campaigns") else { return Vec::new() };
    names.chars().map(|name| place.join(format!("open-{name}"))).collect()
}

#[test]
fn whole_campaigns_pass_without_a_word() {
    for place in campaigns("abcdefgh").into_iter().chain([first_look()]) {
        let campaign = Campaign::read(&place).unwrap_or_else(|error| panic!("{}: {error}", place.display()));
        assert!(campaign.notes().is_empty() && campaign.findings().is_empty(), "{:?}", campaign.notes());
    }
}

const GRINDING: &[Kind] = &[
    (
        "repeat is the last scan made again",
        |t, _| t.scanned_again(t.last(), &t.repeat, 2e-3),
        Refused("made after a pass"),
    ),
    (
        "repeat is before with little noise",
        |t, _| t.scanned_again(&t.before, &t.repeat, 1e-4),
        Refused("the same heights as before.csv"),
    ),
    ("before mirrored along x", |t, _| t.mirror_x(&t.before), Refused("mirrored along x")),
    ("before mirrored along y", |t, _| t.mirror_y(&t.before), Refused("mirrored along y")),
    ("the first scan mirrored along x", |t, _| t.mirror_x(&t.scans[0]), Refused("mirrored along x")),
    ("all scans mirrored along x", |t, _| t.maps().iter().for_each(|s| t.mirror_x(s)), Refused("mirrored along x")),
    ("the scans of two passes changed places", |t, _| t.swap(&t.scans[0], &t.scans[1]), Refused("swapped")),
    ("the logs of two passes changed places", |t, _| t.swap(&t.logs[0], &t.logs[1]), Refused("pass2_log.csv")),
    ("the path displaced", |t, _| t.column(1, |x| x + 6.0), Refused("mm off along x")),
    ("the path mirrored", |t, _| t.column(1, |x| 70.0 - x), Refused("the tool goes along")),
    ("the force 30 % up", |t, _| t.column(4, |force| 1.3 * force), Noted("is the sensor calibrated")),
];

const SANDING: &[Kind] = &[
    (
        "repeat is before with little noise",
        |t, _| t.scanned_again(&t.before, &t.repeat, 1e-4),
        Refused("the same heights as before.csv"),
    ),
    (
        "all maps mirrored along x",
        |t, _| {
            t.maps().iter().chain(&t.scans).for_each(|s| t.mirror_x(s));
        },
        Refused("mirrored along x"),
    ),
    (
        "masks of the other sign",
        |t, _| t.scans.iter().for_each(|s| t.numbers(s, |_, _, v| 1.0 - v)),
        Refused("exposed"),
    ),
    ("the last mask of the other sign", |t, _| t.numbers(t.last(), |_, _, v| 1.0 - v), Refused("coated again")),
    ("the masks of two passes changed places", |t, _| t.swap(&t.scans[0], &t.scans[1]), Refused("they look swapped")),
    ("the masks displaced", |t, _| t.scans.iter().for_each(|s| t.shift(s, 0, 60)), Refused("exposed")),
    ("the coating in µm", |t, _| t.scale_key("thickness_mm", 1e3), Refused("thickness_mm is 60")),
    ("repeat doubled", |t, _| t.numbers(&t.repeat, |_, _, height| 2.0 * height), Noted("is one of them scaled")),
];

#[test]
fn damaged_campaigns_are_told() {
    for (letter, kinds) in [("a", GRINDING), ("d", SANDING)] {
        for place in campaigns(letter) {
            crate::kinds::assert_reported(&place, kinds);
        }
    }
}

/// Damage that no check can detect: a bead that is its own mirror image, and a spindle speed in one wrong unit
/// everywhere, which only scales the rate.
#[test]
fn what_cannot_be_seen_is_read() {
    assert!(said(&first_look(), |t, _| t.maps().iter().for_each(|s| t.mirror_y(s))).is_ok());
    let everywhere = |t: &crate::damage::Files, _: &crate::damage::Files| {
        t.column(5, |rpm| 0.104_72 * rpm);
        t.scale_key("spindle_rpm", 0.104_72);
    };
    assert!(said(&first_look(), everywhere).is_ok());
}
