//! STL and PLY surfaces as scans.

use std::fmt::Write as _;
use std::fs;

use sdf_bake::HeightMap;
use trials::trial::{PassScan, Trial};

use crate::files::{edit, folder, grinding, noted, refused};

/// Returns the vertices of a map's known pixels [mm], and two triangles for each cell whose corners are all known.
fn surface(map: &HeightMap) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let pixels = map.pixels;
    let corner = |at: usize| {
        let place = pixels.position(at % pixels.nx, at / pixels.nx) * 1e3;
        [place.x, place.y, if map.heights[at].is_nan() { 0.0 } else { map.heights[at] * 1e3 }]
    };
    let mut triangles = Vec::new();
    for at in (0..pixels.nx - 1).flat_map(|i| (0..pixels.ny - 1).map(move |j| j * pixels.nx + i)) {
        let (a, b, c, d) = (at, at + 1, at + pixels.nx, at + pixels.nx + 1);
        if [a, b, c, d].iter().all(|&at| map.heights[at].is_finite()) {
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    ((0..pixels.len()).map(corner).collect(), triangles)
}

fn stl(map: &HeightMap) -> String {
    let (vertices, triangles) = surface(map);
    let mut text = "solid scan\n".to_owned();
    for triangle in triangles {
        text += "facet normal 0 0 1\nouter loop\n";
        for [x, y, z] in triangle.map(|at| vertices[at]) {
            let _ = writeln!(text, "vertex {x} {y} {z}");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid scan\n"
}

fn ply(map: &HeightMap) -> String {
    let (vertices, triangles) = surface(map);
    let mut text = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        vertices.len(),
        triangles.len()
    );
    vertices.iter().for_each(|[x, y, z]| writeln!(text, "{x} {y} {z}").expect("a string"));
    triangles.iter().for_each(|[a, b, c]| writeln!(text, "3 {a} {b} {c}").expect("a string"));
    text
}

#[test]
fn surfaces_give_the_heights_that_grids_give() {
    let folder = folder();
    let whole = Trial::read(folder.path()).unwrap();
    let PassScan::Heights(after) = &grinding().passes[0].scan else { panic!("a ground surface") };
    fs::write(folder.path().join("before.stl"), stl(&grinding().scans.before)).unwrap();
    fs::write(folder.path().join("after.ply"), ply(after)).unwrap();
    edit(folder.path(), "trial.toml", |text| {
        text.replace("\"before.csv\"", "\"before.stl\"").replace("\"pass1_after.csv\"", "\"after.ply\"")
    });
    let trial = noted(folder.path(), &["before.stl", "triangles, looked at from above, in mm"]);
    assert!(trial.notes.iter().any(|note| note.contains("after.ply: a surface of")), "{:?}", trial.notes);
    let PassScan::Heights(read) = &trial.passes[0].scan else { panic!("a ground surface") };
    for (found, plain) in [(&trial.scans.before, &whole.scans.before), (read, after)] {
        assert_eq!((found.pixels.nx, found.pixels.ny), (plain.pixels.nx, plain.pixels.ny));
        let off = found.heights.iter().zip(&plain.heights).map(|(a, b)| (a - b).abs()).filter(|off| off.is_finite());
        assert!(off.fold(0.0, f64::max) < 1e-9);
        // The corner pixels of the holes' cells have no surface around them.
        assert!((plain.missing()..plain.missing() + 12).contains(&found.missing()), "{}", found.missing());
    }
}

#[test]
fn a_surface_elsewhere_or_of_another_size_is_refused() {
    let folder = folder();
    let mut before = grinding().scans.before;
    before.pixels.origin.x -= 0.1;
    fs::write(folder.path().join("before.stl"), stl(&before)).unwrap();
    edit(folder.path(), "trial.toml", |text| text.replace("\"before.csv\"", "\"before.stl\""));
    refused(folder.path(), &["before.stl", "the surface spans x -100.00 to", "from x 0.00 mm"]);
    fs::write(folder.path().join("before.stl"), "solid nothing\nendsolid nothing\n").unwrap();
    refused(folder.path(), &["before.stl", "an STL or PLY surface in mm is expected"]);
}
