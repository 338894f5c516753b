//! Tool access: can a wheel or a pad get at the weld?

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;
use sdf_bake::query::MeshQuery;
use serde::Serialize;

use crate::curve::{CurvePoint, WeldCurve};

/// What touches the weld with which side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToolKind {
    /// A wheel: its rim touches, its axis lies along the surface.
    Wheel,
    /// A pad: its face touches with the rim, its axis stands on the surface.
    Pad,
}

/// A round tool, as far as collisions go.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ToolShape {
    /// Which side touches.
    pub kind: ToolKind,
    /// Radius of the cylinder [m].
    pub radius: f64,
    /// Its width along the axis [m].
    pub width: f64,
}

impl Default for ToolShape {
    /// The wheel that `robofin simulate` grinds with.
    fn default() -> Self {
        Self { kind: ToolKind::Wheel, radius: 0.050, width: 0.010 }
    }
}

/// Turns of the tool about the normal, evenly over half a turn for a wheel and a whole turn for a pad.
const TURNS: u32 = 6;
/// Tilts of the wheel's plane to the sides [rad].
const WHEEL_TILTS: [f64; 3] = [-0.25, 0.0, 0.25];
/// Tilts of the pad [rad].
const PAD_TILTS: [f64; 3] = [0.05, 0.15, 0.3];
/// Lines of the tool's surface that are held against the part, around the rim and on each face.
const LINES: u32 = 16;
/// Distance between stations, in bead widths.
const STATION_WIDTHS: f64 = 0.5;

/// The tool in one pose.
struct Pose {
    /// Centre of one face [m].
    centre: DVec3,
    /// Unit vector along the axis, to the other face.
    axis: DVec3,
}

/// Share of poses in which the tool, touching the crown of the bead, is clear of the part, in [0, 1], for each point.
///
/// Measured at stations half a bead width apart and interpolated between them. A tool collides when one of the lines
/// along its rim or across its faces meets the part: what is smaller than a sixteenth of the rim may slip through.
pub fn access(query: &MeshQuery, curve: &WeldCurve, tool: ToolShape, [width, height]: [f64; 2]) -> Vec<f64> {
    let last = curve.points.len().saturating_sub(1);
    if last == 0 {
        return vec![0.0; curve.points.len()];
    }
    let count = (curve.length() / (STATION_WIDTHS * width)).ceil().clamp(1.0, last as f64) as usize;
    let place = |station: usize| station * last / count;
    let stations: Vec<f64> =
        (0..=count).into_par_iter().map(|i| at_point(query, &curve.points[place(i)], tool, height)).collect();
    let mut shares = vec![stations[count]; curve.points.len()];
    for (i, pair) in stations.windows(2).enumerate() {
        let (from, to) = (place(i), place(i + 1));
        for (point, share) in shares[from..to].iter_mut().enumerate() {
            *share = pair[0] + (pair[1] - pair[0]) * point as f64 / (to - from) as f64;
        }
    }
    shares
}

fn at_point(query: &MeshQuery, point: &CurvePoint, tool: ToolShape, height: f64) -> f64 {
    let poses = poses(point, tool, height);
    let free = poses.iter().filter(|pose| is_free(query, pose, tool)).count();
    free as f64 / poses.len() as f64
}

/// All poses in which the tool touches the crown above a point.
fn poses(point: &CurvePoint, tool: ToolShape, height: f64) -> Vec<Pose> {
    let contact = point.position + height * point.normal;
    let (normal, radius, width) = (point.normal, tool.radius, tool.width);
    let pose = |turn: u32, tilt: f64| match tool.kind {
        ToolKind::Wheel => {
            let (sin, cos) = (0.5 * TAU * f64::from(turn) / f64::from(TURNS)).sin_cos();
            let flat = cos * point.side + sin * point.tangent;
            let (axis, up) = (tilt.cos() * flat + tilt.sin() * normal, tilt.cos() * normal - tilt.sin() * flat);
            // A tilted wheel touches with the lower edge of its rim.
            let share = if tilt == 0.0 {
                0.5
            } else if tilt > 0.0 {
                0.0
            } else {
                1.0
            };
            Pose { centre: contact + radius * up - share * width * axis, axis }
        }
        ToolKind::Pad => {
            let (sin, cos) = (TAU * f64::from(turn) / f64::from(TURNS)).sin_cos();
            let lean = cos * point.tangent + sin * point.side;
            let axis = tilt.cos() * normal + tilt.sin() * lean;
            Pose { centre: contact - radius * (tilt.cos() * lean - tilt.sin() * normal), axis }
        }
    };
    let tilts = if tool.kind == ToolKind::Wheel { WHEEL_TILTS } else { PAD_TILTS };
    (0..TURNS).flat_map(|turn| tilts.map(|tilt| pose(turn, tilt))).collect()
}

fn is_free(query: &MeshQuery, pose: &Pose, tool: ToolShape) -> bool {
    let (x, y) = pose.axis.any_orthonormal_pair();
    let lines = (0..LINES).map(|i| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(LINES)).sin_cos();
        cos * x + sin * y
    });
    let mut met = lines.flat_map(|out| {
        let other_face = pose.centre + tool.width * pose.axis;
        [
            query.occluded(pose.centre + tool.radius * out, pose.axis, tool.width),
            query.occluded(pose.centre, out, tool.radius),
            query.occluded(other_face, out, tool.radius),
        ]
    });
    !met.any(|met| met)
}
