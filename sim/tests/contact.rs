//! Contact force against the closed forms (convention T: depth is the wheel's signed distance at the
//! workpiece's surface).

mod common;

use std::f64::consts::PI;

use common::{WHEEL, ball, bar, base, fresh, odd_turn, plate, pressed, turned};
use glam::DVec3;
use robot::{Pad, Tool, Wheel};
use sdf_bake::BrickGrid;
use sim::physics::Physics;
use sim::press::Press;
use sim::{Contact, Frame, Pose};

const K: f64 = 1e10;

fn contact(grid: &BrickGrid, wheel: &Wheel, pose: &Pose) -> Contact {
    let model = base();
    let mut states = fresh(&model);
    let mut physics = Physics::new(&model, &mut states, 0.0);
    Press::new(grid, &Tool::from(*wheel), *pose, 1e-3).contact(0.0, &mut physics).expect("a contact")
}

/// K b [a R - c² asinh(a/c)], in terms that do not cancel.
fn wheel_on_flat(wheel: &Wheel, depth: f64) -> f64 {
    let n = 200_000;
    let a = (2.0 * wheel.radius * depth - depth * depth).sqrt();
    let c = wheel.radius - depth;
    let at = |i: usize| wheel.radius - c.hypot(a * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0));
    K * wheel.width * 2.0 * a * (0..n).map(at).sum::<f64>() / n as f64
}

/// Force ∫ p n·a dA of a wheel across a bar of circular section, and load ∫ p dA, by a fine sum over the bar's surface.
fn wheel_across_bar(wheel: &Wheel, radius: f64, depth: f64) -> (f64, f64) {
    let n = 3000;
    let (a, b) = (1.1 * (2.0 * wheel.radius * depth).sqrt(), 1.1 * (2.0 * radius * depth).sqrt());
    let at = |i: usize, half: f64| half * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
    let (mut force, mut load) = (0.0, 0.0);
    for j in 0..n {
        let above_axis = (radius * radius - at(j, b).powi(2)).sqrt();
        let height = above_axis - radius;
        let row = (0..n).map(|i| (wheel.radius - at(i, a).hypot(wheel.radius - depth - height)).max(0.0)).sum::<f64>();
        force += row;
        // n·a is the share of the radius that stands upright.
        load += row * radius / above_axis;
    }
    let scale = K * 4.0 * a * b / (n * n) as f64;
    (force * scale, load * scale)
}

fn report(case: &str, voxel: f64, found: f64, exact: f64) -> f64 {
    let error = (found / exact - 1.0).abs();
    println!("{case}, {} mm voxels: {found:.4} N, exact {exact:.4} N, error {:.4} %", voxel * 1e3, error * 100.0);
    error
}

#[test]
fn a_wheel_on_a_flat_plate_meets_the_closed_form_and_converges() {
    for depth in [32e-6, 100e-6, 200e-6] {
        let exact = wheel_on_flat(&WHEEL, depth);
        let error = |voxel: f64| {
            let grid = plate(voxel, 0.0);
            report(
                &format!("flat, {:.0} µm", depth * 1e6),
                voxel,
                contact(&grid, &WHEEL, &pressed(&WHEEL, 1.3e-3, 0.4e-3, depth)).force,
                exact,
            )
        };
        assert!(error(0.5e-3) < 5e-3);
        assert!(error(0.25e-3) < 1e-3);
    }
}

#[test]
fn a_plate_that_lies_askew_to_the_lattice_gives_the_same_force() {
    let turn = odd_turn();
    let half = DVec3::splat(0.022);
    let depth = 100e-6;
    for (voxel, limit) in [(0.5e-3, 5e-3), (0.25e-3, 1e-3)] {
        let grid = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| (turn.transpose() * p).z);
        let pose = pressed(&WHEEL, 0.0, 0.0, depth);
        let pose = turned(&pose, turn);
        let found = contact(&grid, &WHEEL, &pose);
        assert!(report("askew flat", voxel, found.force, wheel_on_flat(&WHEEL, depth)) < limit);
    }
}

