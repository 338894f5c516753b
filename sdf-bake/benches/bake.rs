//! Baking against parry3d on the same points in the same run: CPU seconds, on one thread, and their ratio.
//!
//! `cargo bench -p sdf-bake --bench bake [-- MESH...]` bakes the gear and the sliver plate, and meshes named;
//! `--alone` leaves parry out.

#[path = "../tests/common/parts.rs"]
mod parts;

use std::path::Path;
use std::sync::OnceLock;
use std::time::Instant;

use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};
use sdf_bake::clean::clean;
use sdf_bake::grid::{BRICK_VOXELS, voxel_at};
use sdf_bake::read::{UnitChoice, read_mesh};
use sdf_bake::{BakeOptions, BrickGrid, Mesh, SignChoice, bake};

/// Of the band's points, parry is asked about one in this many; its time is scaled up.
const SAMPLED: usize = 16;

fn main() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let mut cases = vec![("gear".to_string(), parts::gear(500, 25)), ("slivers".into(), parts::sliver_plate(8208))];
    for file in std::env::args().skip(1).filter(|argument| !argument.starts_with("--")) {
        let read = read_mesh(Path::new(&file), UnitChoice::Auto).expect("a mesh file");
        let name = Path::new(&file).file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into());
        cases.push((name, clean(read.mesh).expect("a usable mesh").0));
    }
    println!(
        "{:24} {:>9} {:>5} {:>9} {:>9} {:>8} {:>8} {:>6}",
        "mesh", "triangles", "res", "bricks", "band", "bake s", "parry s", "ratio"
    );
    for (name, mesh) in &cases {
        for resolution in [256.0, 512.0] {
            pool.install(|| row(name, mesh, resolution));
            println!("{:24} on two threads {:.3} s by the clock", "", two_threads(mesh, resolution));
        }
    }
}

fn row(name: &str, mesh: &Mesh, resolution: f64) {
    let (low, high) = mesh.bounds().expect("a mesh with vertices");
    let voxel = (high - low).max_element() / resolution;
    let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(voxel) };
    let mut fastest = f64::INFINITY;
    let mut baked = None;
    for _ in 0..3 {
        let started = cpu_seconds();
        baked = Some(bake(mesh, &options));
        fastest = fastest.min(cpu_seconds() - started);
    }
    let Some(Ok((grid, report))) = baked else {
        println!("{name:24} is refused");
        return;
    };
    let alone = std::env::args().any(|argument| argument == "--alone");
    let parry = if alone { f64::NAN } else { parry_seconds(mesh, &grid) };
    println!(
        "{name:24.24} {:9} {resolution:5} {:9} {:9} {fastest:8.3} {parry:8.3} {:6.2}",
        mesh.triangles.len(),
        report.bricks,
        report.active_voxels,
        parry / fastest
    );
}

/// Seconds by the clock on two threads, the least of three.
fn two_threads(mesh: &Mesh, resolution: f64) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("two threads");
    let (low, high) = mesh.bounds().expect("a mesh with vertices");
    let options = BakeOptions::with_voxel((high - low).max_element() / resolution);
    let run = |_| {
        let started = Instant::now();
        let baked = pool.install(|| bake(mesh, &options));
        let seconds = started.elapsed().as_secs_f64();
        drop(baked);
        seconds
    };
    (0..3).map(run).fold(f64::INFINITY, f64::min)
}

/// Seconds parry takes to build its tree and to project the points of the band, scaled up from a sample of rows.
fn parry_seconds(mesh: &Mesh, grid: &BrickGrid) -> f64 {
    let started = cpu_seconds();
    let vertices = mesh.positions.iter().map(|p| Vector::new(p.x as f32, p.y as f32, p.z as f32)).collect();
    let shape =
        TriMesh::with_flags(vertices, mesh.triangles.clone(), TriMeshFlags::ORIENTED).expect("a mesh parry takes");
    let build = cpu_seconds() - started;
    let started = cpu_seconds();
    let mut sum = 0.0;
    for (slot, &brick) in grid.bricks.iter().enumerate().step_by(SAMPLED) {
        for offset in 0..BRICK_VOXELS {
            if grid.phi[slot * BRICK_VOXELS + offset].abs() < grid.band {
                let point = grid.position(voxel_at(brick, offset)).as_vec3();
                sum += shape.distance_to_local_point(Vector::new(point.x, point.y, point.z), false);
            }
        }
    }
    assert!(f32::is_finite(sum));
    build + (cpu_seconds() - started) * SAMPLED as f64
}

/// Seconds this thread has run: Linux counts them; elsewhere the clock must do.
fn cpu_seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let clock = || START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let schedule = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = schedule.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(clock, |ns| ns * 1e-9)
}
