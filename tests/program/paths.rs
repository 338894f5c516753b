//! Planned paths: the output is a log of the trial format that lies on the part.

use robot::LogRow;
use std::path::Path;

use glam::DVec3;
use robofin::asset::{AssetFields, Welds};
use serde_json::Value;
use trials::trial::{HeldTool, ToolPath, read_log};

use crate::program::{asset, names, robofin, run};

fn plan(arguments: &[&str], out: &Path) -> (Value, Vec<LogRow>) {
    let mut command = robofin(["path", "--json"]);
    let answer = run(command.arg(asset()).args(arguments).arg("--out").arg(out)).succeeds().answer();
    let log = read_log(out).expect("a log of the trial format");
    assert_eq!(log.notes, Vec::<String>::new());
    assert_eq!(answer["rows"].as_u64(), Some(log.content.rows.len() as u64));
    (answer, log.content.rows)
}

#[test]
fn a_path_follows_the_crown_of_the_weld_at_the_feed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("weld.csv");
    let (answer, rows) = plan(&["--weld", "1", "--feed-mm-s", "8", "--approach-mm", "4"], &out);
    let weld = Welds::read(asset()).expect("the truth").welds.remove(0);
    let length = answer["pressed_length_mm"].as_f64().expect("a length");
    assert!((length / weld.length_mm - 1.0).abs() < 0.1, "{length} for {}", weld.length_mm);

    let field = AssetFields::open(asset()).expect("the fields").welded;
    let pressed: Vec<&LogRow> = rows.iter().filter(|row| row.force > 0.0).collect();
    let middle = &pressed[pressed.len() / 4..3 * pressed.len() / 4];
    for row in middle {
        let contact = row.position - row.approach * 0.05;
        let off = f64::from(field.sample(contact));
        assert!(off.abs() < 0.3 * field.voxel, "{off} m off the crown at {contact}");
    }
    let path = ToolPath::of(&read_log(&out).expect("a log").content, &HeldTool::wheel(0.05, 0.02, DVec3::Y), 15.0);
    let speeds = middle.windows(2).map(|pair| {
        let contact = |row: &LogRow| row.position - row.approach * 0.05;
        contact(pair[1]).distance(contact(pair[0])) / (pair[1].time - pair[0].time)
    });
    for speed in speeds {
        assert!((speed / 8e-3 - 1.0).abs() < 0.02, "{speed}");
    }
    let contact = path.contact.expect("a pressed stretch");
    assert!(contact.start > 0.0 && contact.end < path.duration());
    let (first, start) = (&rows[0], pressed[0]);
    assert!(((first.position - start.position).dot(start.approach) - 4e-3).abs() < 1e-4);
    assert_eq!((first.force, start.force), (0.0, 15.0));
}

#[test]
fn a_raster_covers_the_patch_line_by_line() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let field = AssetFields::open(asset()).expect("the fields").target;
    // A level point of the top, found in the field itself.
    let weld = Welds::read(asset()).expect("the truth").welds.remove(0);
    let middle = weld.curve.position[weld.curve.position.len() / 2] * 1e3;
    let patch = format!("{},{},{},{}", middle.x - 2.0, middle.y - 1.0, middle.x + 2.0, middle.y + 1.0);
    let raster = |more: &[&str], name: &str| {
        let flags = [&["--raster", &patch, "--spacing-mm", "0.5", "--tool", "pad:radius=10mm"], more].concat();
        plan(&flags, &folder.path().join(name))
    };
    let (answer, rows) = raster(&["--zigzag"], "zigzag.csv");
    assert_eq!(answer["lines"].as_u64(), Some(5));
    assert_eq!(answer["has_approach_axis"].as_bool(), Some(false));
    let pressed: Vec<&LogRow> = rows.iter().filter(|row| row.force > 0.0).collect();
    let length: f64 = pressed.windows(2).map(|pair| pair[1].position.distance(pair[0].position)).sum();
    assert!((length * 1e3 / answer["pressed_length_mm"].as_f64().expect("a length") - 1.0).abs() < 0.02, "{length}");
    let lowest = rows.iter().map(|row| row.position.y).fold(f64::INFINITY, f64::min);
    assert!((lowest * 1e3 - (middle.y - 1.0)).abs() < 1e-6, "{lowest}");
    assert!(field.voxel > 0.0 && pressed.windows(2).all(|pair| pair[1].time > pair[0].time));

    let (one_way, lifted) = raster(&["--direction", "y"], "one-way.csv");
    assert_eq!(one_way["lines"].as_u64(), Some(9));
    let forward =
        |pair: &[LogRow]| pair[0].force == 0.0 || pair[1].force == 0.0 || pair[1].position.y >= pair[0].position.y;
    assert!(lifted.windows(2).all(forward), "every pressed line runs the same way");
    assert!(lifted.iter().filter(|row| row.force == 0.0).count() > 9);
}

#[test]
fn paths_that_cannot_be_are_refused_with_the_reason() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("path.csv");
    for (code, flags, words) in [
        (2, &["--tool", "wheel:radius=50"][..], &["--tool", "`50` is not a length"][..]),
        (2, &["--tool", "wheel:radius=50mm"], &["--tool", "the size `width` is missing"]),
        (2, &["--tool", "brush:radius=5mm"], &["--tool", "no tool is called `brush`"]),
        (2, &["--tool", "pad:radius=5mm,width=2mm"], &["--tool", "no size `width`"]),
        (2, &["--raster", "0,0,1", "--spacing-mm", "1"], &["--raster", "X0,Y0,X1,Y1"]),
        (2, &["--raster", "5,0,1,1", "--spacing-mm", "1"], &["--raster", "X0 < X1"]),
        (2, &["--raster", "0,0,1,1", "--spacing-mm", "0"], &["--spacing-mm", "0.001 to 1000"]),
        (2, &["--raster", "0,0,1,1"], &["required"]),
        (2, &["--weld", "1", "--raster", "0,0,1,1", "--spacing-mm", "1"], &["--weld", "--raster"]),
        (2, &["--feed-mm-s", "0"], &["--feed-mm-s", "is accepted"]),
        (2, &["--ramp-mm", "nan"], &["--ramp-mm", "is accepted"]),
        (1, &["--weld", "7"], &["--weld 7", "the welds 1"]),
        (1, &["--raster", "9000,0,9001,1", "--spacing-mm", "1"], &["no surface below x 9000", "within its top"]),
        (1, &["--feed-mm-s", "0.001", "--period-ms", "0.1"], &["rows", "faster feed"]),
    ] {
        run(robofin(["path"]).arg(asset()).args(flags).arg("--out").arg(&out)).is_refused(code, words);
    }
    let missing = folder.path().join("nowhere");
    run(robofin(["path"]).arg(&missing).arg("--out").arg(&out)).is_refused(1, &["nowhere"]);
    assert_eq!(names(folder.path()), Vec::<String>::new());
    std::fs::write(&out, "mine").expect("a file in the way");
    run(robofin(["path"]).arg(asset()).arg("--out").arg(&out)).is_refused(2, &["already exists"]);
}
