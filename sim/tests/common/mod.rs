//! Parts with known surfaces.
#![allow(dead_code, reason = "each test file uses its own share of the parts")]

pub(crate) mod forms;

use effects::{CompiledModel, Library, Model, RowCounts, States};
use glam::{DMat3, DVec3};
use robot::Wheel;
use sdf_bake::BrickGrid;
use sim::{CurvePoint, Frame, Pose};

pub(crate) const WHEEL: Wheel = Wheel::cylinder(0.05, 0.02);

/// K of the tests [Pa/m].
pub(crate) const STIFFNESS: f64 = 1e10;
/// k of the tests [m/(Pa s)].
pub(crate) const GRIND_RATE: f64 = 1e-9;

/// A model from the text of a model file.
pub(crate) fn model(text: &str) -> CompiledModel {
    let model = Model::parse_beyond_ranges("model.toml", text, Library::builtin()).expect("a model");
    CompiledModel::new(&model, Library::builtin(), RowCounts::default()).expect("a model that compiles")
}

/// The base law of grinding without a threshold.
pub(crate) fn base() -> CompiledModel {
    threshold(0.0)
}

/// The base law of grinding with a threshold pressure [Pa].
pub(crate) fn threshold(pressure: f64) -> CompiledModel {
    with_effect(pressure, "")
}

/// The same with the effects of a text.
pub(crate) fn with_effect(pressure: f64, effect: &str) -> CompiledModel {
    model(&format!(
        "process = \"grinding\"\n[law.winkler]\nstiffness = \"{STIFFNESS:e} Pa/m\"\n\
         [law.preston-threshold]\ngrind_rate = \"{GRIND_RATE:e} m/(Pa s)\"\nthreshold_pressure = \"{pressure:e} Pa\"\n{effect}"
    ))
}

/// A fresh tool.
pub(crate) fn fresh(model: &CompiledModel) -> States {
    States::new(model, sim::TOOL_CELLS)
}

/// A plate with its top at z = `top`, 60 x 40 mm or so.
pub(crate) fn plate(voxel: f64, top: f64) -> BrickGrid {
    let half = DVec3::new(0.03, 0.02, 0.004);
    BrickGrid::from_distance(-half, half, voxel, 3.0, move |p| {
        let q = p.abs() - DVec3::new(0.03, 0.02, 0.0);
        box_distance(DVec3::new(q.x, q.y, (p.z - top).max(-0.004 - p.z)))
    })
}

/// A block with its top at z = 0, a square of `half` sides.
pub(crate) fn block(voxel: f64, half: f64) -> BrickGrid {
    let corner = DVec3::new(half, half, 0.004);
    BrickGrid::from_distance(-corner, corner, voxel, 3.0, move |p| {
        let q = p.abs() - corner;
        box_distance(DVec3::new(q.x, q.y, p.z.max(-0.004 - p.z)))
    })
}

/// Distance of a box from the signed distances to its three pairs of sides.
pub(crate) fn box_distance(q: DVec3) -> f64 {
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

/// A ball of `radius` centred at `centre`.
pub(crate) fn ball(voxel: f64, radius: f64, centre: DVec3) -> BrickGrid {
    let half = DVec3::splat(radius);
    BrickGrid::from_distance(centre - half, centre + half, voxel, 3.0, move |p| (p - centre).length() - radius)
}

/// A bar along x whose crown is a circle of `radius`, highest at z = 0.
pub(crate) fn bar(voxel: f64, radius: f64, half_length: f64) -> BrickGrid {
    let half = DVec3::new(half_length, radius, radius);
    let centre = DVec3::Z * -radius;
    BrickGrid::from_distance(centre - half, centre + half, voxel, 3.0, move |p| {
        let across = p.y.hypot(p.z + radius) - radius;
        let along = p.x.abs() - half_length;
        across.max(0.0).hypot(along.max(0.0)) + across.max(along).min(0.0)
    })
}

/// Distance to the parabola z = h (1 - (y/w)²) [m], signed, by Newton's steps on the foot point.
pub(crate) fn parabola_distance(y: f64, z: f64, w: f64, h: f64) -> f64 {
    let y = y.abs();
    let mut foot = y.min(2.0 * w);
    for _ in 0..40 {
        let rise = h * (1.0 - foot * foot / (w * w)) - z;
        let slope = -2.0 * h * foot / (w * w);
        let f = foot - y + rise * slope;
        let df = 1.0 + slope * slope - 2.0 * h / (w * w) * rise;
        foot = (foot - f / df.max(0.3)).max(0.0);
    }
    let top = h * (1.0 - foot * foot / (w * w));
    (foot - y).hypot(top - z).copysign(z - h * (1.0 - y * y / (w * w)))
}

/// A plate 120 x 60 x 10 mm with its top at z = 0 and a weld bead 10 mm wide, 3 mm high, 80 mm long on it.
pub(crate) fn welded_plate(voxel: f64, scale: f64) -> BrickGrid {
    let (half_length, half) = (0.06 * scale, DVec3::new(0.06 * scale, 0.03, 0.005));
    let high = DVec3::new(half.x, half.y, 0.003);
    BrickGrid::from_distance(DVec3::new(-half.x, -half.y, -0.01), high, voxel, 3.0, move |p| {
        let plate = box_distance((p + DVec3::Z * 0.005).abs() - half);
        let cross = parabola_distance(p.y, p.z, 0.005, 0.003);
        let end = p.x.abs() - half_length * 2.0 / 3.0;
        let bead = cross.max(end).min(0.0) + cross.max(0.0).hypot(end.max(0.0));
        plate.min(bead)
    })
}

/// Straight curve along x at z = `height`.
pub(crate) fn line(from: f64, to: f64, height: f64) -> [CurvePoint; 2] {
    [from, to].map(|x| CurvePoint { position: DVec3::new(x, 0.0, height), normal: DVec3::Z })
}

/// A wheel whose lowest point is `depth` below z = 0 at (x, y).
pub(crate) fn pressed(wheel: &Wheel, x: f64, y: f64, depth: f64) -> Pose {
    Pose { centre: DVec3::new(x, y, wheel.radius - depth), approach: DVec3::Z, frame: Frame::about(DVec3::Y, DVec3::Z) }
}

/// A pose turned about the origin.
pub(crate) fn turned(pose: &Pose, turn: DMat3) -> Pose {
    let frame = Frame { x: turn * pose.frame.x, y: turn * pose.frame.y, z: turn * pose.frame.z };
    Pose { centre: turn * pose.centre, approach: turn * pose.approach, frame }
}

/// A rotation that shares no axis with the lattice.
pub(crate) fn odd_turn() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(0.3, -0.5, 0.8).normalize(), 0.7)
}
