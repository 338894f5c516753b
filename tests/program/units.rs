//! Confusion of units: the same part in metres and in millimetres.

use std::path::Path;

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

/// Writes a box with these sides as OBJ or ASCII STL.
fn cuboid(file: &Path, sides: [f64; 3]) {
    let corner = |i: usize| [i & 1, i >> 1 & 1, i >> 2].map(|bit| bit as f64);
    let at = |i: usize| (0..3).map(|axis| format!("{}", corner(i)[axis] * sides[axis])).collect::<Vec<_>>().join(" ");
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let text = if file.extension().is_some_and(|extension| extension == "obj") {
        let vertices: String = (0..8).map(|i| format!("v {}\n", at(i))).collect();
        vertices
            + &quads
                .iter()
                .map(|q| format!("f {} {} {} {}\n", q[0] + 1, q[1] + 1, q[2] + 1, q[3] + 1))
                .collect::<String>()
    } else {
        let facet = |corners: [usize; 3]| {
            let vertices: String = corners.iter().map(|&i| format!("vertex {}\n", at(i))).collect();
            format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
        };
        let facets = quads.iter().flat_map(|q| [facet([q[0], q[1], q[2]]), facet([q[0], q[2], q[3]])]);
        format!("solid part\n{}endsolid part\n", facets.collect::<String>())
    };
    std::fs::write(file, text).expect("a file");
}

fn warnings(answer: &Value) -> Vec<&str> {
    answer["warnings"].as_array().expect("a list").iter().filter_map(Value::as_str).collect()
}

#[test]
fn a_part_of_an_implausible_size_gets_a_warning_with_a_remedy() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    for (name, side, words) in [
        (
            "small.obj",
            1.0,
            &["1.0 mm in millimetres", "very small", "25.4 mm with --unit inch", "1000.0 mm with --unit m"][..],
        ),
        ("large.obj", 5000.0, &["5000.0 mm in millimetres", "very large", "--unit m"]),
        ("doubtful.stl", 1.34, &["1340.0 mm in metres", "near the limit", "1.34 mm with --unit mm"]),
        ("guessed.stl", 2.95, &["2.95 mm in millimetres", "very small", "2950.0 mm with --unit m"]),
        ("usual.obj", 60.0, &[]),
        ("usual.stl", 60.0, &[]),
    ] {
        let file = folder.path().join(name);
        cuboid(&file, [side, 0.5 * side, 0.2 * side]);
        let mut command = robofin(["bake", "--json", "--resolution", "32"]);
        let outcome = run(command.arg(&file).arg("--out").arg(folder.path().join(format!("{name}.nvdb")))).succeeds();
        let answer = outcome.answer();
        assert_eq!(warnings(&answer).len(), usize::from(!words.is_empty()), "{name}: {answer}");
        for word in words {
            assert!(warnings(&answer)[0].contains(word), "{word}: {answer}");
            assert!(outcome.stderr.contains(word), "{word}: {}", outcome.stderr);
        }
    }
}

#[test]
fn a_bead_thinner_than_any_wire_gets_a_warning() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("small.obj");
    cuboid(&file, [1.0, 0.6, 0.2]);
    let mut command = robofin(["weld", "--json", "--usd", "off"]);
    let outcome = run(command.arg(&file).arg("--out").arg(folder.path().join("out"))).succeeds();
    let answer = outcome.answer();
    let about_bead = "the thinnest welding wire is 0.6 mm: check --unit";
    assert!(warnings(&answer).iter().any(|warning| warning.contains(about_bead)), "{answer}");
    assert!(outcome.stderr.contains(about_bead), "{}", outcome.stderr);
}
