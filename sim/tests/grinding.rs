//! Force control and removal along a path, against closed forms and identities.

mod common;

use common::{GRIND_RATE, WHEEL, ball, base, fresh, line, odd_turn, plate, threshold, welded_plate, with_effect};
use effects::CompiledModel;
use glam::DVec3;
use rayon::ThreadPoolBuilder;
use robot::{Controller, Tool, Wheel};
use sdf_bake::BrickGrid;
use sim::{CurvePoint, Pass, PassError, PassRecord, PassSettings, Path, run_pass};

/// Feed of the tests [m/s].
const FEED: f64 = 5e-3;

/// A pass, and the volume that the field lost [m³].
fn pass(grid: &mut BrickGrid, path: &Path, model: &CompiledModel) -> (PassRecord, f64) {
    let (tool, settings, before) = (Tool::from(WHEEL), PassSettings::default(), grid.volume());
    let pass = Pass::first(&tool, path, &settings, model);
    let record = run_pass(grid, pass, &mut fresh(model), &mut |_| {}).expect("a pass");
    assert_eq!(grid.sanity_check(), Ok(()));
    let lost = before - grid.volume();
    (record, lost)
}

/// Prints the deviations of the lost volume from `k ∫∫ p dA dt`, `k ∫ F dt` and the law on the contact; returns the
/// first and the last. Asserts that ∫ F dt is that of the setpoint, and no more than ∫∫ p dA dt: `F = ∫ p n·a dA`.
fn volume_errors(name: &str, (record, lost): &(PassRecord, f64)) -> (f64, f64) {
    let against = |volume: f64| lost / volume - 1.0;
    let (by_load, by_law) = (against(GRIND_RATE * record.load_impulse), against(record.removed_volume));
    println!(
        "{name}: {:.3} mm³ in {} steps; against k∫∫p dA dt {:+.3} %, k∫F dt {:+.3} %, ∫∫ r dA dt {:+.3} %",
        lost * 1e9,
        record.steps,
        by_load * 100.0,
        against(GRIND_RATE * record.impulse) * 100.0,
        by_law * 100.0
    );
    let setpoint = PassSettings::default().force_setpoint * record.contact_time;
    println!("    ∫ F dt {:+.3} % off the setpoint's", (record.impulse / setpoint - 1.0) * 100.0);
    assert!((record.impulse / setpoint - 1.0).abs() < 1e-3 && record.impulse <= record.load_impulse);
    (by_load.abs(), by_law.abs())
}

#[test]
fn a_flat_plate_loses_k_times_impulse_and_keeps_a_groove_of_the_closed_form() {
    let mut grid = plate(0.5e-3, 0.1e-3);
    let original = grid.clone();
    let record = pass(&mut grid, &Path::along(&line(-0.02, 0.02, 0.1e-3), FEED).unwrap(), &base());
    let (by_load, by_law) = volume_errors("flat, 0.5 mm voxels", &record);
    assert!(by_load < 3e-3 && by_law < 3e-3);
    assert!(record.0.force_rms_error < 1e-4 * 15.0, "{}", record.0.force_rms_error);
    // Where the pass is steady, the groove's section is kF/v and its depth kF/(bv).
    let (low, high) = (DVec3::new(5e-3, -1.0, -1.0), DVec3::new(15e-3, 1.0, 1.0));
    let section = (original.volume_within(low, high) - grid.volume_within(low, high)) / 10e-3;
    let section_error = section / (GRIND_RATE * 15.0 / FEED) - 1.0;
    let depth = GRIND_RATE * 15.0 / (WHEEL.width * FEED);
    let depth_error = f64::from(grid.sample(DVec3::new(0.01, 0.0, 0.1e-3 - depth))) / depth;
    println!("groove: section {:+.3} %, depth {:+.3} %", section_error * 100.0, depth_error * 100.0);
    assert!(section_error.abs() < 3e-3);
    assert!(depth_error.abs() < 1e-2, "its rims lie on columns");
}

#[test]
fn finer_voxels_lose_k_times_impulse_as_well() {
    let mut grid = plate(0.25e-3, 0.1e-3);
    let record = pass(&mut grid, &Path::along(&line(-0.01, 0.01, 0.1e-3), FEED).unwrap(), &base());
    let (by_load, by_law) = volume_errors("flat, 0.25 mm voxels", &record);
    assert!(by_load < 3e-3 && by_law < 3e-3);
}

/// A pass with an effect over a plate.
fn pass_with(effect: &str) -> (PassRecord, f64) {
    let mut grid = plate(0.25e-3, 0.1e-3);
    pass(&mut grid, &Path::along(&line(-0.01, 0.01, 0.1e-3), FEED).unwrap(), &with_effect(0.0, effect))
}