#[test]
fn a_wheel_across_a_bar_meets_the_closed_form_and_converges_at_second_order() {
    let (radius, depth) = (0.02, 150e-6);
    let (exact, _) = wheel_across_bar(&WHEEL, radius, depth);
    let parabolic = PI * K * depth * depth * (WHEEL.radius * radius).sqrt();
    assert!((exact / parabolic - 1.0).abs() < 0.01, "{exact}, {parabolic}");
    let errors = [1e-3, 0.5e-3, 0.25e-3].map(|voxel| {
        let grid = bar(voxel, radius, 0.03);
        // The mean over positions within a voxel: a single position may be right by coincidence. The wheel is wide
        // enough that a shift along its own axis changes nothing.
        let places = 5;
        let error = |i: usize| {
            let shift = voxel * (i as f64 + 0.5) / places as f64;
            let found = contact(&grid, &WHEEL, &pressed(&WHEEL, shift, 0.37 * shift, depth)).force;
            (found / exact - 1.0).powi(2)
        };
        let rms = ((0..places).map(error).sum::<f64>() / places as f64).sqrt();
        println!("across a bar of 20 mm, {} mm voxels: error {:.4} %", voxel * 1e3, rms * 100.0);
        rms
    });
    assert!(errors[1] < 5e-3 && errors[2] < 1e-3, "{errors:?}");
    assert!(errors[0] / errors[2] > 12.0, "two halvings at second order give 16: {errors:?}");
}

#[test]
fn a_narrow_bead_crown_is_within_a_percent_at_half_a_millimetre() {
    let (radius, depth) = (4.17e-3, 180e-6);
    let (force, load) = wheel_across_bar(&WHEEL, radius, depth);
    assert!(load > 1.005 * force, "{load} N, {force} N");
    for (voxel, limit) in [(0.5e-3, 1e-2), (0.25e-3, 3e-3)] {
        let found = contact(&bar(voxel, radius, 0.02), &WHEEL, &pressed(&WHEEL, 0.11e-3, 0.07e-3, depth));
        assert!(report("bead crown of 4.17 mm", voxel, found.force, force) < limit);
        assert!(report("its load ∫ p dA", voxel, found.load, load) < limit);
        let slopes = (found.load / found.force) / (load / force) - 1.0;
        println!("    load over force: {:+.4} %", slopes * 100.0);
        assert!(slopes.abs() < 1e-3, "{slopes}");
    }
}

#[test]
fn a_wheel_on_a_ball_meets_the_parabolic_form() {
    let (radius, depth) = (0.03, 100e-6);
    // For parabolic gaps: curvatures 1/R + 1/r along the feed, 1/r across.
    let along = 1.0 / (1.0 / WHEEL.radius + 1.0 / radius);
    let exact = PI * K * depth * depth * (along * radius).sqrt();
    for (voxel, limit) in [(0.5e-3, 6e-3), (0.25e-3, 4e-3)] {
        let grid = ball(voxel, radius, DVec3::Z * -radius);
        let found = contact(&grid, &WHEEL, &pressed(&WHEEL, 0.0, 0.0, depth));
        assert!(report("ball of 30 mm", voxel, found.force, exact) < limit);
    }
}

#[test]
fn a_tilted_wheel_meets_the_closed_form_for_force_and_has_a_moment() {
    let (tilt, depth) = (2.5e-3f64, 60e-6);
    let (high, low) = (depth + 0.01 * tilt.tan(), (depth - 0.01 * tilt.tan()).max(0.0));
    let exact = 8.0 / 15.0 * K * (2.0 * WHEEL.radius).sqrt() / tilt.tan() * (high.powf(2.5) - low.powf(2.5));
    for (voxel, limit) in [(0.5e-3, 5e-3), (0.25e-3, 2e-3)] {
        let frame = Frame::about(DVec3::Y, DVec3::Z).tilted(-tilt, 0.0);
        let pose = Pose { centre: frame.z * WHEEL.radius - DVec3::Z * depth, approach: DVec3::Z, frame };
        let found = contact(&plate(voxel, 0.0), &WHEEL, &pose);
        assert!(report("tilted 2.5 mrad", voxel, found.force, exact) < limit);
        assert!(found.moment.x.abs() > 1e-3 * found.force, "{}", found.moment);
    }
}

