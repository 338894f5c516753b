//! Force, moment, maximum pressure and patch of every kind of contact against closed forms: fixed cases here, and the
//! worked examples of the shared folder.
//!
//! Convention T: the depth is the tool's signed distance at the workpiece's surface. For a pad that is the distance to
//! its plane, which for a level pad is also convention V. Where the closed form is parabolic or in V, the case's
//! tolerance exceeds the difference between the conventions.

mod common;

use std::f64::consts::PI;

use common::forms::{number, shared_cases};
use common::fresh;
use effects::{CompiledModel, Library, Model, Process, RowCounts};
use glam::DVec3;
use robot::{Pad, Sphere, Tool, Wheel};
use sdf_bake::BrickGrid;
use serde_json::Value;
use sim::physics::Physics;
use sim::press::Press;
use sim::{Contact, Frame, Pose};

/// A tool pressed into a part, and the expected contact.
struct Case {
    name: String,
    tool: Tool,
    /// Depth of the tool's lowest point at mid width below z = 0 [m].
    depth: f64,
    /// Roll and pitch [rad].
    tilt: (f64, f64),
    /// K [Pa/m].
    stiffness: f64,
    /// [N]
    force: f64,
    /// [Pa]
    peak: f64,
    /// Area of the patch [m²], where it is known.
    area: Option<f64>,
    /// Moment about the lowest point at mid width [N m].
    moment: DVec3,
    /// Width of the patch where it is narrowest [m].
    width: f64,
}

/// A workpiece whose surface passes through the origin.
struct Part {
    /// Half size of the box around the region that the tool can touch [m].
    half: DVec3,
    /// Signed distance, for a `radius` [m].
    distance: fn(DVec3, f64) -> f64,
    radius: f64,
    /// A translation that maps the part onto itself, by no simple fraction of a voxel [m].
    shift: DVec3,
}

fn flat(half: f64) -> Part {
    let shift = DVec3::new(0.031e-3, 0.017e-3, 0.0);
    Part { half: DVec3::new(half, half, 1e-3), distance: |p, _| p.z, radius: 0.0, shift }
}

fn bar_along_x(radius: f64) -> Part {
    let distance = |p: DVec3, r: f64| p.y.hypot(p.z + r) - r;
    Part { half: DVec3::new(0.008, 0.005, 2e-3), distance, radius, shift: DVec3::X * 0.031e-3 }
}

fn bar_along_y(radius: f64, half: f64) -> Part {
    let distance = |p: DVec3, r: f64| p.x.hypot(p.z + r) - r;
    Part { half: DVec3::new(0.005, half, 2e-3), distance, radius, shift: DVec3::Y * 0.017e-3 }
}

fn springs(stiffness: f64) -> CompiledModel {
    let mut model = Model::new(Process::Grinding);
    model.set("winkler", "stiffness", &[stiffness]);
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model")
}

impl Case {
    /// Presses at 0.5 and 0.25 mm voxels and compares the contact with the case.
    fn check(&self, part: &Part) {
        for (voxel, limit) in [(0.5e-3, 5e-3), (0.25e-3, 1e-3)] {
            let grid = BrickGrid::from_distance(-part.half, part.half, voxel, 3.0, |p| (part.distance)(p, part.radius));
            let (found, arm) = self.press(&grid, part.shift);
            let voxels = self.width / voxel;
            let error = found.force / self.force - 1.0;
            let peak = found.pressure_max / self.peak - 1.0;
            let moment = (found.moment + arm.cross(DVec3::Z) * found.force - self.moment).length();
            let lever = moment / (self.force * self.width);
            println!(
                "{}: {:.2} mm voxels, patch of {voxels:.0}: force {:.4} N {:+.4} %, peak {:+.3} %, moment {:+.1e} of F times the patch's width",
                self.name,
                voxel * 1e3,
                found.force,
                error * 100.0,
                peak * 100.0,
                lever
            );
            assert!(error.abs() < if voxels > 8.0 { limit } else { 5e-3 }, "{}", self.name);
            // The deepest column is up to half a voxel from the deepest point.
            let beside = 0.5 * voxel * (self.tilt.0.abs() + self.tilt.1.abs()) * self.stiffness / self.peak;
            assert!(peak.abs() < 2.0 * limit + beside && lever < 2.0 * limit, "{}", self.name);
            if let Some(area) = self.area {
                let error = found.area / area - 1.0;
                println!("    patch {:.4} mm², {:+.3} %", found.area * 1e6, error * 100.0);
                // The parabolic forms of beads are 0.13 % larger than the patch.
                assert!(error.abs() < 2e-3, "{}: {} m², {area} m²", self.name, found.area);
            }
        }
    }

