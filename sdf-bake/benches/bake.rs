//! Compares baking with parry3d and OpenVDB's `vdb_tool` in the same run: CPU seconds and ratios.
//!
//! `cargo bench -p sdf-bake --bench bake [-- MESH...]` bakes the gear, the sliver plate, three parts of the shared
//! folder (`ROBOFIN_SHARED`) and the meshes given; `--alone` omits the other programs, `--only=NAME` selects the meshes
//! whose names start with it. Each figure is the least of five runs that alternate with `vdb_tool`; short bakes run
//! more often; parry runs once. `apart` is the speed-up of two single-threaded bakes that run at once, which is the
//! most that the machine's two cores offer. All work for a mesh in memory is counted; from `vdb_tool`, whose process
//! also reads the file, the time of a run that only reads is subtracted.

#[path = "../tests/common/parts.rs"]
mod parts;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Barrier, OnceLock};
use std::time::Instant;

use parry3d::math::Vector;
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};
use sdf_bake::clean::clean;
use sdf_bake::grid::{BRICK_VOXELS, voxel_at};
use sdf_bake::read::{UnitChoice, read_mesh};
use sdf_bake::{BakeOptions, BrickGrid, Mesh, SignChoice, bake};
use tempfile::NamedTempFile;

/// Sampling interval of the band's points for parry; its time is scaled up by this factor.
const SAMPLED: usize = 16;

/// Least number of runs, of which the fastest counts.
const RUNS: usize = 5;

/// Total time for which short bakes are repeated [s].
const ENOUGH: f64 = 3.0;

/// Parts of the shared folder: a long bracket, a curved solid, an open surface of a real weldment.
const SHARED: [&str; 3] = [
    "00000125_e18c7feacfb54f3880659b43_trimesh_000.obj",
    "00010009_d97409455fa543b3a224250f_trimesh_000.ply",
    "other_cmu_WP_outerface.STL",
];

fn main() {
    let mut cases = vec![("gear".to_string(), parts::gear(500, 25)), ("slivers".into(), parts::sliver_plate(8208))];
    cases.extend(files().iter().map(|file| {
        let read = read_mesh(file, UnitChoice::Auto).expect("a mesh file");
        let name = file.file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into());
        (name, clean(read.mesh).expect("a usable mesh").0)
    }));
    if let Some(only) = std::env::args().find_map(|argument| argument.strip_prefix("--only=").map(str::to_string)) {
        cases.retain(|(name, _)| name.starts_with(&only));
    }
    let alone = std::env::args().any(|argument| argument == "--alone");
    let vdb_tool = !alone && Command::new("vdb_tool").arg("-version").output().is_ok();
    if !alone && !vdb_tool {
        println!("vdb_tool is not installed: no figures of OpenVDB");
    }
    println!(
        "{:24} {:>9} {:>5} {:>9} {:>7} {:>8} {:>6} {:>8} {:>6} {:>9} {:>6} {:>6}",
        "mesh",
        "triangles",
        "res",
        "band",
        "bake s",
        "parry s",
        "ratio",
        "vdb s",
        "ratio",
        "2 threads",
        "faster",
        "apart"
    );
    for (name, mesh) in &cases {
        for resolution in [256.0, 512.0] {
            row(name, mesh, resolution, alone, vdb_tool);
        }
    }
}

/// The meshes given, and those of the shared folder.
fn files() -> Vec<PathBuf> {
    let named = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).map(PathBuf::from);
    let Some(shared) = std::env::var_os("ROBOFIN_SHARED") else {
        println!("ROBOFIN_SHARED is not set: no parts of the shared folder");
        return named.collect();
    };
    let folder = PathBuf::from(shared).join("data/abc");
    SHARED.iter().map(|file| folder.join(file)).chain(named).collect()
}

