//! Volume and area printed by `bake`.

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::program::{robofin, run};

/// Returns a box of 30 x 30 x 20 mm with a corner at the origin, as OBJ, turned by a matrix that is exact apart from
/// the sine's rounding at zero.
fn box_turned(turn: [[f64; 3]; 3]) -> String {
    let corner =
        |i: u32| [(i & 1, 30.0), (i >> 1 & 1, 30.0), (i >> 2 & 1, 20.0)].map(|(bit, size)| f64::from(bit) * size);
    let turned = |p: [f64; 3]| turn.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]);
    let vertices = (0..8).map(|i| turned(corner(i))).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let quads = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"];
    vertices.chain(quads.map(|quad| format!("f {quad}\n"))).collect()
}

/// Returns quarter turns about x and y, and one by 0.3 rad about z.
fn turns() -> [(&'static str, [[f64; 3]; 3]); 4] {
    let about_x = |angle: f64| [[1.0, 0.0, 0.0], [0.0, angle.cos(), -angle.sin()], [0.0, angle.sin(), angle.cos()]];
    let about_y = |angle: f64| [[angle.cos(), 0.0, angle.sin()], [0.0, 1.0, 0.0], [-angle.sin(), 0.0, angle.cos()]];
    let about_z = |angle: f64| [[angle.cos(), -angle.sin(), 0.0], [angle.sin(), angle.cos(), 0.0], [0.0, 0.0, 1.0]];
    [("x180", about_x(PI)), ("y180", about_y(PI)), ("y270", about_y(1.5 * PI)), ("z17", about_z(0.3))]
}

/// Asserts that volume [mm³] and area [mm²] of a line are those of the box, within 0.1 %.
fn assert_is_box(line: &Value) {
    for (key, expected) in [("volume_mm3", 18_000.0), ("area_mm2", 4_200.0)] {
        let found = line[key].as_f64().unwrap_or(f64::NAN);
        assert!((found / expected - 1.0).abs() < 1e-3, "{key} is {found}, not {expected}: {line}");
    }
}

fn write_boxes(folder: &Path) {
    fs::create_dir_all(folder).expect("a folder");
    for (name, turn) in turns() {
        fs::write(folder.join(format!("{name}.obj")), box_turned(turn)).expect("a mesh file");
    }
}

#[test]
fn bake_prints_the_volume_and_the_area_of_a_turned_box() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let parts = place.path().join("parts");
    write_boxes(&parts);
    for (name, _) in turns() {
        let out = place.path().join(format!("{name}.nvdb"));
        let mut command = robofin(["bake", "--json", "--unit", "mm", "--voxel-mm", "0.5"]);
        let outcome = run(command.arg(parts.join(format!("{name}.obj"))).arg("--out").arg(&out)).succeeds();
        assert_is_box(&serde_json::from_str(&outcome.stdout).expect("a line of JSON"));
    }
    let mut command = robofin(["bake", "--unit", "mm", "--voxel-mm", "0.5"]);
    let out = place.path().join("words.nvdb");
    let outcome = run(command.arg(parts.join("x180.obj")).arg("--out").arg(out)).succeeds();
    assert!(outcome.stderr.contains("volume inside ") && outcome.stderr.contains(" mm³, area "), "{}", outcome.stderr);
}

#[test]
fn bake_of_a_folder_prints_them_for_each_mesh_fresh_and_cached() {
    let place = tempfile::tempdir().expect("a temporary folder");
    let (parts, out) = (place.path().join("parts"), place.path().join("fields"));
    write_boxes(&parts);
    for resume in [false, true] {
        let mut command = robofin(["bake", "--json", "--unit", "mm", "--voxel-mm", "0.5"]);
        command.arg(&parts).arg("--out").arg(&out).args(resume.then_some("--resume"));
        let outcome = run(&mut command).succeeds();
        let lines: Vec<Value> =
            outcome.stdout.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect();
        assert_eq!(lines.len(), 4);
        lines.iter().for_each(assert_is_box);
    }
}
