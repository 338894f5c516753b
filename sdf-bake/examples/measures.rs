//! Compares volume and area of fields with closed forms, from coarse to fine; fails if a documented accuracy is not
//! met.
//!
//! ```sh
//! cargo run --release -p sdf-bake --example measures
//! ```

#[path = "../tests/common/parts.rs"]
mod parts;

use std::f64::consts::PI;

use glam::{DMat3, DVec3};
use sdf_bake::{BakeOptions, BrickGrid, bake};

/// Voxels across the longest side.
const ACROSS: [f64; 4] = [32.0, 64.0, 128.0, 256.0];

/// Relative errors of volume and area, from the field and from its mesh, at one voxel size.
struct Errors {
    volume: f64,
    mesh_volume: f64,
    area: f64,
}

fn main() {
    println!(
        "{:8} {:>6} {:>12} {:>6} {:>12} {:>6} {:>12}",
        "", "across", "volume", "order", "area", "order", "mesh volume"
    );
    let centre = DVec3::new(1.1e-5, 2.3e-5, -0.7e-5);
    let sphere = table("sphere", 4.0 / 3.0 * PI * 1e-6, 4.0 * PI * 1e-4, |across| {
        let half = DVec3::splat(0.0101);
        BrickGrid::from_distance(-half, half, 0.02 / across, 3.0, |p| p.distance(centre) - 0.01)
    });
    let torus = table("torus", 2.0 * PI * PI * 0.007 * 9e-6, 4.0 * PI * PI * 0.007 * 0.003, |across| {
        let half = DVec3::new(0.0101, 0.0101, 0.0031);
        BrickGrid::from_distance(-half, half, 0.02 / across, 3.0, |p| (p.x.hypot(p.y) - 0.007).hypot(p.z) - 0.003)
    });
    let half = DVec3::new(0.010, 0.0071, 0.0052);
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.7).normalize(), 0.6);
    let faces = 8.0 * (half.x * half.y + half.y * half.z + half.z * half.x);
    table("box", 8.0 * half.element_product(), faces, |across| {
        let reach = DVec3::splat(half.length());
        BrickGrid::from_distance(-reach, reach, 0.02 / across, 3.0, |p| {
            let q = (turn.transpose() * p).abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        })
    });
    let gear = parts::gear(480, 1);
    table("gear", gear.volume(), gear.area(), |across| {
        bake(&gear, &BakeOptions::with_voxel(0.08 / across)).expect("a closed gear").0
    });
    for (name, errors) in [("sphere", sphere), ("torus", torus)] {
        let at_64 = &errors[1];
        assert!(at_64.volume.abs() < 1e-3 && at_64.area.abs() < 1e-3, "{name} at 64 voxels");
        let order = (errors[0].area / errors[2].area).abs().log2() / 2.0;
        assert!(order > 1.7, "{name}: the area converges at order {order:.2}");
    }
}

/// Prints a part's errors at all voxel sizes.
fn table(name: &str, volume: f64, area: f64, field: impl Fn(f64) -> BrickGrid) -> Vec<Errors> {
    let mut rows: Vec<Errors> = Vec::new();
    for across in ACROSS {
        let grid = field(across);
        let mesh = grid.surface_mesh();
        let row = Errors {
            volume: grid.volume() / volume - 1.0,
            mesh_volume: mesh.volume() / volume - 1.0,
            area: mesh.area() / area - 1.0,
        };
        let order = |before: Option<f64>, now: f64| {
            before.map_or(String::new(), |before| format!("{:.1}", (before / now).abs().log2()))
        };
        println!(
            "{name:8} {across:>6} {:>+12.2e} {:>6} {:>+12.2e} {:>6} {:>+12.2e}",
            row.volume,
            order(rows.last().map(|last| last.volume), row.volume),
            row.area,
            order(rows.last().map(|last| last.area), row.area),
            row.mesh_volume
        );
        rows.push(row);
    }
    rows
}
