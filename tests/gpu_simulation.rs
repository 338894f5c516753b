//! The field on the GPU against the field on the CPU: same constants, same samples.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use sdf_bake::{BrickGrid, grid};
use shaders::{GridBuffers, GridHeader, SELF_CHECK_LIMIT, Sampler, constants, testing};

/// Makes a torus of ring radius 20 mm and tube radius 7 mm, away from the origin.
fn torus() -> BrickGrid {
    let centre = DVec3::new(0.013, -0.021, 0.004);
    let reach = DVec3::new(0.027, 0.027, 0.007);
    BrickGrid::from_distance(centre - reach, centre + reach, 0.0005, 3.0, |p| {
        let q = p - centre;
        (q.truncate().length() - 0.020).hypot(q.z) - 0.007
    })
}

#[test]
fn both_sides_share_their_constants() {
    assert_eq!(constants::BRICK_SIDE as usize, grid::BRICK_SIDE);
    assert_eq!(constants::BRICK_VOXELS as usize, grid::BRICK_VOXELS);
    assert_eq!(constants::OUTSIDE, grid::OUTSIDE);
    assert_eq!(constants::INSIDE, grid::INSIDE);
}

#[test]
fn the_device_samples_a_brick_grid_as_the_cpu_does() {
    let Some(device) = testing::device("the field on the device against BrickGrid::sample") else {
        return;
    };
    let field = torus();
    let header = GridHeader::new(
        field.origin.to_array(),
        field.dims.as_uvec3().to_array(),
        field.voxel as f32,
        field.band,
        field.brick_count() as u32,
    );
    let index = field.index.dense();
    let buffers = GridBuffers { header, index: &index, phi: &field.phi };
    let sampler = Sampler::new(&device, &buffers).unwrap();
    let seed = 20_u64;
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let points: Vec<[f32; 4]> = (0..20_000)
        .map(|_| {
            let mut along = |low: f32, high: f32| random.random_range(low..high);
            [along(-0.02, 0.05), along(-0.055, 0.015), along(-0.01, 0.02), 0.0]
        })
        .collect();
    let sampled = sampler.sample(&points).unwrap();
    for (point, device_phi) in points.iter().zip(sampled) {
        let at = DVec3::new(point[0].into(), point[1].into(), point[2].into());
        let apart = (device_phi - field.sample(at)).abs() / field.voxel as f32;
        assert!(apart <= SELF_CHECK_LIMIT, "{apart} voxels apart at {at}, seed {seed}");
    }
}
