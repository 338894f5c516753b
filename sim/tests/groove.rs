//! Grooves that a travelling wheel leaves, against the self-consistent travelling state (Lambert W).

mod common;

use common::forms::{Travelling, number, shared_cases};
use common::{WHEEL, fresh, plate};
use effects::{CompiledModel, Library, Model, Process as Kind, RowCounts};
use glam::{DMat3, DVec3};
use robot::{Controller, Tool, Wheel};
use sdf_bake::BrickGrid;
use sim::height_field::{Facing, HeightField, Window};
use sim::{CurvePoint, Pass, PassRecord, PassSettings, Path, run_pass};

const STIFFNESS: f64 = 1e10;
/// Grind rates [m/(Pa s)] and threshold pressures [Pa].
const LAWS: [(f64, f64); 6] = [(8e-11, 0.0), (4e-10, 0.0), (4e-10, 1e5), (1e-9, 0.0), (2.5e-9, 0.0), (2.5e-9, 1e5)];
/// Offsets of the wheel from a column [voxels]: its rims lie on columns, a quarter beside them, and halfway between.
const BESIDE: [f64; 4] = [0.0, 0.25, 0.5, 0.75];

fn grinding(stiffness: f64, grind_rate: f64, threshold: f64) -> CompiledModel {
    let mut model = Model::new(Kind::Grinding);
    model.set("winkler", "stiffness", &[stiffness]);
    model.set("preston-threshold", "grind_rate", &[grind_rate]);
    model.set("preston-threshold", "threshold_pressure", &[threshold]);
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model")
}

/// A wheel on flat work, and the expected groove and force of the closed form.
struct Groove {
    wheel: Wheel,
    stiffness: f64,
    grind_rate: f64,
    threshold: f64,
    feed: f64,
    voxel: f64,
    /// Offset of the wheel from a column of the lattice [voxels].
    beside: f64,
    /// Angle between feed and lattice [rad].
    turn: f64,
}

impl Groove {
    fn new((grind_rate, threshold): (f64, f64), voxel: f64, beside: f64) -> Self {
        Self { wheel: WHEEL, stiffness: STIFFNESS, grind_rate, threshold, feed: 5e-3, voxel, beside, turn: 0.0 }
    }

    fn form(&self) -> Travelling {
        Travelling {
            radius: self.wheel.radius,
            width: self.wheel.width,
            stiffness: self.stiffness,
            alpha: self.grind_rate * self.stiffness / self.feed,
            threshold: self.threshold / self.stiffness,
        }
    }

    /// Ends of a path of 48 mm at a `depth` [m].
    fn ends(&self, depth: f64) -> [CurvePoint; 2] {
        let turn = DMat3::from_rotation_z(self.turn);
        let at = |x: f64| turn * DVec3::new(x, self.beside * self.voxel, -depth);
        [-0.024, 0.024].map(|x| CurvePoint { position: at(x), normal: DVec3::Z })
    }

    /// One pass at a `depth` [m] of the path, and the mean depth of the groove under mid width where the pass is
    /// steady.
    fn grind(&self, settings: &PassSettings, depth: f64) -> (PassRecord, f64) {
        let mut grid = plate(self.voxel, 0.0);
        let model = grinding(self.stiffness, self.grind_rate, self.threshold);
        let path = Path::along(&self.ends(depth), self.feed).expect("a path");
        let tool = Tool::from(self.wheel);
        let pass = Pass::first(&tool, &path, settings, &model);
        let record = run_pass(&mut grid, pass, &mut fresh(&model), &mut |_| {}).expect("a pass");
        (record, self.groove_depth(&grid))
    }

    fn check_depth(&self, depth: f64) {
        let settings = PassSettings { controller: Controller::Replay, ..PassSettings::default() };
        let (record, found) = self.grind(&settings, depth);
        let (exact, force) = self.form().at_depth(depth);
        let last = record.log[record.log.len() - 2].force;
        self.report(&format!("{:.0} µm deep", depth * 1e6), depth, (found, exact));
        println!("    force {last:.3} N, exact {force:.3} N, {:+.3} %", (last / force - 1.0) * 100.0);
        assert!((last / force - 1.0).abs() < self.most_of_force(), "{last} N");
    }

    fn check_force(&self, force: f64) {
        let settings = PassSettings { force_setpoint: force, ..PassSettings::default() };
        let (_, found) = self.grind(&settings, 0.0);
        self.report(&format!("{force:.1} N"), 40e-6, (found, self.form().at_force(force)));
    }

    fn report(&self, what: &str, depth: f64, (found, exact): (f64, f64)) {
        let error = found / exact - 1.0;
        println!(
            "{what}, αa' about {:.2}, p_c {:.2} MPa, {:.2} mm voxels, {:.2} beside, {:.0}°: groove {:.4} µm, exact {:.4} µm, {:+.3} %",
            self.form().stiff(depth),
            self.threshold * 1e-6,
            self.voxel * 1e3,
            self.beside,
            self.turn.to_degrees(),
            found * 1e6,
            exact * 1e6,
            error * 100.0
        );
        assert!(error.abs() < self.most(), "{what}");
    }

