//! Compares silhouettes and depths with ray casts against the extracted surface.

use glam::DVec2;
use render::{Camera, Raster, Scene, VisibleObject};
use sdf_bake::query::MeshQuery;

use crate::scenes::{VOXEL, bracket};

#[test]
fn silhouettes_and_depths_agree_with_ray_casts_at_the_extracted_surface_within_half_a_voxel() {
    let part = bracket();
    let mesh = MeshQuery::new(&part.surface_mesh());
    let (low, high) = part.surface_bounds().unwrap();
    let raster = Raster { width: 160, height: 120, samples_per_side: 1 };
    let scene = Scene::new(&part);
    for (azimuth, elevation) in [(-1.0, 0.6), (2.4, 0.2), (0.5, -0.8), (1.6, 1.5)] {
        let camera = Camera::framing(low, high, azimuth, elevation, 4.0 / 3.0);
        let frame = scene.photograph(&camera, &raster);
        let cast = |at: DVec2| {
            let ray = camera.ray(at, 4.0 / 3.0);
            let hit = mesh.ray(ray.origin, ray.direction, f64::INFINITY);
            hit.map(|hit| camera.depth(ray.origin + ray.direction * hit.distance))
        };
        let (mut compared, mut seen) = (0, 0);
        (0..160 * 120).for_each(|pixel| {
            let (x, y) = (pixel % 160, pixel / 160);
            let at = DVec2::new((x as f64 + 0.5) / 160.0, (y as f64 + 0.5) / 120.0);
            let depth = f64::from(frame.depth[pixel]);
            assert_eq!(depth.is_finite(), frame.seen[pixel] == VisibleObject::Part);
            seen += usize::from(depth.is_finite());
            // Depths of the extracted surface within half a voxel around the pixel's ray: the range for a surface with
            // an error of half a voxel.
            let half = 0.5 * VOXEL / (camera.pixel_size(camera.depth(0.5 * (low + high)), 120) * 120.0);
            let around = |i: i32| DVec2::new(f64::from(i % 3 - 1) * 0.75, f64::from(i / 3 - 1)) * half;
            let casts: Vec<Option<f64>> = (0..9).map(|i| cast(at + around(i))).collect();
            if casts.iter().all(Option::is_none) {
                assert!(depth.is_infinite(), "the part shows at ({x}, {y}), where no surface is");
            }
            let known: Vec<f64> = casts.iter().flatten().copied().collect();
            if known.len() == 9 {
                compared += 1;
                let (nearest, farthest) = known.iter().fold((f64::MAX, f64::MIN), |(a, b), &d| (a.min(d), b.max(d)));
                let off = (nearest - depth).max(depth - farthest);
                assert!(off < 0.5 * VOXEL, "depth {depth} at ({x}, {y}), the surface lies at {nearest} to {farthest}");
            }
        });
        assert!(compared > 2500 && compared as f64 > 0.85 * seen as f64, "{compared} of {seen} pixels compared");
    }
}
