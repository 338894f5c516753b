//! Compares geodesic tracing with potpourri3d (geometry-central) in the same run: CPU seconds, ratios and end points.
//!
//! `cargo bench -p weldgen --bench trace` traces 1,000 straightest geodesics of half the diagonal on a gear of about
//! 100,000 triangles and on a sphere of 81,920, and from the same starts with curvature. Each figure is the least of
//! five runs.
//! `ROBOFIN_PYTHON` names an interpreter with numpy and potpourri3d 1.4; without it that column is missing.

#[path = "../../sdf-bake/tests/common/parts.rs"]
mod parts;
#[path = "../tests/reference/mod.rs"]
mod reference;
#[path = "../tests/shapes/mod.rs"]
mod shapes;

use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;
use std::time::Instant;

use glam::DVec3;
use sdf_bake::Mesh;
use weldgen::curvature::CurvatureProfile;
use weldgen::topology::Topology;
use weldgen::trace::{Trace, TraceEnd, TraceLimits, TraceStart, trace};

const TRACES: usize = 1000;
const RUNS: usize = 5;
/// Published figures of potpourri3d 1.4 on 100,000 triangles [CPU s]: mesh preparation, 1,000 traces.
const PUBLIC: [f64; 2] = [0.15, 0.10];

fn main() {
    for (name, mesh) in [("gear", parts::gear(500, 25)), ("sphere", shapes::icosphere(0.1, 6))] {
        println!("{name}: {} triangles, {TRACES} traces of half the diagonal", mesh.triangles.len());
        row(&mesh);
    }
}

fn row(mesh: &Mesh) {
    let starts = starts(mesh);
    let length = 0.5 * mesh.diagonal();
    let (build_s, topology) = least(|| Topology::new(mesh));
    let run = |curvature: f64| {
        let profile = CurvatureProfile::constant(curvature);
        let limits = TraceLimits { length, spacing: length, sharp_angle: PI, max_steps: 1_000_000 };
        let one = |start: &TraceStart| trace(mesh, &topology, *start, &profile, limits);
        least(|| starts.iter().map(one).collect::<Vec<Trace>>())
    };
    let (straight_s, traces) = run(0.0);
    let (curved_s, _) = run(3.0 / mesh.diagonal());
    assert!(traces.iter().all(|trace| trace.end == TraceEnd::Length));
    let crossings: usize = traces.iter().map(|trace| trace.crossings).sum();
    let each = 1e9 * straight_s / crossings as f64;
    println!("  neighbours {build_s:.4} s, {:.1} times the public figure's speed", PUBLIC[0] / build_s);
    println!("  geodesics  {straight_s:.4} s, {:.1} times; {each:.0} ns a crossing", PUBLIC[1] / straight_s);
    println!("  with κ     {curved_s:.4} s, no peer");
    println!(
        "  walked back, they miss their starts by at most {:.1e} of the diagonal",
        missed(mesh, &topology, &traces)
    );
    let ends = |start| reference::geodesic_end(mesh, &topology, start, length);
    let exact: Vec<Option<DVec3>> = starts.iter().map(ends).collect();
    let ours: Vec<DVec3> = traces.iter().map(|trace| trace.points[1].position).collect();
    println!("  ends off a reference of 32 digits: {}", off(mesh, &ours, &exact));
    match potpourri3d(mesh, &starts, length) {
        Ok((peer_build, peer_trace, ends)) => {
            println!("  potpourri3d in this run: {peer_build:.4} s and {peer_trace:.4} s");
            println!("  ratios {:.1} and {:.1}", peer_build / build_s, peer_trace / straight_s);
            println!("  its ends off that reference: {}", off(mesh, &ends, &exact));
        }
        Err(why) => println!("  no figures of potpourri3d: {why}"),
    }
}

/// Formats the distances of end points from those of the reference.
fn off(mesh: &Mesh, ends: &[DVec3], exact: &[Option<DVec3>]) -> String {
    let known = ends.iter().zip(exact).filter_map(|(end, exact)| Some(end.distance((*exact)?) / mesh.diagonal()));
    let mut apart: Vec<f64> = known.collect();
    apart.sort_by(f64::total_cmp);
    let (median, worst) = (apart[apart.len() / 2], apart[apart.len() - 1]);
    format!("median {median:.1e}, at most {worst:.1e} of the diagonal, {} ends", apart.len())
}