    /// Largest error of the groove's depth [1].
    fn most(&self) -> f64 {
        if self.voxel > 0.3e-3 { 1e-2 } else { 3e-3 }
    }

    /// Largest error of the force [1]: a stiff contact rises above a threshold within a cell.
    fn most_of_force(&self) -> f64 {
        if self.threshold > 0.0 && self.voxel > 0.3e-3 { 2.5e-2 } else { 1e-2 }
    }

    /// Mean depth below z = 0 within 2 mm of mid width over 6 < x < 12 mm along the feed.
    fn groove_depth(&self, grid: &BrickGrid) -> f64 {
        let back = DMat3::from_rotation_z(-self.turn);
        let lines = (12e-3 / grid.voxel) as i32;
        let window = Window { low: [-lines; 2], size: [2 * lines as usize + 1; 2] };
        let height_field = HeightField::read(grid, Facing::of(DVec3::Z), window, 1e-3, -2e-3);
        let under = (0..window.lines()).filter(|&line| {
            let (i, j) = window.place(line);
            let at = back * DVec3::new(f64::from(i), f64::from(j), 0.0) * grid.voxel;
            (6e-3..12e-3).contains(&at.x) && at.y.abs() < 2e-3
        });
        let depths: Vec<f64> = under.map(|line| -height_field.height[line]).collect();
        depths.iter().sum::<f64>() / depths.len() as f64
    }
}

#[test]
fn the_groove_at_a_fixed_depth_is_that_of_the_closed_form() {
    LAWS.iter().for_each(|&law| Groove::new(law, 0.25e-3, 0.0).check_depth(40e-6));
}

#[test]
fn the_groove_at_a_fixed_force_is_that_of_the_closed_form() {
    LAWS.iter().for_each(|&law| Groove::new(law, 0.25e-3, 0.0).check_force(20.0));
}

#[test]
fn half_a_millimetre_is_near_the_closed_form_wherever_the_rims_lie() {
    for law in LAWS {
        for beside in BESIDE {
            Groove::new(law, 0.5e-3, beside).check_depth(40e-6);
            Groove::new(law, 0.5e-3, beside).check_force(20.0);
        }
    }
}

#[test]
fn grooves_of_narrow_strips_above_a_threshold_are_those_of_the_closed_form() {
    let settings = PassSettings { controller: Controller::Replay, ..PassSettings::default() };
    for (voxel, most) in [(0.5e-3, 1e-2), (0.25e-3, 3e-3)] {
        for cells in [3.0, 4.0, 5.0] {
            for stiff in [0.1, 1.0] {
                let (half, threshold) = (0.5 * cells * voxel, 2e5);
                let rate = stiff / half * 5e-3 / STIFFNESS;
                let groove = Groove::new((rate, threshold), voxel, 0.0);
                let depth = threshold / STIFFNESS + half * half / (2.0 * WHEEL.radius);
                let (exact, force) = groove.form().at_depth(depth);
                let (record, found) = groove.grind(&settings, depth);
                let (off, last) = (found / exact - 1.0, record.log[record.log.len() - 2].force);
                let of_force = last / force - 1.0;
                println!(
                    "{cells} squares of {:.2} mm, αa' {stiff}: groove {:+.2} %, force {:+.2} %",
                    voxel * 1e3,
                    off * 100.0,
                    of_force * 100.0
                );
                assert!(off.abs() < most && of_force.abs() < most, "{cells} squares of {voxel} m, αa' {stiff}");
            }
        }
    }
}

#[test]
fn a_feed_askew_to_the_lattice_meets_the_closed_form() {
    for (turn, beside) in [(3.0f64, 0.0), (25.0, 0.5), (45.0, 0.0)] {
        for law in [(4e-10, 1e5), (1e-9, 0.0)] {
            Groove { turn: turn.to_radians(), wheel: Wheel::cylinder(0.05, 0.012), ..Groove::new(law, 0.5e-3, beside) }
                .check_force(12.0);
        }
    }
}

#[test]
fn shared_examples_of_travelling_wheels_hold() {
    for voxel in [0.25e-3, 0.5e-3] {
        check_shared_examples(voxel);
    }
}

fn check_shared_examples(voxel: f64) {
    let of = |inputs: &serde_json::Value| Groove {
        wheel: Wheel::cylinder(number(inputs, "R"), number(inputs, "b")),
        stiffness: number(inputs, "K"),
        feed: number(inputs, "v"),
        ..Groove::new((number(inputs, "k"), number(inputs, "pc")), voxel, 0.0)
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