    /// The contact, and the tool's reference point relative to its lowest point [m].
    fn press(&self, grid: &BrickGrid, shift: DVec3) -> (Contact, DVec3) {
        let frame = Frame::about(DVec3::Y, DVec3::Z).tilted(self.tilt.0, self.tilt.1);
        let arm = frame.z * self.tool.drop();
        let pose = Pose { centre: shift - DVec3::Z * self.depth + arm, approach: DVec3::Z, frame };
        let model = springs(self.stiffness);
        let mut states = fresh(&model);
        let mut physics = Physics::new(&model, &mut states, 50e-6);
        let contact = Press::new(grid, &self.tool, pose, 1e-3).contact(0.0, &mut physics).expect("a contact");
        (contact, arm)
    }
}

fn cylinder(wheel: Wheel, (stiffness, depth): (f64, f64), force: f64) -> Case {
    let a = (2.0 * wheel.radius * depth - depth * depth).sqrt();
    Case {
        name: format!("wheel of {:.1} mm, {:.0} µm deep", wheel.radius * 1e3, depth * 1e6),
        tool: wheel.into(),
        depth,
        tilt: (0.0, 0.0),
        stiffness,
        force,
        peak: stiffness * depth,
        area: Some(2.0 * a * wheel.width),
        moment: DVec3::ZERO,
        width: 2.0 * a,
    }
}

/// K b [a R - c² asinh(a/c)] by quadrature: the closed form's terms cancel for d << R.
fn cylinder_force(wheel: Wheel, stiffness: f64, depth: f64) -> f64 {
    let (r, c) = (wheel.radius, wheel.radius - depth);
    let a = (r * r - c * c).sqrt();
    let n = 200_000;
    let mean = (0..n).map(|i| r - c.hypot(a * (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0))).sum::<f64>();
    stiffness * wheel.width * 2.0 * a * mean / f64::from(n)
}

fn tilted_wheel(wheel: Wheel, (stiffness, depth, tilt): (f64, f64, f64), (force, moment): (f64, f64)) -> Case {
    let deepest = depth + 0.5 * wheel.width * tilt.tan();
    Case {
        name: format!("wheel tilted by {:.2} mrad", tilt * 1e3),
        tilt: (tilt, 0.0),
        peak: stiffness * deepest,
        area: None,
        // A right-handed turn about x lifts +y: the deep side, and the load, are at -y.
        moment: DVec3::new(-moment, 0.0, 0.0),
        ..cylinder(wheel, (stiffness, depth), force)
    }
}

fn ball(radius: f64, (stiffness, depth): (f64, f64), force: f64) -> Case {
    let a = (2.0 * radius * depth - depth * depth).sqrt();
    Case {
        name: format!("ball of {:.1} mm, {:.0} µm deep", radius * 1e3, depth * 1e6),
        tool: Tool::from(Sphere { radius }),
        depth,
        tilt: (0.0, 0.0),
        stiffness,
        force,
        peak: stiffness * depth,
        area: Some(PI * a * a),
        moment: DVec3::ZERO,
        width: 2.0 * a,
    }
}