#[test]
fn contacts_that_stiffen_or_soften_lose_k_times_impulse_as_well() {
    // From -0.5 on, the greatest pressure lies within the reference depth: deeper is the plateau.
    for stiffening in [-0.8, -0.6, -0.3, 0.5, 1.0] {
        let record = pass_with(&format!("[effect.contact-stiffening]\nstiffening = {stiffening}\n"));
        let (by_load, by_law) = volume_errors(&format!("stiffening {stiffening}"), &record);
        assert!(by_load < 3e-3 && by_law < 3e-3);
        assert!(record.0.force_rms_error < 0.02 * 15.0, "{}", record.0.force_rms_error);
    }
}

#[test]
fn a_viscoelastic_contact_loses_k_times_its_load_as_well() {
    let (record, lost) = pass_with("[effect.viscoelastic-pad]\n");
    let (by_load, by_law) = (lost / (GRIND_RATE * record.load_impulse) - 1.0, lost / record.removed_volume - 1.0);
    let by_force = lost / (GRIND_RATE * record.impulse) - 1.0;
    println!("viscoelastic: against k∫∫p dA dt {:+.3} %, k∫F dt {:+.3} %", 100.0 * by_load, 100.0 * by_force);
    assert!(by_load.abs() < 3e-3 && by_law.abs() < 3e-3, "{by_load} {by_law}");
}

#[test]
fn the_force_does_not_ripple_while_a_pass_slides_without_removal() {
    let (turn, half, voxel) = (odd_turn(), DVec3::splat(0.02), 0.5e-3);
    let flat = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| (turn.transpose() * p).z);
    let bar = BrickGrid::from_distance(-half, half, voxel, 3.0, |p| {
        let q = turn.transpose() * p;
        q.y.hypot(q.z + 0.02) - 0.02
    });
    let model = threshold(1e9);
    let settings = PassSettings { controller: Controller::Replay, ..PassSettings::default() };
    for (name, mut grid, depth) in [("flat", flat, 32e-6), ("bar", bar, 150e-6)] {
        let curve = line(-3e-3, 3e-3, -depth)
            .map(|point| CurvePoint { position: turn * point.position, normal: turn * point.normal });
        let (tool, path, mut forces) = (Tool::from(WHEEL), Path::along(&curve, FEED).unwrap(), Vec::new());
        let pass = Pass::first(&tool, &path, &settings, &model);
        run_pass(&mut grid, pass, &mut fresh(&model), &mut |now| forces.push(now.force)).expect("a pass");
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        let ripple = forces.iter().map(|force| (force / mean - 1.0).abs()).fold(0.0, f64::max);
        println!("ripple in a pass without removal, {name}: {ripple:.1e} of {mean:.3} N in {} steps", forces.len());
        assert!(forces.len() >= 24 && mean > 10.0 && ripple < 5e-3);
    }
}

#[test]
fn a_threshold_lowers_the_removed_volume_as_the_law_says() {
    let model = threshold(1e5);
    let mut grid = plate(0.5e-3, 0.0);
    let record = pass(&mut grid, &Path::along(&line(-0.02, 0.02, 0.0), FEED).unwrap(), &model);
    let (_, by_law) = volume_errors("flat, threshold 0.1 MPa", &record);
    assert!(by_law < 3e-3);
    assert!(record.1 < 0.9 * GRIND_RATE * record.0.impulse);
}

#[test]
fn nothing_is_removed_below_the_threshold_or_away_from_the_wheel() {
    let never = threshold(1e9);
    let mut grid = plate(0.5e-3, 0.0);
    let original = grid.clone();
    let path = Path::along(&line(-0.005, 0.005, 0.0), FEED).unwrap();
    let record = pass(&mut grid, &path, &never);
    assert_eq!((record.0.removed_volume, record.1), (0.0, 0.0));
    assert!(grid == original, "the field is unchanged");

    pass(&mut grid, &path, &base());
    for x in [-0.025, 0.0, 0.025] {
        let beside = DVec3::new(x, 0.0105 + 1e-3, 0.0);
        assert_eq!(grid.sample(beside), original.sample(beside), "beside the wheel at {beside}");
    }
    assert!(grid.phi_at(DVec3::ZERO.as_ivec3()) > 0.0);
}

#[test]
fn a_bead_loses_what_the_law_says_in_each_of_two_passes() {
    let mut grid = welded_plate(0.25e-3, 0.5);
    let path = Path::along(&line(-0.012, 0.012, 0.0), FEED).unwrap();
    for (name, path) in [("bead, pass 1", path.clone()), ("bead, pass 2", path.reversed())] {
        let before = grid.clone();
        let record = pass(&mut grid, &path, &base());
        let (by_load, by_law) = volume_errors(name, &record);
        assert!(by_law < 3e-3);
        assert!(by_load < 3e-3);
        assert_no_growth(&before, &grid);
    }
    assert_distances(&grid);
}

