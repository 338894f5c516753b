//! Hard front ends: each has the effect of its name and no other, and the files can be read.

use effects::Process;
use glam::DVec2;
use robot::LogRow;
use sdf_bake::PixelGrid;
use trials::measure::{DegreesOfFreedom, register};
use trials::trial::{Campaign, Trial};
use virtual_lab::write::write;
use virtual_lab::{FrontEnd, Hidden, Made};

use crate::made::{clean, experiment, heights};

fn made(front: FrontEnd, hidden: &[Hidden]) -> Made {
    experiment(Process::Grinding, hidden).behind(front).make().unwrap()
}

fn rows(made: &Made) -> &[LogRow] {
    &made.trials[0].passes[0].log.rows
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value * value, count + 1.0));
    f64::sqrt(sum / f64::max(count, 1.0))
}

#[test]
fn a_frame_moves_the_log_and_no_scan() {
    let off = made(FrontEnd::Frame, &[]);
    assert_eq!(format!("{:?}", off.trials[0].passes[1].scan), format!("{:?}", clean().trials[0].passes[1].scan));
    let away = |(a, b): (&LogRow, &LogRow)| (a.position - b.position).truncate();
    let moved: Vec<DVec2> = rows(&off).iter().zip(rows(clean())).map(away).collect();
    let mean = moved.iter().sum::<DVec2>() / moved.len() as f64;
    let bend = moved.iter().map(|moved| moved.distance(mean)).fold(0.0, f64::max);
    // 2 mrad over half of the bead's 30 mm is 27 µm at its ends.
    assert!((mean.length() - 0.5e-3).abs() < 30e-6 && (10e-6..45e-6).contains(&bend), "{mean}, {bend}");
    assert!(rows(&off).iter().zip(rows(clean())).all(|(a, b)| (a.force, a.position.z) == (b.force, b.position.z)));
}

#[test]
fn a_late_clock_delays_places_and_no_force() {
    let late = made(FrontEnd::Clock, &[]);
    let pairs = || rows(&late).iter().zip(rows(clean()));
    // The force falls when the tool leaves, whatever the logged position is.
    assert!(pairs().all(|(a, b)| (a.time, a.force) == (b.time, b.force)));
    // Eight rows of 10 ms; jitter and rounding are a few micrometres.
    let off = rows(&late)[8..].iter().zip(rows(clean())).map(|(a, b)| (a.position - b.position).length());
    assert!(off.fold(0.0, f64::max) < 20e-6);
    assert!(rms(pairs().map(|(a, b)| a.position.x - b.position.x)) > 0.6e-3, "10 mm/s for 80 ms");
}

#[test]
fn a_ripple_swings_the_true_force_and_the_log_shows_it() {
    let rippling = made(FrontEnd::Ripple, &[]);
    let trial = &rippling.trials[0];
    for pass in &trial.passes {
        let contact = pass.tool_path(&trial.tool).contact.unwrap();
        let inside = |row: &&LogRow| row.time > contact.start + 0.3 && row.time < contact.end - 0.1;
        let forces: Vec<f64> = pass.log.rows.iter().filter(inside).map(|row| row.force).collect();
        let mean = forces.iter().sum::<f64>() / forces.len() as f64;
        let swing = rms(forces.iter().map(|force| force / mean - 1.0));
        assert!((mean / pass.force_setpoint - 1.0).abs() < 0.05 && (0.07..0.13).contains(&swing), "{mean}, {swing}");
    }
    let effect = &rippling.answer.effects[0];
    assert!(effect.name == "force-ripple" && !effect.in_library, "the answer names it");
    let change = heights(&rippling.trials[0], 1).heights.iter().zip(&heights(&clean().trials[0], 1).heights);
    assert!(rms(change.map(|(a, b)| a - b).filter(|d| d.is_finite() && d.abs() < 50e-6)) > 1e-6, "and the surface");
}