fn row(name: &str, mesh: &Mesh, resolution: f64, alone: bool, vdb_tool: bool) {
    let (low, high) = mesh.bounds().expect("a mesh with vertices");
    let voxel = (high - low).max_element() / resolution;
    let options = BakeOptions { sign: SignChoice::Winding, ..BakeOptions::with_voxel(voxel) };
    let pools = [1, 2].map(|n| rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("threads"));
    let Ok((grid, report)) = bake(mesh, &options) else {
        println!("{name:24} is refused");
        return;
    };
    let file = vdb_tool.then(|| write_obj(mesh));
    let (mut bake_s, mut clocks, mut apart, mut vdb_s) = (f64::INFINITY, [f64::INFINITY; 2], f64::INFINITY, f64::NAN);
    let started = Instant::now();
    for run in 0.. {
        if run >= RUNS && started.elapsed().as_secs_f64() > ENOUGH {
            break;
        }
        for (pool, clock) in pools.iter().zip(&mut clocks) {
            let (seconds, wall) = pool.install(|| timed(mesh, &options));
            if pool.current_num_threads() == 1 {
                bake_s = bake_s.min(seconds);
            }
            *clock = clock.min(wall);
        }
        apart = apart.min(two_apart(mesh, &options));
        if let Some(file) = file.as_ref().filter(|_| run < RUNS) {
            vdb_s = vdb_s.min(vdb_seconds(file.path(), voxel));
        }
    }
    let parry = if alone { f64::NAN } else { pools[0].install(|| parry_seconds(mesh, &grid)) };
    println!(
        "{name:24.24} {:9} {resolution:5} {:9} {bake_s:7.3} {parry:8.3} {:6.2} {vdb_s:8.3} {:6.2} {:9.3} {:6.2} {:6.2}",
        mesh.triangles.len(),
        report.active_voxels,
        parry / bake_s,
        vdb_s / bake_s,
        clocks[1],
        clocks[0] / clocks[1],
        2.0 * clocks[0] / apart
    );
}

/// CPU time of this thread and wall time of a bake [s].
fn timed(mesh: &Mesh, options: &BakeOptions) -> (f64, f64) {
    let (cpu, started) = (cpu_seconds(), Instant::now());
    let baked = bake(mesh, options);
    let seconds = (cpu_seconds() - cpu, started.elapsed().as_secs_f64());
    drop(baked);
    seconds
}

/// Wall time until two bakes that start together, on one thread each, have both ended [s].
fn two_apart(mesh: &Mesh, options: &BakeOptions) -> f64 {
    let begin = Barrier::new(2);
    let one = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        begin.wait();
        pool.install(|| timed(mesh, options).1)
    };
    std::thread::scope(|scope| {
        let other = scope.spawn(one);
        one().max(other.join().expect("a bake that ends"))
    })
}

fn write_obj(mesh: &Mesh) -> NamedTempFile {
    let mut file = tempfile::Builder::new().suffix(".obj").tempfile().expect("a temporary file");
    let vertices = mesh.positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    let text: String = vertices.chain(faces).collect();
    file.write_all(text.as_bytes()).expect("a written file");
    file
}

/// CPU time of `vdb_tool` on the same lattice, without reading the file [s].
fn vdb_seconds(file: &Path, voxel: f64) -> f64 {
    let run = |arguments: &[String]| {
        let before = children_cpu_seconds();
        let output =
            Command::new("vdb_tool").args(["-read".into(), file.display().to_string()]).args(arguments).output();
        assert!(output.is_ok_and(|output| output.status.success()), "vdb_tool failed");
        children_cpu_seconds() - before
    };
    let reading = run(&[]);
    run(&["-mesh2ls".into(), format!("voxel={voxel}"), "width=3".into()]) - reading
}

/// CPU time of all ended child processes, from Linux [s].
fn children_cpu_seconds() -> f64 {
    const TICKS_PER_SECOND: f64 = 100.0;
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = text.rsplit(") ").next().unwrap_or_default().split(' ');
    fields.skip(13).take(2).filter_map(|ticks| ticks.parse::<f64>().ok()).sum::<f64>() / TICKS_PER_SECOND
}

/// Time of parry to build its tree and to project the points of the band [s], scaled up from a sample of rows.
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

/// CPU time of this thread [s]; wall time where Linux's figure is not available.
fn cpu_seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let clock = || START.get_or_init(Instant::now).elapsed().as_secs_f64();
    let schedule = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = schedule.and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(clock, |ns| ns * 1e-9)
}
