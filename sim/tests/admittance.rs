//! Admittance controllers on a pad that presses on flat work, against their closed forms.
//!
//! The closed forms depend on the pad only through K A and k/A. The shared examples have a pad with a radius of a few
//! voxels; here its area is thirty times larger, with K, k and p_c to match, so that force and travel stay the same.

mod common;

use std::f64::consts::PI;

use common::forms::{number, shared_cases};
use common::{base, block, fresh, line, plate};
use effects::{CompiledModel, Library, Model, Process as Kind, RowCounts};
use glam::DVec3;
use robot::{Controller, Pad, Tool, Wheel};
use sdf_bake::BrickGrid;
use sim::{Pass, PassRecord, PassSettings, Path, PathSample, run_pass};

/// A pad on flat work; SI units.
#[derive(Clone, Copy)]
struct Plunge {
    stiffness: f64,
    area: f64,
    mass: f64,
    damping: f64,
    setpoint: f64,
    grind_rate: f64,
    threshold: f64,
}

impl Plunge {
    /// The same forces and travels with a pad of another area.
    fn with_area(self, area: f64) -> Self {
        let times = area / self.area;
        Self {
            stiffness: self.stiffness / times,
            area,
            grind_rate: self.grind_rate * times,
            threshold: self.threshold / times,
            ..self
        }
    }

    fn model(&self) -> CompiledModel {
        let mut model = Model::new(Kind::Grinding);
        model.set("winkler", "stiffness", &[self.stiffness]);
        model.set("preston-threshold", "grind_rate", &[self.grind_rate.max(1e-30)]);
        model.set("preston-threshold", "threshold_pressure", &[self.threshold]);
        CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model")
    }

    /// Forces [N] over time [s] while the pad stays in place for `duration` [s], and the final recession of the surface
    /// [m].
    fn run(&self, duration: f64, period: f64, quasi_static: bool) -> (Vec<(f64, f64)>, f64) {
        self.run_on((plate(0.5e-3, 0.0), (self.area / PI).sqrt()), duration, (period, quasi_static))
    }

    /// The same for a pad of a radius [m] on a part of which it touches the area A.
    fn run_on(
        &self,
        (mut grid, radius): (BrickGrid, f64),
        duration: f64,
        (period, quasi_static): (f64, bool),
    ) -> (Vec<(f64, f64)>, f64) {
        let tool = Tool::from(Pad { radius });
        let sample = |time| PathSample { time, position: DVec3::ZERO, approach: DVec3::Z, axis: DVec3::Y };
        let path = Path::from_samples(vec![sample(0.0), sample(duration)]).expect("a path");
        let controller = Controller::Admittance { mass: self.mass, damping: self.damping, period };
        let settings =
            PassSettings { controller, force_setpoint: self.setpoint, quasi_static, ..PassSettings::default() };
        let model = self.model();
        let mut forces = Vec::new();
        let pass = Pass::first(&tool, &path, &settings, &model);
        let record = run_pass(&mut grid, pass, &mut fresh(&model), &mut |now| forces.push((now.time, now.force)));
        (forces, record.expect("a pass").removed_volume / self.area)
    }

    /// Force [N] at the end of a run at the controller's period, and the recession of the surface [m].
    fn end(&self, duration: f64, period: f64) -> (f64, f64) {
        let (forces, receded) = self.run(duration, period, false);
        (last(&forces), receded)
    }

    fn tau(&self) -> f64 {
        self.damping / (self.stiffness * self.area)
    }

    fn steady(&self) -> f64 {
        let recession = self.grind_rate / self.area;
        (self.setpoint / self.damping + self.grind_rate * self.threshold) / (1.0 / self.damping + recession)
    }

    /// Force [N] at a time after the touch, for M = 0, and the recession of the surface then [m].
    fn exact(&self, time: f64) -> (f64, f64) {
        let touch = self.threshold * self.area;
        let grinds =
            if self.grind_rate > 0.0 { -self.tau() * (1.0 - touch / self.setpoint).ln() } else { f64::INFINITY };
        if time <= grinds {
            return (self.setpoint * (1.0 - (-time / self.tau()).exp()), 0.0);
        }
        let rate = 1.0 / self.tau() + self.stiffness * self.grind_rate;
        let (since, below) = (time - grinds, touch - self.steady());
        let swing = below * (1.0 - (-rate * since).exp()) / rate;
        let receded = self.grind_rate / self.area * (swing - below * since);
        (self.steady() + below * (-rate * since).exp(), receded)
    }
}

