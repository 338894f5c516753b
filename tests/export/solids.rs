//! Small closed solids with known volumes, and an asset folder made of them.

use std::fs;
use std::path::{Path, PathBuf};

use export::glb::{GlbMaterial, GlbPart, write_glb};
use glam::{DVec3, dvec3};
use sdf_bake::Mesh;

/// Makes a box [m] with 8 vertices and 12 outward triangles.
pub(crate) fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let corner = |i: u32| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        dvec3(pick(0), pick(1), pick(2))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

/// Makes an ellipsoid with given semi-axes [m], symmetric about its equator plane: half of its volume lies above.
pub(crate) fn lens(centre: DVec3, semi_axes: DVec3) -> Mesh {
    let (rings, segments) = (23, 48);
    let point = |ring: u32, segment: u32| {
        let (polar, turn) = (
            std::f64::consts::PI * f64::from(ring) / f64::from(rings + 1),
            std::f64::consts::TAU * f64::from(segment) / f64::from(segments),
        );
        centre + semi_axes * dvec3(polar.sin() * turn.cos(), polar.sin() * turn.sin(), polar.cos())
    };
    let mut mesh = Mesh { positions: vec![centre + semi_axes * DVec3::Z], triangles: Vec::new() };
    mesh.positions.extend((1..=rings).flat_map(|ring| (0..segments).map(move |segment| point(ring, segment))));
    mesh.positions.push(centre - semi_axes * DVec3::Z);
    let at = |ring: u32, segment: u32| 1 + ring * segments + segment % segments;
    for segment in 0..segments {
        mesh.triangles.push([0, at(0, segment), at(0, segment + 1)]);
        let [south, last] = [1 + rings * segments, rings - 1];
        mesh.triangles.push([south, at(last, segment + 1), at(last, segment)]);
        for ring in 0..rings - 1 {
            let [a, b] = [at(ring, segment), at(ring, segment + 1)];
            let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
            mesh.triangles.extend([[a, c, d], [a, d, b]]);
        }
    }
    mesh
}

/// Makes a plate, 60 x 40 x 10 mm, with its upper face in the plane z = 0.
pub(crate) fn plate() -> Mesh {
    cuboid(dvec3(-0.03, -0.02, -0.01), dvec3(0.03, 0.02, 0.0))
}

/// Makes a lens-shaped weld bead, 40 x 6 x 3 mm, half below the plate's surface.
pub(crate) fn bead() -> Mesh {
    lens(DVec3::ZERO, dvec3(0.02, 0.003, 0.0015))
}

/// Writes the plate as `base` and the bead as `weld-1`.
pub(crate) fn welded_glb() -> Vec<u8> {
    let (plate, bead) = (plate(), bead());
    let parts = [
        GlbPart { name: "base", mesh: &plate, weld_id: 0, material: GlbMaterial::Base },
        GlbPart { name: "weld-1", mesh: &bead, weld_id: 1, material: GlbMaterial::Weld },
    ];
    write_glb(&parts, serde_json::Map::new()).expect("both solids are sound")
}

/// Writes `welded.glb` and `welds.json` into a new folder.
pub(crate) fn asset(folder: &Path, name: &str) -> PathBuf {
    let asset = folder.join(name);
    fs::create_dir_all(&asset).expect("the folder can be made");
    fs::write(asset.join("welded.glb"), welded_glb()).expect("the GLB can be written");
    let x: Vec<f64> = (0..=20).map(|i| -0.02 + 0.002 * f64::from(i)).collect();
    let positions: Vec<[f64; 3]> = x.iter().map(|&x| [x, 0.0, 0.0]).collect();
    let arc_length: Vec<f64> = x.iter().map(|x| x + 0.02).collect();
    let welds = serde_json::json!({
        "format": "robofin-welds/1",
        "welds": [{
            "id": 1, "width_mm": 6.0, "height_mm": 1.5, "length_mm": 40.0, "volume_mm3": 377.0,
            "curve": { "position": positions, "arc_length": arc_length },
        }],
    });
    fs::write(asset.join("welds.json"), welds.to_string()).expect("the welds can be written");
    asset
}
