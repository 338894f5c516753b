use std::collections::HashMap;
use std::path::PathBuf;
use std::time::Instant;

use sdf_bake::Mesh;
use sdf_bake::clean::{EdgeMap, clean};
use sdf_bake::read::{UnitChoice, read_mesh};

fn shared() -> Option<PathBuf> {
    let root = std::env::var_os("ROBOFIN_SHARED")
        .map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    Some(root.join("data/abc")).filter(|p| p.is_dir())
}

#[test]
fn survey() {
    let dir = shared().unwrap();
    let mut names: Vec<_> =
        std::fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).filter(|p| !p.ends_with("SOURCES.md")).collect();
    names.sort();
    for path in names {
        let t = Instant::now();
        let file = read_mesh(&path, UnitChoice::Auto).unwrap();
        let tr = t.elapsed().as_secs_f64();
        let m = merged(&file.mesh);
        let e = EdgeMap::new(&m);
        let b = e.components(|_| true).1;
        let bm = e.components(|u| u.len() == 2).1;
        let heights: Vec<f64> = (0..m.triangles.len())
            .map(|t| {
                let [a, b, c] = m.corners(t);
                m.doubled_area_normal(t).length() / a.distance(b).max(b.distance(c)).max(c.distance(a)) / m.diagonal()
            })
            .collect();
        let under = |h: f64| heights.iter().filter(|&&x| !(x > h)).count();
        println!(
            "{} {} t{} v{} open{} nm{} b{} bm{} h:{:?}",
            path.file_name().unwrap().to_string_lossy(),
            file.unit,
            m.triangles.len(),
            m.positions.len(),
            e.boundary_count(),
            e.non_manifold_count(),
            b,
            bm,
            [1e-16, 1e-14, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5].map(under)
        );
        let t = Instant::now();
        let r = clean(file.mesh).unwrap().1;
        println!("   {:?} {tr:.3} {:.3}", r, t.elapsed().as_secs_f64());
    }
}

fn merged(mesh: &Mesh) -> Mesh {
    let mut at = HashMap::new();
    let mut out = Mesh::default();
    for t in &mesh.triangles {
        let t = t.map(|v| {
            let p = mesh.positions[v as usize];
            *at.entry((p + glam::DVec3::ZERO).to_array().map(f64::to_bits)).or_insert_with(|| {
                out.positions.push(p);
                out.positions.len() as u32 - 1
            })
        });
        out.triangles.push(t);
    }
    out
}