const PAD: Plunge =
    Plunge { stiffness: 1e9, area: 4e-4, mass: 0.0, damping: 800.0, setpoint: 20.0, grind_rate: 0.0, threshold: 0.0 };

fn last(forces: &[(f64, f64)]) -> f64 {
    forces.last().expect("steps").1
}

#[test]
fn without_mass_the_force_rises_as_one_minus_exp() {
    for share in [0.3, 1.0, 2.5] {
        let time = share * PAD.tau();
        let ((found, _), (exact, _)) = (PAD.end(time, PAD.tau() / 500.0), PAD.exact(time));
        println!("rise at {share} tau: {found:.4} N, exact {exact:.4} N");
        assert!((found / exact - 1.0).abs() < 3e-3);
    }
}

#[test]
fn with_mass_the_overshoot_is_that_of_the_damping_ratio() {
    for zeta in [0.2f64, 0.5] {
        let spring = PAD.stiffness * PAD.area;
        let mass = (PAD.damping / (2.0 * zeta)).powi(2) / spring;
        let pad = Plunge { mass, ..PAD };
        let period = 2.0 * PI * (mass / spring).sqrt();
        let (forces, _) = pad.run(3.0 * period, period / 1000.0, false);
        let peak = forces.iter().map(|row| row.1).fold(0.0, f64::max);
        let (found, exact) = (peak / pad.setpoint - 1.0, (-PI * zeta / (1.0 - zeta * zeta).sqrt()).exp());
        println!("overshoot at zeta {zeta}: {found:.4}, exact {exact:.4}; at the end {:.4} N", last(&forces));
        assert!((found - exact).abs() < 5e-3);
        let (rest, _) = pad.end(20.0 * period, period / 200.0);
        assert!((rest / pad.setpoint - 1.0).abs() < 1e-3, "at rest the force is the setpoint: {rest}");
    }
}

#[test]
fn a_plunging_pad_falls_short_of_its_setpoint_by_damping_times_recession() {
    for threshold in [0.0, 1e4] {
        let pad = Plunge { grind_rate: 0.1 * PAD.area / PAD.damping, threshold, ..PAD };
        let time = 6.0 * pad.tau();
        let ((found, receded), (exact, depth)) = (pad.end(time, pad.tau() / 200.0), pad.exact(time));
        println!(
            "plunge, p_c {threshold:.0} Pa: {found:.4} N, exact {exact:.4} N, steady {:.4} N; {:.3} µm deep, exact {:.3} µm",
            pad.steady(),
            receded * 1e6,
            depth * 1e6
        );
        assert!(pad.steady() < 0.95 * pad.setpoint);
        assert!((found / exact - 1.0).abs() < 3e-3);
        assert!((found / pad.steady() - 1.0).abs() < 5e-3);
        assert!((receded / depth - 1.0).abs() < 5e-3);
    }
}

/// Half side of a block that a wider pad covers entirely [m]: a column of 0.5 mm voxels does not lie on its sides.
const BLOCK: f64 = 0.01225;

#[test]
fn without_mass_long_steps_come_to_rest_as_the_closed_forms_do() {
    let area = 4.0 * BLOCK * BLOCK;
    for (grind_rate, threshold) in [(0.0, 0.0), (0.1 * PAD.area / PAD.damping, 1e4)] {
        let pad = Plunge { grind_rate, threshold, ..PAD }.with_area(area);
        let (duration, period) = (30.0 * pad.tau(), pad.tau() / 200.0);
        // The closed forms ignore the side face that stays beside a pad on wider work: here all of the work is under
        // the pad.
        let pressed = (block(0.5e-3, BLOCK), 2.0 * BLOCK);
        let ((forces, receded), (exact, depth)) = (pad.run_on(pressed, duration, (period, true)), pad.exact(duration));
        let (steps, found) = (forces.len(), last(&forces));
        println!(
            "{steps} long steps: {found:.4} N, exact {exact:.4} N; {:.3} µm deep, exact {:.3} µm",
            receded * 1e6,
            depth * 1e6
        );
        assert!(steps < 600, "{steps} steps, 6000 at the period");
        assert!((found / exact - 1.0).abs() < 2e-3);
        assert!((receded - depth).abs() <= 2e-3 * depth + 1e-15);
    }
}

