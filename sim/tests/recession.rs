//! A ball that recedes everywhere at the same speed, in the simulator. A pad larger than the ball acts from its six
//! sides in turn, each with a share of the rate; the shares sum to one and vanish where the surface is steep.

mod common;

use std::f64::consts::PI;

use common::fresh;
use effects::{CompiledModel, Library, Model, Process as Kind, RowCounts};
use glam::DVec3;
use robot::{Controller, Pad, Tool};
use sdf_bake::BrickGrid;
use sim::{Pass, PassSettings, Path, PathSample, run_pass};

const EVEN: &str = r#"
name = "even"
title = "Even recession from all sides"
source = "a partition of unity"

[parameters.speed]
unit = "m/s"
null = 0.0
range = [0.0, 1.0]

[let]
up = "max(x^2 + y^2 + z^2 - tool_x^2 - tool_y^2, 0)"

[modify]
rate = "if(speed > 0, speed * up^4 / max(x^8 + y^8 + z^8, 1e-40 [m^8]), rate)"
"#;

/// Lets all sides of a part recede by `recession` [m] in `rounds`.
fn recede(grid: &mut BrickGrid, recession: f64, rounds: usize) {
    let library = Library::builtin().with(&[("even.toml".to_owned(), EVEN.to_owned())]).expect("an effect");
    let duration = 0.05;
    let mut model = Model::new(Kind::Grinding).with("even");
    model.set("even", "speed", &[recession / rounds as f64 / duration]);
    let model = CompiledModel::new(&model, &library, RowCounts::default()).expect("a model");
    let tool = Tool::from(Pad { radius: 0.05 });
    let settings = PassSettings { controller: Controller::Replay, ..PassSettings::default() };
    for _ in 0..rounds {
        for side in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
            let axis = side.any_orthonormal_vector();
            let sample = |time| PathSample { time, position: DVec3::ZERO, approach: side, axis };
            let path = Path::from_samples(vec![sample(0.0), sample(duration)]).expect("a path");
            run_pass(grid, Pass::first(&tool, &path, &settings, &model), &mut fresh(&model), &mut |_| {})
                .expect("a pass");
        }
    }
    assert_eq!(grid.sanity_check(), Ok(()));
}

fn error(name: &str, grid: &BrickGrid, exact: f64) -> f64 {
    let error = grid.volume() / exact - 1.0;
    println!("{name} at {:.2} mm voxels: volume {:+.3} %", grid.voxel * 1e3, error * 100.0);
    error.abs()
}

#[test]
fn a_ball_shrinks_to_a_ball() {
    let (radius, recession, half) = (0.01, 1.0e-3, DVec3::splat(0.01));
    let mut grid = BrickGrid::from_distance(-half, half, 0.25e-3, 3.0, |p| p.length() - radius);
    recede(&mut grid, recession, 10);
    assert!(error("ball", &grid, 4.0 / 3.0 * PI * (radius - recession).powi(3)) < 2e-3);
}
