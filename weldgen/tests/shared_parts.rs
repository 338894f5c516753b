//! Welds on real parts: every mesh of the shared folder, four welds of three difficulties each.

use std::collections::HashMap;
use std::path::PathBuf;

use sdf_bake::Mesh;
use sdf_bake::bake::WindingTree;
use sdf_bake::clean::clean;
use sdf_bake::query::MeshQuery;
use sdf_bake::read::{UnitChoice, read_mesh};
use weldgen::exposure::{ExposureRays, exposure};
use weldgen::{Difficulty, Surface, Weld, WeldRequest, place_weld_on};

/// The meshes of the shared folder, sorted. Prints a note if there is none, and fails if they are required.
fn shared_parts() -> Vec<PathBuf> {
    let folder = std::env::var_os("ROBOFIN_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    let Ok(entries) = std::fs::read_dir(folder.join("data/abc")) else {
        assert!(std::env::var_os("ROBOFIN_REQUIRE_SHARED").is_none(), "{} has no data/abc", folder.display());
        eprintln!("NOT TESTED: welds on real parts. {}/data/abc is missing; set ROBOFIN_SHARED.", folder.display());
        return Vec::new();
    };
    let mesh = |path: &PathBuf| {
        path.extension().is_some_and(|e| ["obj", "stl", "ply"].iter().any(|f| e.eq_ignore_ascii_case(f)))
    };
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(mesh).collect();
    files.sort();
    files
}

fn edge_counts(mesh: &Mesh) -> HashMap<(u32, u32), i32> {
    let mut edges = HashMap::new();
    for t in &mesh.triangles {
        for i in 0..3 {
            *edges.entry((t[i], t[(i + 1) % 3])).or_default() += 1;
        }
    }
    edges
}

/// Checks that length and curvature are as requested, unless a shorter weld was used. If three points lie in one face,
/// the circle through them must have the stated curvature.
fn check_dials(weld: &Weld) {
    let shorter = weld.reasons.iter().any(|reason| reason.starts_with("length") && reason.contains("instead of"));
    assert!(shorter || (weld.length / weld.wanted.length - 1.0).abs() < 1e-3, "{} m long", weld.length);
    let asked = weld.wanted.curvature_rms;
    assert!((weld.curvature_rms - asked).abs() <= 0.01 * asked, "{} 1/m instead of {asked}", weld.curvature_rms);
    for three in weld.curve.points.windows(3).filter(|three| three.iter().all(|point| point.face == three[0].face)) {
        let [a, b, c] = [0, 1, 2].map(|i| three[i].position);
        let (ab, bc) = (b - a, c - b);
        let found = 2.0 * ab.cross(bc).length() / (ab.length() * bc.length() * (c - a).length());
        let stated = three[1].geodesic_curvature.abs();
        assert!((found - stated).abs() < 0.01 * asked + 1e-6, "{found} 1/m where {stated} is stated");
    }
}

/// Checks that every directed edge occurs once, and once in the opposite direction: closed, consistently oriented.
fn is_closed(mesh: &Mesh) -> bool {
    let edges = edge_counts(mesh);
    edges.iter().all(|(&(a, b), &count)| count == 1 && edges.get(&(b, a)) == Some(&1))
}

fn check(weld: &Weld, part: &Mesh, query: &MeshQuery, winding: Option<&WindingTree>) {
    weld.curve.validate(part).unwrap();
    check_dials(weld);
    for point in &weld.curve.points {
        assert!(query.closest(point.position).distance < 1e-9 * part.diagonal());
    }
    assert!(is_closed(&weld.bead));
    // The section's centroid lies near the surface, so curvature of the surface changes the volume little.
    let ratio = weld.bead.volume() / weld.profile.swept_volume(weld.length, weld.root_depth);
    assert!((ratio - 1.0).abs() < 0.08, "the bead's volume is {ratio} of the flat one's");
    let fine = ExposureRays { reach: weld.request.exposure_reach, lift: 0.05 * weld.profile.height, rays: 16 * 256 };
    let least = weld.curve.points.iter().min_by(|a, b| a.exposure.total_cmp(&b.exposure)).unwrap();
    let exposure = exposure(query, least.position, least.normal, fine);
    let [low, high] =
        if weld.reasons.iter().any(|r| r.starts_with("exposure")) { [0.0, 1.0] } else { weld.wanted.exposure };
    assert!((low..=high).contains(&exposure), "exposure {exposure} by 16 times the rays");
    let base = weld.profile.half_width_at(weld.root_depth);
    for point in &weld.curve.points {
        let toes = [-base, base].map(|side| point.position + side * point.side - weld.root_depth * point.normal);
        let under = |winding: &WindingTree| toes.iter().all(|toe| winding.winding_number(*toe) > 0.5);
        assert!(winding.is_none_or(under), "a toe is in the air at {} m", point.arc_length);
    }
}

#[test]
fn every_shared_part_gets_a_weld_with_every_seed() {
    let mut failures = Vec::new();
    for path in shared_parts() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let file = read_mesh(&path, UnitChoice::Auto).unwrap();
        let (part, _) = clean(file.mesh).unwrap();
        let query = MeshQuery::new(&part);
        let surface = Surface::new(&part, &query);
        let winding = is_closed(&part).then(|| WindingTree::new(&part));
        for (seed, difficulty) in
            (1..).zip([Difficulty::Medium, Difficulty::Easy, Difficulty::Hard, Difficulty::Medium])
        {
            let request = WeldRequest::of_difficulty(&part, part.diagonal() / 256.0, difficulty);
            match place_weld_on(&surface, &request, seed) {
                Ok(weld) => {
                    check(&weld, &part, &query, winding.as_ref());
                    println!("{name} seed {seed}: {}", weld.reasons.join("; "));
                }
                Err(error) => failures.push(format!("{name} seed {seed}: {error}")),
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
