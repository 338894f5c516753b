//! Tool access: share of tool poses in which a wheel or a pad reaches the weld without collision.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;
use sdf_bake::query::MeshQuery;
use serde::Serialize;

use crate::curve::{CurvePoint, WeldCurve};

/// Kind of tool, with the side that touches the weld.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToolKind {
    /// A wheel: its rim touches, and its axis is parallel to the surface.
    Wheel,
    /// A pad: the rim of its face touches, and its axis is nearly normal to the surface.
    Pad,
}

/// A round tool, as used in collision checks.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ToolShape {
    /// Kind of tool.
    pub kind: ToolKind,
    /// Radius of the cylinder [m].
    pub radius: f64,
    /// Width along the axis [m].
    pub width: f64,
}

impl Default for ToolShape {
    /// The default wheel of `robofin simulate`.
    fn default() -> Self {
        Self { kind: ToolKind::Wheel, radius: 0.050, width: 0.010 }
    }
}

/// Rotations of the tool about the normal, evenly over half a turn for a wheel and a full turn for a pad.
const TURNS: u32 = 6;
/// Sideways tilts of the wheel's plane [rad].
const WHEEL_TILTS: [f64; 3] = [-0.25, 0.0, 0.25];
/// Tilts of the pad [rad].
const PAD_TILTS: [f64; 3] = [0.05, 0.15, 0.3];
/// Number of lines on the tool's surface that are tested against the part, around the rim and on each face.
const LINES: u32 = 16;
/// Distance between stations, in bead widths.
const STATION_WIDTHS: f64 = 0.5;

/// Pose of the tool.
struct Pose {
    /// Centre of one face [m].
    centre: DVec3,
    /// Unit vector along the axis, towards the other face.
    axis: DVec3,
}

/// Share of poses without collision when the tool touches the crown of the bead, in [0, 1], for each point.
///
/// Measured at stations half a bead width apart and interpolated between them. A tool collides if one of the lines
/// along its rim or across its faces meets the part. Obstacles smaller than a sixteenth of the rim may be missed.
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

/// Returns all poses in which the tool touches the crown above a point.
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