#[test]
fn marks_lie_where_the_tool_was_and_along_its_way() {
    let marked = made(FrontEnd::Texture, &[]);
    let (with, without) = (heights(&marked.trials[0], 1), heights(&clean().trials[0], 1));
    let before = &clean().trials[0].scans.before;
    let PixelGrid { nx, .. } = with.pixels;
    // Both scans have the same noise; heights are rounded to 1 µm.
    let mark = |k: usize| with.heights[k] - without.heights[k];
    let depth = |k: &usize| before.heights[*k] - without.heights[*k];
    let known = (0..with.heights.len() - nx).filter(|k| mark(*k).is_finite() && mark(k + nx).is_finite());
    let (ground, away): (Vec<usize>, Vec<usize>) =
        known.filter(|k| depth(k) > 60e-6 || depth(k).abs() < 20e-6).partition(|k| depth(k) > 60e-6);
    let [here, there] = [&ground, &away].map(|of| rms(of.iter().map(|&k| mark(k))));
    println!("{:.2} µm where it was ground, {:.2} µm elsewhere", here * 1e6, there * 1e6);
    assert!(ground.len() > 500 && away.len() > 500 && (3e-6..5e-6).contains(&here));
    // A position that seems untouched may lie on the border of the track: scans differ by 10 µm in height.
    assert!(there < 0.4 * here, "{there}");
    let like = |step: usize| {
        ground.iter().map(|&k| mark(k) * mark(k + step)).filter(|product| product.is_finite()).sum::<f64>()
    };
    // Pixels are 0.3 mm apart: exp(−(0.3 / 4)²) = 0.99 along the path, exp(−(0.3 / 0.4)²) = 0.57 across.
    let [along, across] = [1, nx].map(|step| like(step) / like(0));
    assert!(along > 0.9 && (0.4..0.7).contains(&across), "{along}, {across}");
}

#[test]
fn clamped_parts_lie_turned_and_registration_finds_the_turn() {
    let clamped = made(FrontEnd::Clamped, &[]);
    let mut turns = Vec::new();
    for (trial, straight) in clamped.trials.iter().zip(&clean().trials) {
        for pass in 0..trial.passes.len() {
            let (scan, reference) = (heights(trial, pass), heights(straight, pass));
            let plane = register(scan, reference, DegreesOfFreedom::Plane, |_| true).unwrap();
            let found = register(scan, reference, DegreesOfFreedom::All, |_| true).unwrap();
            println!("turn {:.2} mrad, {:.2} µm for {:.2}", 1e3 * found.turn, 1e6 * found.sigma, 1e6 * plane.sigma);
            assert!(found.sigma < 0.9 * plane.sigma, "{found:?}, {plane:?}");
            turns.push(found.turn);
        }
    }
    let size = rms(turns.iter().copied());
    assert!((0.8e-3..3.5e-3).contains(&size), "{size}");
}

#[test]
fn a_worn_tool_has_a_past_only_for_what_it_remembers() {
    let volume = |made: &Made| made.answer.trials["trial-1"].removed_by_law_mm3[0];
    let dulling = [Hidden::effect("grit-dulling")];
    let [fresh, worn] = [FrontEnd::Clean, FrontEnd::Worn].map(|front| volume(&made(front, &dulling)));
    assert!(worn < 0.85 * fresh, "{worn} of {fresh} mm³");
    let nothing = made(FrontEnd::Worn, &[]);
    assert_eq!(volume(&nothing), volume(clean()));
    assert!(nothing.trials[0].fresh, "the trial calls its tool fresh");
}

#[test]
fn a_reader_refuses_none_of_them() {
    for front in FrontEnd::ALL {
        let experiment = experiment(Process::Grinding, &[]).behind(front);
        let made = experiment.make().unwrap();
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("campaign");
        write(&made, &experiment, &place, None, false).unwrap();
        let read = Campaign::read(&place).unwrap_or_else(|error| panic!("{front:?}: {error}"));
        let notes: Vec<&String> = read.trials.iter().flat_map(|trial: &Trial| &trial.notes).collect();
        println!("{front:?}: {notes:?}");
    }
}
