//! Compares a sphere's photograph with its closed form.

use glam::{DVec2, DVec3};
use render::{Camera, Distortion, Placement, Projection, Raster, Scene, VisibleObject};
use sdf_bake::BrickGrid;

use crate::scenes::VOXEL;

const RADIUS: f64 = 0.01;

/// Distance along a ray to a sphere; `None` for a miss.
fn to_sphere(origin: DVec3, direction: DVec3, centre: DVec3) -> Option<f64> {
    let away = origin - centre;
    let along = away.dot(direction);
    let root = along * along - away.length_squared() + RADIUS * RADIUS;
    (root >= 0.0).then(|| -along - root.sqrt())
}

#[test]
fn silhouette_depth_and_normal_of_a_sphere_are_those_of_the_closed_form() {
    let low = DVec3::splat(-RADIUS);
    let ball = BrickGrid::from_distance(low, -low, VOXEL, 3.0, |p| p.length() - RADIUS);
    let mut scene = Scene::new(&ball);
    let turned = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -0.9, 2.0);
    scene.placement = Placement { rotation: turned, translation: DVec3::new(0.04, -0.01, 0.02) };
    let centre = scene.placement.translation;
    let lens = Distortion { radial: [-0.25, 0.08, 0.0], tangential: [0.003, -0.002] };
    let looking = |projection| Camera::look_at(centre + DVec3::new(0.05, -0.03, 0.04), centre, projection);
    let pinhole = Projection::of_lens(0.035, 0.012);
    for camera in [
        looking(pinhole),
        looking(Projection::Orthographic { height: 0.024 }),
        Camera { distortion: lens, ..looking(pinhole) },
    ] {
        let raster = Raster { width: 320, height: 240, samples_per_side: 1 };
        let frame = scene.photograph(&camera, &raster);
        let mut compared = 0;
        for (pixel, &seen) in frame.seen.iter().enumerate() {
            let (x, y) = (pixel % 320, pixel / 320);
            let at = DVec2::new((x as f64 + 0.5) / 320.0, (y as f64 + 0.5) / 240.0);
            let ray = camera.ray(at, 4.0 / 3.0);
            let closest = (ray.origin - centre).reject_from(ray.direction).length();
            // Within half a voxel of the outline either result is accepted; here that is at most one pixel.
            if (closest - RADIUS).abs() > 0.5 * VOXEL {
                assert_eq!(
                    seen == VisibleObject::Part,
                    closest < RADIUS,
                    "pixel ({x}, {y}), {closest} m from the centre"
                );
            }
            let Some(distance) = to_sphere(ray.origin, ray.direction, centre).filter(|_| closest < 0.95 * RADIUS)
            else {
                continue;
            };
            compared += 1;
            let point = ray.origin + ray.direction * distance;
            let outward = (point - centre).normalize();
            let slant = outward.dot(-ray.direction);
            let depth = f64::from(frame.depth[pixel]) - camera.depth(point);
            assert!(depth.abs() * slant < 0.05 * VOXEL, "depth off by {depth} m at ({x}, {y})");
            let normal = turned * frame.normal[pixel].as_dvec3();
            assert!(normal.distance(outward) < 0.03, "normal {normal} for {outward}");
            let position = scene.placement.to_scene(frame.position[pixel].as_dvec3());
            assert!(position.distance(point) * slant < 0.06 * VOXEL, "{position} for {point}");
        }
        assert!(compared > 8000, "{compared} pixels");
    }
}
