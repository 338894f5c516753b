//! Sequence of a ground workpiece's scans: detects swapped and displaced scans, and removal away from the tool's path.

use glam::DVec2;
use sdf_bake::HeightMap;

use super::super::Trial;
use super::super::error::{Place, TrialError};
use super::{LEAST_PIXELS, Names, Surfaces, odds, touching};
use crate::measure::{DegreesOfFreedom, centre_and_sigma, register};

/// Rise that exceeds noise [robust standard deviations of the untouched surface], and its minimum size [m].
const RISE: (f64, f64) = (4.0, 2e-6);
/// Share of the touched pixels that rose, and their ratio to those that sank, above which the rise is significant.
const ROSE: (f64, f64) = (0.1, 4.0);
/// Range of tested displacements [pixels], and the share of the difference that a true displacement leaves.
const REACH: i64 = 8;
const LEAVES: f64 = 0.5;
/// Number of untouched pixels that are compared.
const COMPARED: usize = 4000;
/// Tilt of a scan relative to the previous one for a note [1].
const TILT: f64 = 5e-3;
/// Shares of the ground area beside the tool's path: for a note, and for refusal. Half of it lies beside a path of
/// equal length and width that is off by half of its width or length; errors of clock and path cause a few hundredths.
const BESIDE: (f64, f64) = (0.1, 0.5);

/// Refuses scans that are swapped or displaced, and removal beside the path. Returns notes on strong tilts, which
/// registration corrects, and on passes without removal.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<Vec<String>, TrialError> {
    let mut notes = Vec::new();
    for (pass, (now, name)) in surfaces.after.iter().zip(&names.scans).enumerate() {
        let Some(now) = now else { continue };
        let (earlier, since) = surfaces.earlier(pass);
        let place = Place::file(&trial.folder.join(name));
        let found = follow(now, earlier, &surfaces.free_in(since), place)?;
        let found = found.into_iter().chain(across(trial, surfaces, pass));
        notes.extend(found.map(|note| format!("{}: {note}", name.display())));
    }
    Ok(notes)
}

/// Checks that a scan can follow another; returns notes on oddities.
fn follow(now: &HeightMap, earlier: &HeightMap, free: &[bool], place: Place) -> Result<Vec<String>, TrialError> {
    let Ok(found) = register(now, earlier, DegreesOfFreedom::All, |at| free[at]) else {
        return Ok(Vec::new());
    };
    let touched: Vec<usize> = (0..free.len()).filter(|&at| !free[at]).collect();
    if found.pixels < LEAST_PIXELS || touched.len() < LEAST_PIXELS {
        return Ok(Vec::new());
    }
    let levelled = found.levelled(now);
    if let Some([dx, dy]) = displaced(&levelled, earlier, free) {
        let pitch = now.pixels.pitch * 1e3;
        return Err(place.bad(
            format!(
                "where no tool came, the surface lies {:.2} mm along x and {:.2} mm along y beside the scan before",
                dx as f64 * pitch,
                dy as f64 * pitch
            ),
            "scans of the workpiece in one place are expected: cut or move the map by as much",
        ));
    }
    let left = found.left(now, earlier);
    let clear = (RISE.0 * found.sigma).max(RISE.1);
    let rises: Vec<f64> = touched.iter().map(|&at| left[at]).filter(|rise| *rise > clear).collect();
    let sunk = touched.iter().filter(|&&at| left[at] < -clear).count() as f64;
    let rose = rises.len() as f64;
    if rose > ROSE.0 * touched.len() as f64 && rose > ROSE.1 * sunk {
        let (height, _) = centre_and_sigma(&rises).unwrap_or_default();
        return Err(place.bad(
            format!("under the tool the surface lies {:.1} µm higher than before the pass", height * 1e6),
            "a scan after the pass is expected: this one and the scan before it look swapped",
        ));
    }
    let tilt = found.tilt.length();
    let tilted = (tilt > TILT)
        .then(|| format!("tilted by {:.1} mrad against the scan before; registration takes it out", tilt * 1e3));
    let cut = cut(&HeightMap { heights: left, ..now.clone() }, clear);
    Ok(tilted.into_iter().chain(beside(&cut, now, free, place)?).collect())
}

/// Pixels that a pass ground, with the passes before it that were not scanned; `None` if the scans cannot be
/// registered.
fn ground_by(surfaces: &Surfaces, pass: usize) -> Option<Vec<usize>> {
    let now = surfaces.after[pass].as_ref()?;
    let (earlier, since) = surfaces.earlier(pass);
    let free = surfaces.free_in(since);
    let found = register(now, earlier, DegreesOfFreedom::All, |at| free[at]).ok()?;
    let left = HeightMap { heights: found.left(now, earlier), ..now.clone() };
    Some(cut(&left, (RISE.0 * found.sigma).max(RISE.1)))
}