fn pad(radius: f64, (stiffness, depth, tilt): (f64, f64, f64), (force, peak, moment): (f64, f64, f64)) -> Case {
    let dry = (depth / tilt.sin()).min(radius);
    Case {
        name: format!("pad of {:.1} mm tilted by {:.2} mrad", radius * 1e3, tilt * 1e3),
        tool: Pad { radius }.into(),
        depth,
        tilt: (0.0, tilt),
        stiffness,
        force,
        peak,
        area: (tilt == 0.0).then_some(PI * radius * radius),
        // A right-handed turn about y sinks +x.
        moment: DVec3::new(0.0, -moment, 0.0),
        width: if tilt == 0.0 { 2.0 * radius } else { radius + dry },
    }
}

/// Force along z, maximum pressure and moment of a tilted disc, full or partial contact.
fn disc(radius: f64, (stiffness, depth, tilt): (f64, f64, f64)) -> (f64, f64, f64) {
    let (s, sin) = (radius, tilt.sin());
    let peak = stiffness * (depth + s * sin);
    if depth >= s * sin {
        return (stiffness * PI * s * s * depth * tilt.cos(), peak, stiffness * sin * PI * s.powi(4) / 4.0);
    }
    let s0 = -depth / sin;
    let q = (s * s - s0 * s0).sqrt();
    let area = s * s * (s0 / s).acos() - s0 * q;
    let normal = stiffness * sin * (2.0 * q.powi(3) / 3.0 - s0 * area);
    let moment = stiffness
        * sin
        * (s.powi(4) * (s0 / s).acos() / 4.0 + s0 * q * (s * s - 2.0 * s0 * s0) / 4.0 - 2.0 * s0 * q.powi(3) / 3.0);
    (normal * tilt.cos(), peak, moment)
}

const WHEEL: Wheel = Wheel::cylinder(0.04, 0.016);

#[test]
fn wheels_meet_their_closed_forms_level_and_tilted() {
    let (stiffness, depth) = (7e9, 80e-6);
    let force = cylinder_force(WHEEL, stiffness, depth);
    cylinder(WHEEL, (stiffness, depth), force).check(&flat(0.012));
    for tilt in [2e-3f64, 14e-3] {
        let tan = tilt.tan();
        let (high, low) = (depth + 0.008 * tan, (depth - 0.008 * tan).max(0.0));
        let line = stiffness * (2.0 * WHEEL.radius).sqrt() / tan;
        let force = 8.0 / 15.0 * line * (high.powf(2.5) - low.powf(2.5));
        // ∫ (4/3) √(2R) h^1.5 y dy with y = (h - d)/tan.
        let power = |h: f64| 2.0 / 7.0 * h.powf(3.5) - depth * 2.0 / 5.0 * h.powf(2.5);
        let moment = 4.0 / 3.0 * line / tan * (power(high) - power(low));
        tilted_wheel(WHEEL, (stiffness, depth, tilt), (force, moment)).check(&flat(0.012));
    }
}

#[test]
fn a_ball_meets_its_closed_form() {
    let (radius, stiffness, depth) = (0.03, 5e9, 150e-6);
    let force = PI * stiffness * depth * depth * (radius - 2.0 * depth / 3.0);
    ball(radius, (stiffness, depth), force).check(&flat(0.006));
}

#[test]
fn a_pad_meets_its_closed_forms_level_full_and_partial() {
    let (radius, stiffness) = (0.013, 3e9);
    for (depth, tilt) in [(60e-6, 0.0f64), (60e-6, 2e-3), (60e-6, 12e-3), (-40e-6, 9e-3)] {
        pad(radius, (stiffness, depth, tilt), disc(radius, (stiffness, depth, tilt))).check(&flat(0.015));
    }
}

