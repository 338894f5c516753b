//! Reads and cleans all shared meshes, and compares their counts with those of `SOURCES.md`, which come from another
//! program.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;
use sdf_bake::Mesh;
use sdf_bake::clean::{EdgeMap, clean};
use sdf_bake::read::{MeshFile, UnitChoice, read_mesh};

/// The folder of shared meshes; without it, prints what is not tested.
fn shared_meshes(what: &str) -> Option<PathBuf> {
    let root = match std::env::var_os("ROBOFIN_SHARED") {
        Some(root) => PathBuf::from(root),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
    };
    let folder = root.join("data/abc");
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("NOT TESTED: {what}. {} is missing; set ROBOFIN_SHARED to the shared folder.", folder.display());
    None
}

fn read(path: &Path) -> MeshFile {
    read_mesh(path, UnitChoice::Auto).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A row of the table in `SOURCES.md`.
#[derive(Debug, PartialEq)]
struct Row {
    triangles: usize,
    vertices: usize,
    open: usize,
    non_manifold: usize,
    bodies: usize,
}

fn table(folder: &Path) -> Vec<(String, Row, DVec3)> {
    let text = std::fs::read_to_string(folder.join("SOURCES.md")).expect("SOURCES.md is there");
    let rows = text.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| file"));
    rows.map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let number = |cell: &str| cell.trim().parse().expect("a count");
        let (open, non_manifold) = cells[6].split_once('/').expect("two counts");
        let extents: Vec<f64> = cells[8].split(" x ").map(|side| side.parse().expect("a length")).collect();
        let row = Row {
            triangles: number(cells[3]),
            vertices: number(cells[4]),
            open: number(open),
            non_manifold: number(non_manifold),
            bodies: number(cells[7]),
        };
        (cells[1].to_string(), row, DVec3::from_slice(&extents))
    })
    .collect()
}

/// Counts by the method of `SOURCES.md`: positions rounded to 1e-8 file units are one vertex, and no face is dropped.
fn count(mesh: &Mesh, unit: f64) -> Row {
    let mut at = HashMap::new();
    let mut merged = Mesh::default();
    for corners in &mesh.triangles {
        let corners = corners.map(|vertex| {
            let position = mesh.positions[vertex as usize];
            *at.entry((position / unit * 1e8).round().as_i64vec3()).or_insert_with(|| {
                merged.positions.push(position);
                merged.positions.len() as u32 - 1
            })
        });
        merged.triangles.push(corners);
    }
    let edges = EdgeMap::new(&merged);
    let mut label: Vec<usize> = (0..merged.positions.len()).collect();
    loop {
        let before = label.clone();
        for edge in edges.indices() {
            let [a, b] = edges.vertices(edge).map(|vertex| vertex as usize);
            let low = label[a].min(label[b]);
            (label[a], label[b]) = (low, low);
        }
        if label == before {
            break;
        }
    }
    let bodies = label.iter().enumerate().filter(|(vertex, label)| vertex == *label).count();
    Row {
        triangles: merged.triangles.len(),
        vertices: merged.positions.len(),
        open: edges.boundary_count(),
        non_manifold: edges.non_manifold_count(),
        bodies,
    }
}

#[test]
fn counts_and_extents_are_those_of_another_program() {
    let Some(folder) = shared_meshes("counts over the shared meshes") else { return };
    let table = table(&folder);
    assert_eq!(table.len(), 24);
    let mut wrong = Vec::new();
    for (name, expected, extents) in table {
        let file = read(&folder.join(&name));
        let found = count(&file.mesh, file.unit.metres());
        if found != expected {
            wrong.push(format!("{name}: {found:?}, not {expected:?}"));
        }
        let (low, high) = file.mesh.bounds().expect("vertices");
        let size = (high - low) / file.unit.metres();
        let error = ((size - extents).abs() / extents).max_element();
        assert!(error < 0.01, "{name}: extents {size}, not {extents}");
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_shared_mesh_is_cleaned_and_the_table_printed() {
    let Some(folder) = shared_meshes("cleaning of the shared meshes") else { return };
    for (name, row, _) in table(&folder) {
        let start = Instant::now();
        let file = read(&folder.join(&name));
        let (unit, format) = (file.unit, file.format);
        let (mesh, report) = clean(file.mesh).unwrap_or_else(|error| panic!("{name}: {error}"));
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "| {name} | {format} | {unit} | {} / {} | {} | {} | {} | {seconds:.3} |",
            report.bodies,
            report.shells,
            report.boundary_edges,
            report.non_manifold_edges,
            report.notes().join("; ")
        );
        assert_eq!(report.triangles_before, row.triangles, "{name}");
        assert_eq!(report.triangles + report.degenerate_faces + report.duplicate_faces, row.triangles, "{name}");
        assert!(report.consistently_oriented, "{name}: {} edges disagree", report.inconsistent_edges);
        assert_eq!(report.closed, name != "other_cmu_WP_outerface.STL", "{name}");
        assert!(mesh.volume() > 0.0 || !report.closed, "{name} has volume {}", mesh.volume());
        let (again, second) = clean(mesh.clone()).expect("a clean mesh stays clean");
        assert_eq!((&again, second.repairs(), second.merged_equal), (&mesh, 0, 0), "{name}: cleaning twice changes it");
    }
}

#[test]
fn the_same_part_in_metres_and_in_millimetres_comes_out_at_one_size() {
    let Some(folder) = shared_meshes("the unit trap of part 00000006") else { return };
    let part = "00000006_d4fe04f0f5f84b52bd4f10e4_trimesh_001";
    let size = |extension: &str| {
        let file = read(&folder.join(format!("{part}.{extension}")));
        assert!(file.unit_assumed && file.unit_reason.contains("--unit"), "{}", file.unit_reason);
        let (low, high) = file.mesh.bounds().expect("vertices");
        high - low
    };
    let (obj, stl) = (size("obj"), size("stl"));
    assert!((obj - stl).abs().max_element() < 1e-7, "{obj} against {stl}");
    assert!((obj - DVec3::new(4.763e-3, 5.499e-3, 1.587e-3)).abs().max_element() < 1e-6, "{obj}");
}

#[test]
fn the_same_file_gives_the_same_mesh_every_time() {
    let Some(folder) = shared_meshes("repeatability of cleaning") else { return };
    for name in ["other_cmu_WP_outerface.STL", "other_trimesh_featuretype.STL"] {
        // Every call uses different hash keys.
        let run = || clean(read(&folder.join(name)).mesh).expect("it can be cleaned");
        let first = run();
        (0..3).for_each(|_| assert_eq!(run(), first, "{name}"));
    }
}
