//! A surface that recedes everywhere at the same speed, in small steps with bricks opened and φ redistanced after each;
//! compared with the volumes of the shrunk solids.

use std::f64::consts::PI;

use glam::{DVec3, IVec3};
use sdf_bake::BrickGrid;

const VOXEL: f64 = 0.4e-3;
const RECESSION: f64 = 1.5e-3;
const STEPS: usize = 15;

/// Relative error of the volume after recession; prints it.
fn recede(name: &str, half: DVec3, distance: impl Fn(DVec3) -> f64 + Sync, exact: f64) -> f64 {
    let mut grid = BrickGrid::from_distance(-half, half, VOXEL, 3.0, distance);
    for _ in 0..STEPS {
        for phi in grid.phi.iter_mut().filter(|phi| phi.abs() < grid.band) {
            *phi = (*phi + (RECESSION / STEPS as f64) as f32).min(grid.band);
        }
        open_neighbours(&mut grid);
        grid.redistance(&(0..grid.brick_count() as u32).collect::<Vec<_>>());
        grid.release_uniform_bricks();
    }
    assert_eq!(grid.sanity_check(), Ok(()));
    let error = grid.volume() / exact - 1.0;
    println!("{name} receded by {} mm at {} mm voxels: volume {:+.3} %", RECESSION * 1e3, VOXEL * 1e3, error * 100.0);
    error.abs()
}

/// Opens the inside bricks around each brick.
fn open_neighbours(grid: &mut BrickGrid) {
    for brick in grid.bricks.clone() {
        for i in 0..27 {
            grid.open_inside_brick(brick + IVec3::new(i / 9, i / 3 % 3, i % 3) - 1);
        }
    }
}

fn box_distance(p: DVec3, half: DVec3) -> f64 {
    let q = p.abs() - half;
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

#[test]
fn a_ball_shrinks_to_a_ball() {
    let exact = 4.0 / 3.0 * PI * (0.01f64 - RECESSION).powi(3);
    assert!(recede("ball of 10 mm", DVec3::splat(0.01), |p| p.length() - 0.01, exact) < 2e-3);
}

#[test]
fn a_torus_shrinks_to_a_torus() {
    let exact = 2.0 * PI * PI * 0.012 * (0.005f64 - RECESSION).powi(2);
    let torus = |p: DVec3| (p.x.hypot(p.y) - 0.012).hypot(p.z) - 0.005;
    assert!(recede("torus 12/5 mm", DVec3::new(0.017, 0.017, 0.005), torus, exact) < 2e-3);
}

#[test]
fn a_box_keeps_its_sharp_edges() {
    let half = DVec3::new(0.010, 0.008, 0.007);
    let exact = 8.0 * (half - RECESSION).element_product();
    assert!(recede("box 20 x 16 x 14 mm", half, |p| box_distance(p, half), exact) < 2e-3);
}

#[test]
fn a_box_cavity_grows_rounded() {
    let (outer, inner) = (DVec3::splat(0.012), DVec3::new(0.005, 0.004, 0.003));
    let e = RECESSION;
    let (a, b, c) = (2.0 * inner.x, 2.0 * inner.y, 2.0 * inner.z);
    let cavity = a * b * c + 2.0 * (a * b + b * c + c * a) * e + PI * (a + b + c) * e * e + 4.0 / 3.0 * PI * e.powi(3);
    let exact = 8.0 * (outer - e).element_product() - cavity;
    let distance = |p: DVec3| box_distance(p, outer).max(-box_distance(p, inner));
    assert!(recede("box with a cavity", outer, distance, exact) < 2e-3);
}
