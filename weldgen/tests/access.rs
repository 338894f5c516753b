//! Tool access in cases with known results.

mod shapes;

use glam::DVec3;
use sdf_bake::{Mesh, query::MeshQuery};
use shapes::cuboid;
use weldgen::access::{ToolKind, ToolShape, access};
use weldgen::curve::{CurvePoint, WeldCurve};

/// A straight curve along x on z = 0 at a distance from the plane y = 0.
fn along_x(y: f64) -> WeldCurve {
    let point = |i: u32| CurvePoint {
        position: DVec3::new(-0.02 + 0.001 * f64::from(i), y, 0.0),
        tangent: DVec3::X,
        normal: DVec3::Z,
        side: DVec3::Y,
        arc_length: 0.001 * f64::from(i),
        geodesic_curvature: 0.0,
        face: 0,
        barycentric: [1.0, 0.0, 0.0],
        exposure: 1.0,
        access: 1.0,
        width: 0.008,
        height: 0.002,
    };
    WeldCurve { points: (0..=40).map(point).collect() }
}

fn floor() -> Mesh {
    cuboid(DVec3::new(-1.0, -1.0, -0.1), DVec3::new(1.0, 1.0, 0.0))
}

fn mean(part: &Mesh, y: f64, kind: ToolKind, radius: f64, width: f64) -> f64 {
    let tool = ToolShape { kind, radius, width };
    let shares = access(&MeshQuery::new(part), &along_x(y), tool, [0.008, 0.002]);
    assert_eq!(shares.len(), 41);
    shares.iter().sum::<f64>() / 41.0
}

#[test]
fn on_an_open_floor_every_pose_is_free() {
    for kind in [ToolKind::Wheel, ToolKind::Pad] {
        assert_eq!(mean(&floor(), 0.0, kind, 0.05, 0.01), 1.0);
    }
}

#[test]
fn a_wall_takes_the_poses_that_reach_into_it() {
    let mut part = floor();
    part.append(&cuboid(DVec3::new(-1.0, -0.1, -0.1), DVec3::new(1.0, 0.0, 0.5)));
    // 20 mm from the wall: a wheel parallel to the wall fits upright; one across it, 100 mm in diameter, does not.
    let near = mean(&part, 0.02, ToolKind::Wheel, 0.05, 0.01);
    let far = mean(&part, 0.2, ToolKind::Wheel, 0.05, 0.01);
    assert_eq!(far, 1.0);
    assert!((1.0 / 18.0..0.5).contains(&near), "{near}");
    let small = mean(&part, 0.02, ToolKind::Wheel, 0.01, 0.004);
    assert!(small > near, "a smaller wheel gets at more: {small}, {near}");
    // A pad of 50 mm that leans with its far rim to the wall fits; leaning away, its disc is in the wall.
    let pad = mean(&part, 0.02, ToolKind::Pad, 0.05, 0.01);
    assert!((1.0 / 6.0..0.9).contains(&pad), "{pad}");
}

#[test]
fn under_a_low_ceiling_nothing_is_free() {
    let mut part = floor();
    part.append(&cuboid(DVec3::new(-1.0, -1.0, 0.03), DVec3::new(1.0, 1.0, 0.1)));
    assert_eq!(mean(&part, 0.0, ToolKind::Wheel, 0.05, 0.01), 0.0);
}
