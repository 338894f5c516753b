//! Measured maps as workpieces, and the measuring instrument, on campaigns made elsewhere.

use sdf_bake::heights::SlabOptions;
use sdf_bake::{BrickGrid, HeightMap};
use sim::Profilometer;
use trials::measure::{DegreesOfFreedom, NoiseFloor, despiked, noise_floor, register, residual, untouched};
use trials::trial::{Campaign, PassScan, Trial};

use crate::shared::campaigns;

/// Least clearance of an untouched pixel [m].
const CLEARANCE: f64 = 0.1e-3;

fn floor_of(trial: &Trial) -> NoiseFloor {
    noise_floor(&despiked(&trial.scans.before).0, &despiked(&trial.scans.repeats[0]).0).expect("two scans")
}

#[test]
fn a_measured_map_returns_through_bricks_and_instrument() {
    let Some(place) = campaigns() else { return };
    let trial = &Campaign::read(&place.join("open-a")).unwrap().trials[0];
    let before = &trial.scans.before;
    let options = SlabOptions { margin: trial.tool.half_width(), ..SlabOptions::with_voxel(before.pixels.pitch) };
    let (grid, report) = BrickGrid::from_heights(before, &options).unwrap();
    let seen = Profilometer::sharp(before.pixels).heights(&grid);
    assert_eq!(seen.missing(), 0);
    let rest = residual(&seen, before, |at| !report.spikes.contains(&at));
    println!("{} spikes, {} missing, returned within {:.1e} m rms", report.spikes.len(), report.missing, rest.rms);
    assert!(rest.rms < 0.3e-6, "{rest:?}");
    // The laboratory adds spikes; no spike at all, or one in a hundred pixels, would be implausible.
    assert!((1..before.pixels.len() / 100).contains(&report.spikes.len()));
}

#[test]
fn repeated_scans_give_the_noise_floor_and_untouched_pixels_the_registration() {
    let Some(place) = campaigns() else { return };
    for trial in &Campaign::read(&place.join("open-a")).unwrap().trials {
        let floor = floor_of(trial);
        println!(
            "{}: shift {:.1} µm, noise {:.2} µm ({:.2} white, {:.2} shared over {:.1} mm, {:.2} rms)",
            trial.name,
            floor.registration.shift.length() * 1e6,
            floor.sigma * 1e6,
            floor.white * 1e6,
            floor.correlated * 1e6,
            floor.correlation_length * 1e3,
            floor.rms * 1e6
        );
        assert!((0.5e-6..5e-6).contains(&floor.sigma), "{floor:?}");
        let before = despiked(&trial.scans.before).0;
        let mut free = vec![true; before.heights.len()];
        for pass in &trial.passes {
            let PassScan::Heights(after) = &pass.scan else { panic!("a grinding trial") };
            let left = untouched(&before, &pass.tool_path(&trial.tool), &trial.tool, CLEARANCE);
            free.iter_mut().zip(&left).for_each(|(free, left)| *free &= left);
            let after = despiked(after).0;
            let laid = register(&after, &before, DegreesOfFreedom::Plane, |at| free[at]).unwrap();
            let rest = residual(&laid.levelled(&after), &before, |at| free[at]);
            let removed = volume(&before, &laid.levelled(&after), &free);
            println!(
                "  {} untouched pixels, offset {:.2} µm, tilt {:.2} mrad, left {:.2} µm rms, {removed:.1} mm³ removed",
                rest.pixels,
                laid.offset * 1e6,
                laid.tilt.length() * 1e3,
                rest.rms * 1e6
            );
            assert!(rest.pixels > 5000 && rest.pixels < before.heights.len() * 9 / 10, "{rest:?}");
            assert!(laid.sigma < 1.3 * 2f64.sqrt() * floor.sigma, "{} for {}", laid.sigma, floor.sigma);
        }
    }
}

/// Returns the volume between two maps where the tool was [mm³].
fn volume(before: &HeightMap, after: &HeightMap, free: &[bool]) -> f64 {
    let lost = residual(before, after, |at| !free[at]);
    lost.mean * lost.pixels as f64 * before.pixels.pitch.powi(2) * 1e9
}
