//! Grooves that a travelling wheel leaves, against the self-consistent travelling state (Lambert W).

mod common;

use common::forms::{Travelling, number, shared_cases};
use common::{fresh, line, plate};
use glam::DVec3;
use sdf_bake::BrickGrid;
use sim::effect::{CompiledModel, Library, Model, Process as Kind, RowCounts};
use sim::sheet::{Facing, Sheet, Window};
use sim::{Controller, Pass, PassRecord, Path, Process, Tool, Wheel, run_pass};

/// Its rims lie halfway between columns. See the limits in docs/grinding.md for rims on a column.
const WHEEL: Wheel = Wheel::cylinder(0.05, 0.02025);
const STIFFNESS: f64 = 1e10;

fn grinding(stiffness: f64, grind_rate: f64, threshold: f64) -> CompiledModel {
    let mut model = Model::new(Kind::Grinding);
    model.set("winkler", "stiffness", &[stiffness]);
    model.set("preston-threshold", "grind_rate", &[grind_rate]);
    model.set("preston-threshold", "threshold_pressure", &[threshold]);
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model")
}

/// What a wheel does to flat work, and what the closed form says.
struct Groove {
    wheel: Wheel,
    stiffness: f64,
    grind_rate: f64,
    threshold: f64,
    feed: f64,
    voxel: f64,
}

impl Groove {
    fn form(&self) -> Travelling {
        Travelling {
            radius: self.wheel.radius,
            width: self.wheel.width,
            stiffness: self.stiffness,
            alpha: self.grind_rate * self.stiffness / self.feed,
            threshold: self.threshold / self.stiffness,
        }
    }

    /// One pass of 48 mm at a `depth` [m] of the path, and the mean depth of the groove under mid width where the pass
    /// is steady.
    fn grind(&self, process: &Process, depth: f64) -> (PassRecord, f64) {
        let mut grid = plate(self.voxel, 0.0);
        let model = grinding(self.stiffness, self.grind_rate, self.threshold);
        let path = Path::along(&line(-0.024, 0.024, -depth), self.feed).expect("a path");
        let tool = Tool::from(self.wheel);
        let pass = Pass::first(&tool, &path, process, &model);
        let record = run_pass(&mut grid, pass, &mut fresh(&model), &mut |_| {}).expect("a pass");
        (record, groove_depth(&grid))
    }

    fn check_depth(&self, depth: f64) {
        let process = Process { controller: Controller::Replay, ..Process::default() };
        let (record, found) = self.grind(&process, depth);
        let (exact, force) = self.form().at_depth(depth);
        let last = record.log[record.log.len() - 2].force;
        self.report(&format!("{:.0} µm deep", depth * 1e6), depth, (found, exact));
        println!("    force {last:.3} N, exact {force:.3} N, {:+.3} %", (last / force - 1.0) * 100.0);
        assert!((last / force - 1.0).abs() < 1e-2, "{last} N");
    }

    fn check_force(&self, force: f64) {
        let process = Process { force_setpoint: force, ..Process::default() };
        let (_, found) = self.grind(&process, 0.0);
        self.report(&format!("{force:.1} N"), 40e-6, (found, self.form().at_force(force)));
    }

    fn report(&self, what: &str, depth: f64, (found, exact): (f64, f64)) {
        let error = found / exact - 1.0;
        println!(
            "{what}, αa' about {:.2}, p_c {:.2} MPa, {:.2} mm voxels: groove {:.4} µm, exact {:.4} µm, {:+.3} %",
            self.form().stiff(depth),
            self.threshold * 1e-6,
            self.voxel * 1e3,
            found * 1e6,
            exact * 1e6,
            error * 100.0
        );
        assert!(error.abs() < 1e-2, "{what}");
    }
}

/// Mean depth below z = 0 at y = 0 over 6 < x < 12 mm.
fn groove_depth(grid: &BrickGrid) -> f64 {
    let lines = (6e-3 / grid.voxel) as usize;
    let window = Window { low: [(6e-3 / grid.voxel) as i32, -1], size: [lines, 3] };
    let sheet = Sheet::read(grid, Facing::of(DVec3::Z), window, 1e-3, -2e-3);
    -(0..lines).map(|row| sheet.height[3 * row + 1]).sum::<f64>() / lines as f64
}

#[test]
fn the_groove_at_a_fixed_depth_is_that_of_the_closed_form() {
    for (grind_rate, threshold) in [(8e-11, 0.0), (4e-10, 0.0), (4e-10, 1e5), (2.5e-9, 0.0), (2.5e-9, 1e5)] {
        let groove = Groove { wheel: WHEEL, stiffness: STIFFNESS, grind_rate, threshold, feed: 5e-3, voxel: 0.25e-3 };
        groove.check_depth(40e-6);
    }
}

#[test]
fn the_groove_at_a_fixed_force_is_that_of_the_closed_form() {
    for (grind_rate, threshold) in [(8e-11, 0.0), (4e-10, 1e5), (1e-9, 0.0), (2.5e-9, 1e5)] {
        let groove = Groove { wheel: WHEEL, stiffness: STIFFNESS, grind_rate, threshold, feed: 5e-3, voxel: 0.25e-3 };
        groove.check_force(20.0);
    }
}

#[test]
fn shared_examples_of_travelling_wheels_hold() {
    let of = |inputs: &serde_json::Value| Groove {
        wheel: Wheel::cylinder(number(inputs, "R"), number(inputs, "b")),
        stiffness: number(inputs, "K"),
        grind_rate: number(inputs, "k"),
        threshold: number(inputs, "pc"),
        feed: number(inputs, "v"),
        voxel: 0.25e-3,
    };
    for (inputs, outputs) in &shared_cases("pass_steady") {
        let (exact, force) = of(inputs).form().at_depth(number(inputs, "d"));
        assert!((exact / number(outputs, "depth") - 1.0).abs() < 1e-6);
        assert!((force / number(outputs, "force") - 1.0).abs() < 1e-6);
        of(inputs).check_depth(number(inputs, "d"));
    }
    for (inputs, outputs) in &shared_cases("pass_force_controlled") {
        let exact = of(inputs).form().at_force(number(inputs, "F"));
        assert!((exact / number(outputs, "depth") - 1.0).abs() < 1e-6);
        of(inputs).check_force(number(inputs, "F"));
    }
}
