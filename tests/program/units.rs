//! The unit trap: the same part in metres and in millimetres.

use serde_json::Value;

use crate::program::{Outcome, robofin, run};
use crate::shared_parts::shared;

fn bake(file: &str) -> Option<(Outcome, Value)> {
    let path = shared("the unit trap")?.join(file);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut command = robofin(["bake", "--json", "--resolution", "64"]);
    let outcome = run(command.arg(path).arg("--out").arg(folder.path().join("phi.nvdb"))).succeeds();
    let answer = outcome.answer();
    Some((outcome, answer))
}

#[test]
fn one_part_in_millimetres_and_in_metres_has_one_size() {
    let Some((obj, in_mm)) = bake("00000006_d4fe04f0f5f84b52bd4f10e4_trimesh_001.obj") else { return };
    let Some((stl, in_m)) = bake("00000006_d4fe04f0f5f84b52bd4f10e4_trimesh_001.stl") else { return };
    let [one, two] = [&in_mm, &in_m].map(|answer| answer["voxel_mm"].as_f64().expect("a number"));
    // Both are baked with 64 voxels along the longest side of 5.499 mm; the STL is a coarser mesh of it.
    assert!((one / two - 1.0).abs() < 1e-3 && (one * 64.0 - 5.499).abs() < 1e-3, "{one} and {two} mm");
    for (text, unit) in [(&obj.stderr, "millimetre"), (&stl.stderr, "metre")] {
        assert!(text.contains("4.8 x 5.5 x 1.6 mm"), "{text}");
        let said = text.lines().find(|line| line.contains("unit: ")).expect("the unit is said");
        assert!(said.contains(unit), "{said}");
    }
}

#[test]
fn a_unit_that_is_given_is_believed() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let place = |name: &str| folder.path().join(name);
    for (unit, size) in [("mm", "160.0 x 90.0 x 60.0 mm"), ("inch", "4064.0 x 2286.0 x 1524.0 mm")] {
        let mut command = robofin(["bake", "--resolution", "64", "--unit", unit]);
        let outcome = run(command.arg(crate::program::bracket()).arg("--out").arg(place(unit))).succeeds();
        assert!(outcome.stderr.contains(size), "{}", outcome.stderr);
    }
}
