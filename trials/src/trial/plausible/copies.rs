//! Copied scans: two scans with the same heights are one scan, because noise never repeats.

use std::path::Path;

use sdf_bake::HeightMap;

use super::super::error::{Place, TrialError};
use super::super::manifest::TRIAL_FILE;
use super::super::{ExposureMask, Trial};
use super::{LEAST_PIXELS, Names, ground};

/// Difference of two heights that rounding in files produces [m]: two roundings to a nanometre.
const ROUNDING: f64 = 2e-9;

/// Coarsest rounding step of heights that is tested for [m].
const COARSEST: f64 = 1e-4;

/// Refuses scans that are copies of each other.
pub(super) fn check(trial: &Trial, names: &Names) -> Result<(), TrialError> {
    let before = (!trial.scans.is_nominal).then_some((names.before, &trial.scans.before));
    let repeats = names.repeats.iter().copied().zip(&trial.scans.repeats);
    let after = trial.passes.iter().zip(&names.scans).filter_map(|(pass, name)| Some((*name, ground(pass)?)));
    let maps: Vec<(&Path, &HeightMap)> = before.into_iter().chain(repeats).chain(after).collect();
    refuse_pair(trial, &maps, are_copies, "heights")?;
    let masks = trial.passes.iter().zip(&names.scans).filter_map(|(pass, name)| Some((*name, pass.scan.mask()?)));
    refuse_pair(trial, &masks.collect::<Vec<_>>(), are_same, "pixels")
}

/// Refuses the first pair of identical scans.
fn refuse_pair<T>(
    trial: &Trial,
    scans: &[(&Path, &T)],
    same: impl Fn(&T, &T) -> bool,
    what: &str,
) -> Result<(), TrialError> {
    for (k, (name, scan)) in scans.iter().enumerate() {
        if let Some((first, _)) = scans[..k].iter().find(|(_, first)| same(first, scan)) {
            if first == name {
                let found = format!("{} is named as two scans", name.display());
                return Err(Place::file(&trial.folder.join(TRIAL_FILE))
                    .bad(found, "a file of its own is expected for each scan"));
            }
            return Err(Place::file(&trial.folder.join(name)).bad(
                format!("it holds the same {what} as {}, pixel by pixel", first.display()),
                "a scan of its own is expected, with noise of its own: is one a copy of the other?",
            ));
        }
    }
    Ok(())
}

/// True if two maps differ only by a common offset and the rounding of the coarser one. Independent noise exceeds half
/// a step somewhere among hundreds of pixels.
fn are_copies(a: &HeightMap, b: &HeightMap) -> bool {
    let differences = || a.heights.iter().zip(&b.heights).map(|(a, b)| a - b).filter(|d| d.is_finite());
    let spread = || {
        let ends = differences().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
        ends.1 - ends.0
    };
    // The first pixels distinguish most scans.
    let (low, high) = differences()
        .take(LEAST_PIXELS)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    if high - low > COARSEST || differences().take(LEAST_PIXELS).count() < LEAST_PIXELS {
        return false;
    }
    let (fine, coarse) = (step(a).min(step(b)), step(a).max(step(b)));
    let rounding = if coarse > 1.5 * fine { coarse } else { 0.0 };
    spread() <= rounding + ROUNDING
}

/// Decimal rounding step of a map [m]: all heights are multiples of it.
fn step(map: &HeightMap) -> f64 {
    let known = || map.heights.iter().filter(|height| height.is_finite());
    let fits =
        |step: f64| known().all(|height| (height / step - (height / step).round()).abs() * step < 0.5 * ROUNDING);
    let steps = std::iter::successors(Some(COARSEST), |step| Some(0.1 * step)).take_while(|step| *step > ROUNDING);
    steps.into_iter().find(|step| fits(*step)).unwrap_or(0.0)
}

/// True if two masks are equal and show both coating and substrate: masks of one kind alone may well repeat.
fn are_same(a: &ExposureMask, b: &ExposureMask) -> bool {
    a.exposed == b.exposed && a.exposed.contains(&Some(true)) && a.exposed.contains(&Some(false))
}
