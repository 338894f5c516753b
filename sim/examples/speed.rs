//! Simulation speed of two passes over a weld bead: `cargo run --release -p robofin-sim --example speed`.

#[path = "../tests/common/mod.rs"]
mod common;

use common::{GRIND_RATE, WHEEL, base, fresh, line, welded_plate};
use robot::Tool;
use sim::{Pass, PassSettings, Path, run_pass};

fn main() {
    let (tool, settings, model) = (Tool::from(WHEEL), PassSettings::default(), base());
    let forward = Path::along(&line(-0.04, 0.04, 0.0), 5e-3).expect("a straight path");
    for voxel in [0.4e-3, 0.25e-3] {
        let mut grid = welded_plate(voxel, 1.0);
        let (mut steps, mut seconds) = (0, 0.0);
        for path in [forward.clone(), forward.reversed()] {
            let (before, start) = (grid.volume(), cpu_seconds());
            let pass = Pass::first(&tool, &path, &settings, &model);
            let record = run_pass(&mut grid, pass, &mut fresh(&model), &mut |_| {}).expect("a pass");
            seconds += cpu_seconds() - start;
            steps += record.steps;
            println!(
                "  removed {:.2} mm³, k∫∫p dA dt {:.2} mm³, k∫F dt {:.2} mm³",
                (before - grid.volume()) * 1e9,
                GRIND_RATE * record.load_impulse * 1e9,
                GRIND_RATE * record.impulse * 1e9,
            );
        }
        println!(
            "{} mm voxels: {steps} steps in {seconds:.3} CPU s, {:.1} times real time, {:.1} MB",
            voxel * 1e3,
            2.0 * forward.duration() / seconds,
            grid.bytes() as f64 / 1e6
        );
    }
}

/// CPU time of the calling thread [s]; the simulator runs on it alone.
fn cpu_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux keeps a thread's CPU time");
    stat.split(' ').next().and_then(|ns| ns.parse::<f64>().ok()).expect("nanoseconds") * 1e-9
}