#[test]
fn a_wheel_along_a_bead_meets_its_closed_form() {
    let (stiffness, depth, crown) = (9e9, 120e-6, 0.03);
    let parallel = 1.0 / (1.0 / WHEEL.radius + 1.0 / crown);
    let half = (2.0 * parallel * depth).sqrt();
    let force = 4.0 / 3.0 * stiffness * WHEEL.width * depth * half;
    let case = Case {
        name: "wheel along a bead of 30 mm".to_owned(),
        area: Some(2.0 * half * WHEEL.width),
        width: 2.0 * half,
        ..cylinder(WHEEL, (stiffness, depth), force)
    };
    case.check(&bar_along_y(crown, 0.012));
}

/// K, depth, and a wheel of R and b of a shared case.
fn given(inputs: &Value) -> (f64, f64, Wheel) {
    let width = inputs["b"].as_f64().unwrap_or(0.02);
    (number(inputs, "K"), inputs["d"].as_f64().unwrap_or(0.0), Wheel::cylinder(number(inputs, "R"), width))
}

#[test]
fn shared_examples_of_wheel_and_ball_hold() {
    for (inputs, outputs) in shared_cases("cylinder").iter().filter(|case| case.0["conv"] == "T") {
        let (stiffness, depth, wheel) = given(inputs);
        cylinder(wheel, (stiffness, depth), number(outputs, "force")).check(&flat(0.018));
    }
    for (inputs, outputs) in &shared_cases("cylinder_axis_tilt") {
        let (stiffness, depth, wheel) = given(inputs);
        let moments = (number(outputs, "force"), number(outputs, "moment_about_mid_width"));
        tilted_wheel(wheel, (stiffness, depth, number(inputs, "g")), moments).check(&flat(0.018));
    }
    for (inputs, outputs) in shared_cases("sphere").iter().filter(|case| case.0["conv"] == "T") {
        let (stiffness, depth, wheel) = given(inputs);
        ball(wheel.radius, (stiffness, depth), number(outputs, "force")).check(&flat(0.006));
    }
}

#[test]
fn shared_examples_of_pads_hold() {
    for (inputs, outputs) in shared_cases("disc_flat").iter().filter(|case| case.0["conv"] == "V") {
        let (stiffness, depth) = (number(inputs, "K"), number(inputs, "d"));
        let exact = (number(outputs, "force"), number(outputs, "p_max"), 0.0);
        pad(number(inputs, "rho"), (stiffness, depth, 0.0), exact).check(&flat(0.052));
    }
    for (inputs, outputs) in &shared_cases("disc_tilted") {
        let tilted = (number(inputs, "K"), number(inputs, "h"), number(inputs, "th"));
        let exact = (number(outputs, "force_z"), number(outputs, "p_max"), number(outputs, "moment_tilt_axis"));
        pad(number(inputs, "rho"), tilted, exact).check(&flat(0.052));
    }
}

#[test]
fn shared_examples_of_beads_hold() {
    for kind in ["crossed_exact_circle", "crossed_parabolic"] {
        for (inputs, outputs) in &shared_cases(kind) {
            let (stiffness, depth, wheel) = given(inputs);
            let crown = number(inputs, "Rb");
            let semi = |r: f64| (2.0 * r * depth).sqrt();
            let case = Case {
                name: format!("wheel across a bead, {kind}"),
                area: Some(PI * semi(wheel.radius) * semi(crown)),
                width: 2.0 * semi(crown),
                ..cylinder(wheel, (stiffness, depth), number(outputs, "force"))
            };
            case.check(&bar_along_x(crown));
        }
    }
    for (inputs, outputs) in &shared_cases("bead_parallel") {
        let (stiffness, depth, wheel) = given(inputs);
        let half = number(outputs, "patch_half_width");
        let case = Case {
            name: "wheel along a bead".to_owned(),
            area: Some(2.0 * half * wheel.width),
            width: 2.0 * half,
            ..cylinder(wheel, (stiffness, depth), number(outputs, "force"))
        };
        case.check(&bar_along_y(number(inputs, "Rb"), 0.018));
    }
}
