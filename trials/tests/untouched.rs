//! Untouched pixels, found for many poses at once, are those that a search pose by pose finds.

use glam::{DVec2, DVec3};
use robot::{Tool, Wheel};
use sdf_bake::{HeightMap, PixelGrid};
use trials::measure::{CLEARANCE, untouched};
use trials::trial::{HeldTool, ToolPath, ToolPose};

/// A path of 100 poses, 0.2 mm apart or more, over a map of 30 x 20 mm; from pose `turns` on, the tool leans ever more.
fn path(turns: usize, height: f64) -> ToolPath {
    let pose = |k: usize| {
        let way = k as f64 / 100.0;
        let lean = 2e-3 * k.saturating_sub(turns) as f64;
        let (sin, cos) = lean.sin_cos();
        ToolPose {
            time: way,
            centre: DVec3::new(5e-3 + 0.02 * way, 4e-3 * (6.0 * way).sin(), height),
            approach: DVec3::new(0.0, -sin, cos),
            axis: DVec3::new(0.0, cos, sin),
            force: 15.0,
            spindle_speed: 600.0,
        }
    };
    ToolPath { poses: (0..100).map(pose).collect(), contact: None, feed: 5e-3, jumps: Vec::new() }
}

/// True if a point is farther than the clearance from the tool's working face in a pose, or beside it.
fn is_clear(tool: &HeldTool, pose: &ToolPose, point: DVec3, pixel: f64) -> bool {
    let from = point - pose.centre;
    match &tool.shape {
        Tool::Wheel(Wheel { radius, width, .. }) => {
            let along = from.dot(pose.axis);
            (from - along * pose.axis).length() - radius > CLEARANCE || along.abs() > 0.5 * width + pixel
        }
        disc => {
            let height = from.dot(pose.approach);
            (from - height * pose.approach).length() > disc.rim_radius() + pixel || -height > CLEARANCE
        }
    }
}

#[test]
fn pixels_are_untouched_where_every_single_pose_is_clear_of_them() {
    let pixels = PixelGrid { origin: DVec2::new(0.0, -0.01), pitch: 0.25e-3, nx: 120, ny: 80 };
    let mut surface = HeightMap::from_function(pixels, |p| 1e-3 * (1.0 - (p.y / 6e-3).powi(2)).max(0.0));
    surface.heights[17] = f64::NAN;
    let wheel = (HeldTool::wheel(0.02, 0.005, DVec3::Y), 0.0209);
    let pad = (HeldTool::pad(0.004), 0.95e-3);
    for (tool, height) in [wheel, pad] {
        for turns in [100, 45, 0] {
            let path = path(turns, height);
            let found = untouched(&surface, &path, &tool, CLEARANCE);
            for (at, &found) in found.iter().enumerate() {
                let point = pixels.position(at % pixels.nx, at / pixels.nx).extend(surface.heights[at]);
                let clear = path.poses.iter().all(|pose| is_clear(&tool, pose, point, pixels.pitch));
                assert_eq!(found, point.is_finite() && clear, "pixel {at}, {tool:?}, leaning from pose {turns} on");
            }
            let free = found.iter().filter(|free| **free).count();
            assert!((500..9000).contains(&free), "{free} of {} pixels are free", found.len());
        }
    }
}