/// A plate whose top is tilted by `tilt` [rad] about y, or about x if `across`.
fn tilted_plate(voxel: f64, tilt: f64, across: bool) -> BrickGrid {
    let half = DVec3::new(0.022, 0.022, 0.004);
    let normal =
        if across { DVec3::new(0.0, -tilt.sin(), tilt.cos()) } else { DVec3::new(-tilt.sin(), 0.0, tilt.cos()) };
    BrickGrid::from_distance(-half, half, voxel, 3.0, move |p| p.dot(normal) + 0.37e-4)
}

/// Force at `depth` below the first touch, and the highest pressure.
fn below_touch((grid, tool): (&BrickGrid, &Tool), place: (f64, f64), frame: Frame, depth: f64) -> Contact {
    let model = base();
    let mut states = fresh(&model);
    let mut physics = Physics::new(&model, &mut states, 0.0);
    let centre = DVec3::new(place.0, place.1, tool.drop());
    let mut press = Press::new(grid, tool, Pose { centre, approach: DVec3::Z, frame }, 2e-3).closer();
    let touch = press.touch(&mut physics).expect("a model").expect("a touch");
    press.contact(touch - depth, &mut physics).expect("a contact")
}

#[test]
fn a_tilted_surface_is_first_touched_at_the_border_of_the_tool() {
    for (tilt, depth) in [(2.5e-3f64, 100e-6), (7e-3, 60e-6), (20e-3, 150e-6)] {
        // Parabolic gap along the wheel; the highest edge of the rim is `depth` deep.
        let low = (depth - WHEEL.width * tilt.tan()).max(0.0);
        let wheel = 8.0 / 15.0 * K * (2.0 * WHEEL.radius).sqrt() / tilt.tan() * (depth.powf(2.5) - low.powf(2.5));
        let radius = 0.012;
        let (deepest, slope) = (depth, tilt.tan());
        let n = 4000;
        // Vertical depth under a level pad, integrated in strips across the slope; this is the depth along the pad's
        // own axis.
        let strip = |i: usize| {
            let x = radius * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
            2.0 * (radius * radius - x * x).sqrt() * (deepest + (x - radius) * slope).max(0.0)
        };
        let pad = K * 2.0 * radius / n as f64 * (0..n).map(strip).sum::<f64>();
        for (voxel, limit) in [(0.5e-3, 5e-3), (0.25e-3, 1e-3)] {
            for place in [(0.0, 0.0), (0.11e-3, 0.07e-3), (-0.21e-3, 0.16e-3)] {
                let (about, level) = (Frame::about(DVec3::Y, DVec3::Z), Frame::facing(DVec3::Z, DVec3::X));
                let across = tilted_plate(voxel, tilt, true);
                let found = below_touch((&across, &Tool::from(WHEEL)), place, about, depth);
                assert!(report(&format!("wheel, {tilt} rad at {place:?}"), voxel, found.force, wheel) < limit);
                assert!((found.pressure_max / (K * depth) - 1.0).abs() < 1e-3, "{}", found.pressure_max);
                for across in [across, tilted_plate(voxel, tilt, false)] {
                    let found = below_touch((&across, &Tool::from(Pad { radius })), place, level, depth);
                    assert!(report(&format!("pad, {tilt} rad at {place:?}"), voxel, found.force, pad) < limit);
                    assert!((found.pressure_max / (K * depth) - 1.0).abs() < 1e-3, "{}", found.pressure_max);
                }
            }
        }
    }
}

