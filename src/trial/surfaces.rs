//! Whether the scans of a ground workpiece can follow each other: swapped or displaced ones are found here and named.

use std::path::Path;

use sdf_bake::HeightMap;

use super::error::{Place, TrialError};
use super::{PassScan, Trial};
use crate::measure::{Freedom, centre_and_sigma, despiked, register, untouched};

/// Distance to the tool that counts as touched [m].
const CLEARANCE: f64 = 0.1e-3;
/// Fewest pixels, touched and left alone, that a judgement needs.
const LEAST_PIXELS: usize = 100;
/// Rise that is no noise [robust standard deviations of the untouched surface], and its least size [m].
const RISE: (f64, f64) = (4.0, 2e-6);
/// Share of the touched pixels that rose, and how many times those that sank, which is no accident.
const ROSE: (f64, f64) = (0.1, 4.0);
/// Displacements that are looked for [pixels], and the share of the difference that a true one leaves.
const REACH: i64 = 8;
const LEAVES: f64 = 0.5;
/// Untouched pixels that are compared for that.
const COMPARED: usize = 4000;
/// Tilt of a scan against the one before that is worth a word [1].
const TILT: f64 = 5e-3;

/// Refuses scans that are swapped or displaced; notes strong tilts, which registration takes out.
///
/// - `scans`: name of each pass's scan
pub(super) fn check(trial: &mut Trial, scans: &[&Path]) -> Result<(), TrialError> {
    let mut notes = Vec::new();
    let mut earlier = despiked(&trial.scans.before).0;
    for (pass, name) in trial.passes.iter().zip(scans) {
        let PassScan::Heights(scan) = &pass.scan else { return Ok(()) };
        let now = despiked(scan).0;
        let free = untouched(&trial.scans.before, &pass.tool_path(&trial.tool), &trial.tool, CLEARANCE);
        let place = Place::file(&trial.folder.join(name));
        notes.extend(follow(&now, &earlier, &free, place)?.map(|note| format!("{}: {note}", name.display())));
        earlier = now;
    }
    trial.notes.extend(notes);
    Ok(())
}

/// Whether a scan can follow another; a note where it is tilted.
fn follow(now: &HeightMap, earlier: &HeightMap, free: &[bool], place: Place) -> Result<Option<String>, TrialError> {
    let Ok(found) = register(now, earlier, Freedom::PlaneAndShift, |at| free[at]) else { return Ok(None) };
    let touched: Vec<usize> = (0..free.len()).filter(|&at| !free[at]).collect();
    if found.pixels < LEAST_PIXELS || touched.len() < LEAST_PIXELS {
        return Ok(None);
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
    Ok((tilt > TILT)
        .then(|| format!("tilted by {:.1} mrad against the scan before; registration takes it out", tilt * 1e3)))
}

/// By how many pixels along x and y a scan lies beside another on the untouched surface, where that is beyond doubt.
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