#[test]
fn a_mass_below_zero_is_refused_by_name() {
    let tool = Tool::from(Pad { radius: 0.01 });
    for mass in [-1.0, f64::NAN, f64::INFINITY] {
        let controller = Controller::Admittance { mass, damping: 1500.0, period: 1e-3 };
        let error =
            PassSettings { controller, ..PassSettings::default() }.check(&plate(0.5e-3, 0.0), &tool).unwrap_err();
        assert!(error.to_string().contains("admittance mass [kg]"), "{error}");
        assert!(error.to_string().contains("zero, or positive and finite"), "{error}");
    }
}

#[test]
fn shared_examples_of_admittance_hold() {
    let of = |inputs: &serde_json::Value| {
        let optional = |name: &str| inputs[name].as_f64();
        let area = number(inputs, "A");
        let pad = Plunge {
            stiffness: number(inputs, "K"),
            area,
            mass: optional("M").unwrap_or(0.0),
            damping: number(inputs, "B"),
            setpoint: number(inputs, "Fd"),
            grind_rate: optional("k").unwrap_or(0.0),
            threshold: optional("pc").unwrap_or(0.0),
        };
        pad.with_area(30.0 * area)
    };
    for (kind, limit) in [("adm_first_order", 3e-3), ("adm_second_order", 3e-3), ("adm_plunge", 1e-2)] {
        for (inputs, outputs) in &shared_cases(kind) {
            let (pad, time) = (of(inputs), number(inputs, "t"));
            let ((found, receded), exact) = (pad.end(time, time / 1500.0), number(outputs, "force"));
            println!("{kind}: {found:.4} N, exact {exact:.4} N, {:+.3} %", (found / exact - 1.0) * 100.0);
            assert!((found / exact - 1.0).abs() < limit, "{kind}");
            if kind == "adm_plunge" {
                let off = receded / number(outputs, "removed") - 1.0;
                println!("{kind}: {:.4} µm deep, {:+.3} %", receded * 1e6, off * 100.0);
                assert!(off.abs() < limit, "{kind}: {receded} m");
                assert!((pad.steady() / number(outputs, "force_steady") - 1.0).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn long_steps_take_off_what_steps_at_the_controllers_period_do() {
    let run = |quasi_static: bool| -> (PassRecord, f64) {
        let (tool, model) = (Tool::from(Wheel::cylinder(0.05, 0.02)), base());
        let path = Path::along(&line(-0.006, 0.006, 0.0), 5e-3).expect("a path");
        let controller = Controller::Admittance { mass: 2.0, damping: 1500.0, period: 1e-3 };
        let settings = PassSettings { controller, quasi_static, ..PassSettings::default() };
        let mut grid = plate(0.5e-3, 0.0);
        let before = grid.volume();
        let pass = Pass::first(&tool, &path, &settings, &model);
        let record = run_pass(&mut grid, pass, &mut fresh(&model), &mut |_| {}).expect("a pass");
        (record, before - grid.volume())
    };
    let ((long, lost_long), (short, lost_short)) = (run(true), run(false));
    println!(
        "quasi-static: {} steps, {:.4} mm³; at the period: {} steps, {:.4} mm³",
        long.steps,
        lost_long * 1e9,
        short.steps,
        lost_short * 1e9
    );
    assert!(short.steps >= 2400 && long.steps < short.steps / 5);
    assert!((lost_long / lost_short - 1.0).abs() < 5e-3);
    assert!((long.impulse / short.impulse - 1.0).abs() < 5e-3);
}