/// Gap at the start of traces that are traced back from their end [diagonals].
fn missed(mesh: &Mesh, topology: &Topology, traces: &[Trace]) -> f64 {
    let gap = |there: &Trace| {
        let last = there.points[1];
        let start = TraceStart { face: last.face, barycentric: last.barycentric, heading: -last.tangent };
        let limits = TraceLimits { length: there.length, spacing: there.length, sharp_angle: PI, max_steps: 1_000_000 };
        let back = trace(mesh, topology, start, &CurvatureProfile::constant(0.0), limits);
        back.points[1].position.distance(there.points[0].position)
    };
    traces.iter().map(gap).fold(0.0, f64::max) / mesh.diagonal()
}

/// Starts distributed over the triangles, each inside its triangle, with headings in its plane.
fn starts(mesh: &Mesh) -> Vec<TraceStart> {
    let mut numbers = shapes::Numbers(5);
    let mut start = |i: usize| {
        let face = i * mesh.triangles.len() / TRACES;
        let [a, b, c] = [0, 1, 2].map(|_| 0.1 + numbers.next());
        let barycentric = [a, b, c].map(|weight| weight / (a + b + c));
        let [one, other, _] = mesh.corners(face);
        let along = (other - one).normalize();
        let (sin, cos) = (2.0 * PI * numbers.next()).sin_cos();
        TraceStart { face: face as u32, barycentric, heading: cos * along + sin * mesh.normal(face).cross(along) }
    };
    (0..TRACES).map(&mut start).collect()
}

/// CPU time of this thread [s]; wall time where Linux's figure is not available.
fn processor_s() -> f64 {
    static STARTED: OnceLock<Instant> = OnceLock::new();
    let stat = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = stat.split(' ').next().and_then(|word| word.parse::<f64>().ok());
    nanoseconds.map_or_else(|| STARTED.get_or_init(Instant::now).elapsed().as_secs_f64(), |ns| 1e-9 * ns)
}

/// Least time [s] of several runs, and the result of the last one.
fn least<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let (mut best, mut runs) = (f64::INFINITY, 0);
    loop {
        let started = processor_s();
        let made = work();
        best = best.min(processor_s() - started);
        runs += 1;
        if runs == RUNS {
            return (best, made);
        }
    }
}

/// Time [s] of potpourri3d to prepare the mesh and to trace, and the end points.
fn potpourri3d(mesh: &Mesh, starts: &[TraceStart], length: f64) -> Result<(f64, f64, Vec<DVec3>), String> {
    let folder = std::env::temp_dir().join(format!("weldgen-trace-{}", std::process::id()));
    fs::create_dir(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let answer = ask(&folder, mesh, starts, length);
    fs::remove_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    answer
}

fn ask(folder: &Path, mesh: &Mesh, starts: &[TraceStart], length: f64) -> Result<(f64, f64, Vec<DVec3>), String> {
    let bytes = |numbers: Vec<f64>| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
    let of_start = |start: &TraceStart| {
        let heading = length * start.heading;
        [vec![f64::from(start.face)], start.barycentric.to_vec(), heading.to_array().to_vec()].concat()
    };
    let files = [
        ("positions", bytes(mesh.positions.iter().flat_map(|p| p.to_array()).collect())),
        ("triangles", bytes(mesh.triangles.iter().flatten().map(|&v| f64::from(v)).collect())),
        ("starts", bytes(starts.iter().flat_map(of_start).collect())),
    ];
    for (name, content) in files {
        fs::write(folder.join(name), content).map_err(|error| error.to_string())?;
    }
    let python = std::env::var_os("ROBOFIN_PYTHON").unwrap_or_else(|| "python3".into());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/potpourri3d_traces.py");
    let run = Command::new(&python).arg(script).arg(folder).output().map_err(|error| error.to_string())?;
    if !run.status.success() {
        let said = String::from_utf8_lossy(&run.stderr);
        return Err(said.lines().last().unwrap_or("it failed without a word").to_owned());
    }
    let said = String::from_utf8_lossy(&run.stdout);
    let seconds: Vec<f64> = said.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [build, trace] = seconds[..] else { return Err(format!("two numbers were expected, not {said:?}")) };
    let ends = fs::read(folder.join("ends")).map_err(|error| error.to_string())?;
    let number = |eight: &[u8]| f64::from_le_bytes(eight.try_into().unwrap_or_default());
    let ends = ends.chunks_exact(24).map(|end| DVec3::from_array([0, 8, 16].map(|at| number(&end[at..at + 8]))));
    Ok((build, trace, ends.collect()))
}