#[test]
fn a_wheel_held_across_and_along_a_narrow_bead_meets_the_closed_form() {
    let (radius, depth) = (4.17e-3, 100e-6);
    let (across, _) = wheel_across_bar(&WHEEL, radius, depth);
    // The wheel's distance at the bar's circle, by a fine sum across both.
    let (n, half) = (200_000, 1.2e-3);
    let at = |i: usize| half * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
    let overlap = |y: f64| WHEEL.radius - y.hypot(WHEEL.radius - depth + radius - (radius * radius - y * y).sqrt());
    let along = K * WHEEL.width * 2.0 * half / n as f64 * (0..n).map(|i| overlap(at(i)).max(0.0)).sum::<f64>();
    for (voxel, limit) in [(0.5e-3, 2e-3), (0.25e-3, 5e-4)] {
        let grid = bar(voxel, radius, 0.02);
        for place in [(0.11e-3, 0.07e-3), (0.0, 0.0), (0.2e-3, -0.24e-3)] {
            let tool = Tool::from(WHEEL);
            let found = below_touch((&grid, &tool), (place.0, 0.0), Frame::about(DVec3::Y, DVec3::Z), depth);
            assert!(report(&format!("across at {place:?}"), voxel, found.force, across) < limit);
            let found = below_touch((&grid, &tool), (place.0, 0.0), Frame::about(DVec3::X, DVec3::Z), depth);
            assert!(report(&format!("along at {place:?}"), voxel, found.force, along) < limit);
        }
    }
}

#[test]
fn patch_area_and_pressures_meet_the_closed_form() {
    let depth = 100e-6;
    let a = (2.0 * WHEEL.radius * depth - depth * depth).sqrt();
    let found = contact(&plate(0.5e-3, 0.0), &WHEEL, &pressed(&WHEEL, 0.0, 0.0, depth));
    println!("patch: area {:+.3} %", (found.area / (2.0 * a * WHEEL.width) - 1.0) * 100.0);
    assert!((found.area / (2.0 * a * WHEEL.width) - 1.0).abs() < 1e-3, "{}", found.area);
    assert!((found.pressure_max / (K * depth) - 1.0).abs() < 2e-3, "{}", found.pressure_max);
    let mean = wheel_on_flat(&WHEEL, depth) / (2.0 * a * WHEEL.width);
    assert!((found.pressure_mean() / mean - 1.0).abs() < 5e-3, "{}", found.pressure_mean());
    assert!(found.moment.length() < 2e-3 * found.force * WHEEL.width, "a level wheel has no moment: {}", found.moment);
}

#[test]
fn the_force_does_not_ripple_while_the_wheel_slides_over_voxels() {
    // Oblique to the lattice: otherwise every position along it would be the same within the voxel.
    let (voxel, turn, half) = (0.5e-3, odd_turn(), DVec3::splat(0.025));
    let flat = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| (turn.transpose() * p).z);
    let bar = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| {
        let q = turn.transpose() * p;
        q.y.hypot(q.z + 0.02) - 0.02
    });
    for (name, grid, depth) in [("flat", flat, 32e-6), ("bar", bar, 150e-6)] {
        let force = |i: i32| {
            let pose = pressed(&WHEEL, 0.043e-3 * f64::from(i), 0.0, depth);
            let pose = turned(&pose, turn);
            contact(&grid, &WHEEL, &pose).force
        };
        let forces: Vec<f64> = (0..50).map(force).collect();
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        let ripple = forces.iter().map(|f| (f / mean - 1.0).abs()).fold(0.0, f64::max);
        println!("ripple while sliding, {name}: {ripple:.1e}");
        assert!(ripple > 0.0 && ripple < 5e-3);
    }
}

#[test]
fn a_wheel_in_the_air_meets_nothing() {
    let found = contact(&plate(0.5e-3, 0.0), &WHEEL, &pressed(&WHEEL, 0.0, 0.0, -1e-6));
    assert_eq!(found, Contact::default());
}