#[test]
fn a_part_that_lies_askew_to_the_lattice_loses_the_same() {
    let turn = odd_turn();
    let half = DVec3::splat(0.022);
    let mut grid = BrickGrid::from_distance(-half, half, 0.25e-3, 3.0, |p| (turn.transpose() * p).length() - 0.022);
    let arc: Vec<CurvePoint> = (-20..=20)
        .map(|i| {
            let (sin, cos) = (0.02 * f64::from(i)).sin_cos();
            let normal = turn * DVec3::new(sin, 0.0, cos);
            CurvePoint { position: normal * 0.022, normal }
        })
        .collect();
    let record = pass(&mut grid, &Path::along(&arc, FEED).unwrap(), &base());
    let (by_load, by_law) = volume_errors("great circle on a ball, askew", &record);
    assert!(by_load < 3e-3 && by_law < 3e-3);
}

/// Asserts that no φ has fallen near the surface: material only recedes.
fn assert_no_growth(before: &BrickGrid, after: &BrickGrid) {
    for &brick in &before.bricks {
        for at in (0..512).map(|offset| sdf_bake::grid::voxel_at(brick, offset)) {
            let (old, new) = (before.phi_at(at), after.phi_at(at));
            assert!(old.abs() > before.voxel as f32 || new >= old, "φ fell from {old} to {new} at voxel {at}");
        }
    }
}

/// Asserts that φ is still a distance near the surface, away from edges.
fn assert_distances(grid: &BrickGrid) {
    let mut errors: Vec<f64> = Vec::new();
    for &brick in &grid.bricks {
        for offset in 0..512 {
            let at = sdf_bake::grid::voxel_at(brick, offset);
            if grid.phi_at(at).abs() < 1.2 * grid.voxel as f32 {
                let along = |axis: glam::IVec3| f64::from(grid.phi_at(at + axis) - grid.phi_at(at - axis));
                let gradient = DVec3::new(along(glam::IVec3::X), along(glam::IVec3::Y), along(glam::IVec3::Z));
                errors.push((gradient.length() / (2.0 * grid.voxel) - 1.0).abs());
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let median = errors[errors.len() / 2];
    let most = errors[errors.len() * 95 / 100];
    println!("| |∇φ| - 1 |: median {median:.1e}, 95 % below {most:.1e}");
    assert!(median < 0.01);
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let run = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let mut grid = welded_plate(0.5e-3, 0.3);
            let path = Path::along(&line(-0.003, 0.003, 0.0), FEED).unwrap();
            let record = pass(&mut grid, &path, &base());
            (grid, record)
        })
    };
    let one = run(1);
    for threads in [2, 4] {
        let more = run(threads);
        assert!(more.0 == one.0, "fields differ with {threads} threads");
        assert_eq!(more.1, one.1);
    }
}

#[test]
fn a_path_beside_the_part_is_in_the_air_and_says_so() {
    let mut grid = ball(0.5e-3, 0.01, DVec3::ZERO);
    let record = pass(&mut grid, &Path::along(&line(0.2, 0.21, 0.0), FEED).unwrap(), &base());
    assert_eq!(record.0.steps_in_air, record.0.steps);
    assert_eq!((record.0.impulse, record.1, record.0.force_rms_error), (0.0, 0.0, 0.0));
    assert!(record.0.log.iter().all(|row| row.force == 0.0));
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let path = Path::along(&line(0.0, 0.01, 0.0), FEED).unwrap();
    let mut grid = plate(0.5e-3, 0.0);
    let (defaults, model) = (PassSettings::default(), base());
    for (settings, wheel, name) in [
        (PassSettings { force_setpoint: f64::NAN, ..defaults }, WHEEL, "force setpoint [N]"),
        (defaults, Wheel { radius: 0.0, ..WHEEL }, "wheel radius [m]"),
    ] {
        let tool = Tool::from(wheel);
        let pass = Pass::first(&tool, &path, &settings, &model);
        match run_pass(&mut grid, pass, &mut fresh(&model), &mut |_| {}) {
            Err(PassError::BadSetting { name: found, .. }) => assert_eq!(found, name),
            other => panic!("{other:?}"),
        }
    }
    let mut thin = BrickGrid::from_distance(DVec3::splat(-0.01), DVec3::splat(0.01), 1e-3, 2.0, |p| p.z);
    let tool = Tool::from(WHEEL);
    let found = run_pass(&mut thin, Pass::first(&tool, &path, &defaults, &model), &mut fresh(&model), &mut |_| {});
    assert!(matches!(found, Err(PassError::ThinBand { .. })), "{found:?}");
    let narrow = Tool::from(Wheel { width: 0.9e-3, ..WHEEL });
    let found = run_pass(&mut grid, Pass::first(&narrow, &path, &defaults, &model), &mut fresh(&model), &mut |_| {});
    let error = found.unwrap_err().to_string();
    assert_eq!(error, "voxels of 0.5 mm are too coarse for a tool of 0.9 mm: at most 0.45 mm is accepted");
}
