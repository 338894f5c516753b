//! How fast two passes over a weld bead are simulated: `cargo run --release -p sim --example speed`.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Instant;

use common::{LAW, WHEEL, line, welded_plate};
use sim::{Pass, Path, Process, Tool, run_pass};

fn main() {
    let (tool, process) = (Tool::from(WHEEL), Process::default());
    let forward = Path::along(&line(-0.04, 0.04, 0.0), 5e-3).expect("a straight path");
    for voxel in [0.4e-3, 0.25e-3] {
        let mut grid = welded_plate(voxel, 1.0);
        let start = Instant::now();
        let mut steps = 0;
        for path in [forward.clone(), forward.reversed()] {
            let record = run_pass(&mut grid, Pass { tool: &tool, path: &path, process: &process, law: &LAW }, &mut |_| {})
                .expect("a pass");
            steps += record.steps;
            println!(
                "  removed {:.2} mm³, k∫F dt {:.2} mm³, ∫∫ r dA dt {:.2} mm³",
                record.removed_volume * 1e9,
                LAW.grind_rate * record.impulse * 1e9,
                record.removed_volume_by_law * 1e9
            );
        }
        let wall = start.elapsed().as_secs_f64();
        println!(
            "{} mm voxels: {steps} steps in {wall:.2} s, {:.0} steps/s, {:.1} times real time, {:.1} MB",
            voxel * 1e3,
            steps as f64 / wall,
            2.0 * forward.duration() / wall,
            grid.bytes() as f64 / 1e6
        );
    }
}