/// True if the scan after a pass lies below the one before it anywhere.
pub(super) fn shows_removal(surfaces: &Surfaces, pass: usize) -> bool {
    ground_by(surfaces, pass).is_some_and(|cut| cut.len() >= LEAST_PIXELS)
}

/// Distance between the middle of a wheel's ground area and its path, along its axis. A wide wheel that is off by a few
/// millimetres grinds the same shape, so only this test shows the error.
fn across(trial: &Trial, surfaces: &Surfaces, pass: usize) -> Option<String> {
    let axis = trial.tool.axis?;
    let cut = ground_by(surfaces, pass).filter(|cut| cut.len() >= LEAST_PIXELS)?;
    let pixels = surfaces.before.pixels;
    let ground =
        cut.iter().map(|&at| pixels.position(at % pixels.nx, at / pixels.nx)).sum::<DVec2>() / cut.len() as f64;
    let poses = touching(&surfaces.paths[pass]);
    let path = poses.iter().map(|pose| pose.centre.truncate()).sum::<DVec2>() / poses.len().max(1) as f64;
    let beside = (ground - path).dot(axis.truncate());
    (!poses.is_empty() && beside.abs() > odds::displaced_by_effects(0.0)).then(|| {
        format!(
            "the middle of the ground area lies {:.1} mm beside the path, along the wheel's axis: is origin_mm off, or the log?",
            1e3 * beside
        )
    })
}

/// Pixels that sank together with all their neighbours along x and y; noise produces none.
fn cut(left: &HeightMap, clear: f64) -> Vec<usize> {
    let (nx, ny) = (left.pixels.nx, left.pixels.ny);
    let sank = |at: usize| left.heights[at] < -clear;
    let inside = |at: &usize| (1..nx - 1).contains(&(at % nx)) && (1..ny - 1).contains(&(at / nx));
    let all = (0..left.heights.len()).filter(inside);
    all.filter(|&at| [at, at - 1, at + 1, at - nx, at + nx].into_iter().all(sank)).collect()
}

/// Refuses a ground area beside the tool's path; returns a note if a part of it lies beside, and for a pass that ground
/// nothing.
fn beside(cut: &[usize], map: &HeightMap, free: &[bool], place: Place) -> Result<Option<String>, TrialError> {
    if cut.len() < LEAST_PIXELS {
        return Ok(cut.is_empty().then(|| "the pass removed nothing that rises above the noise".to_owned()));
    }
    let outside: Vec<usize> = cut.iter().copied().filter(|&at| free[at]).collect();
    let share = outside.len() as f64 / cut.len() as f64;
    if share <= BESIDE.0 || outside.len() < LEAST_PIXELS {
        return Ok(None);
    }
    let pixels = map.pixels;
    let middle = |of: &[usize]| {
        of.iter().map(|&at| pixels.position(at % pixels.nx, at / pixels.nx)).sum::<DVec2>() / of.len().max(1) as f64
    };
    let touched: Vec<usize> = (0..free.len()).filter(|&at| !free[at]).collect();
    let away = 1e3 * (middle(cut) - middle(&touched));
    let found = format!(
        "{:.0} % of the ground area lies where the tool never came; its middle is {:.2} mm along x and {:.2} mm along y \
         from that of the path",
        100.0 * share,
        away.x,
        away.y
    );
    if share <= BESIDE.1 {
        return Ok(Some(found));
    }
    Err(place.bad(
        found,
        "removal under the tool is expected: is origin_mm or pitch_mm off, or are the scans or the log mirrored?",
    ))
}

/// Displacement of a scan relative to another along x and y on the untouched surface [pixels], if it is certain.
fn displaced(now: &HeightMap, earlier: &HeightMap, free: &[bool]) -> Option<[i64; 2]> {
    let (nx, ny) = (now.pixels.nx as i64, now.pixels.ny as i64);
    let inside = |at: usize| {
        let (i, j) = (at as i64 % nx, at as i64 / nx);
        (REACH..nx - REACH).contains(&i) && (REACH..ny - REACH).contains(&j)
    };
    let all: Vec<usize> = (0..free.len()).filter(|&at| free[at] && inside(at)).collect();
    let kept: Vec<usize> = all.iter().copied().step_by(all.len() / COMPARED + 1).collect();
    let spread = |[dx, dy]: [i64; 2]| {
        let difference = |&at: &usize| now.heights[(at as i64 + dy * nx + dx) as usize] - earlier.heights[at];
        let known: Vec<f64> = kept.iter().map(difference).filter(|d| d.is_finite()).collect();
        (known.len() >= LEAST_PIXELS.min(kept.len()))
            .then(|| centre_and_sigma(&known))
            .flatten()
            .map(|(_, sigma)| sigma)
    };
    let ways = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| [dx, dy]));
    let spreads = ways.filter_map(|way| Some((way, spread(way)?)));
    let (best, least) = spreads.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let here = spread([0, 0])?;
    (best != [0, 0] && least < LEAVES * here && here > RISE.1).then_some(best)
}
