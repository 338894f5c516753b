//! The repeated scan must show the surface before the first pass: it may differ from the first scan only by noise.

use std::path::Path;

use super::super::Trial;
use super::super::error::{Place, TrialError};
use super::{LEAST_PIXELS, Names, Surfaces};
use crate::measure::{DegreesOfFreedom, register};

/// Share of the first pass's removal in a repeated scan above which it was taken after the pass: midway between a scan
/// before it (0) and one after it (1).
const REMOVED: f64 = 0.5;
/// Ratio of the removal to the difference of the repeated scan on the untouched surface, above which shares are
/// meaningful: the noise common to the two differences then causes a share of 1 / (2 · 3²), about 0.06.
const CLEAR: f64 = 3.0;
/// Ratio of the difference of the repeated scan to that of a scan after a pass, on the untouched surface, above which
/// it shows another surface: noise on flanks and on plates differs by two to three, another surface by a hundred and
/// more.
const OTHER: f64 = 10.0;
/// Minimum of that difference [m].
const LEAST: f64 = 2e-6;

/// Differences over pixels, after offset and tilt.
struct Differences<'a> {
    /// Repeated scan minus the first one [m].
    repeat: Vec<f64>,
    /// First scan after a pass minus the first one [m].
    pass: Vec<f64>,
    /// Name of the first scan after a pass.
    name: &'a Path,
}

/// Refuses repeated scans that show another surface than the first scan; returns notes on noise that hides the removal.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<Vec<String>, TrialError> {
    let mut notes = Vec::new();
    let mut scanned = surfaces.after.iter().enumerate().filter_map(|(pass, map)| Some((pass, map.as_ref()?)));
    let Some((first, after)) = scanned.next() else { return Ok(notes) };
    let (before, free) = (&surfaces.before, surfaces.free_until(first));
    let Ok(found) = register(after, before, DegreesOfFreedom::All, |at| free[at]) else { return Ok(notes) };
    let pass = found.left(after, before);
    for (name, map) in names.repeats.iter().zip(&surfaces.repeats) {
        let Ok(found) = register(map, before, DegreesOfFreedom::All, |at| free[at]) else { continue };
        let differences = Differences { repeat: found.left(map, before), pass: pass.clone(), name: names.scans[first] };
        let place = Place::file(&trial.folder.join(name));
        differences.judge(&free, place, names)?;
        notes.extend(differences.noise_note(&free).map(|note| format!("{}: {note}", name.display())));
    }
    Ok(notes)
}

impl Differences<'_> {
    fn judge(&self, free: &[bool], place: Place, names: &Names) -> Result<(), TrialError> {
        let (before, after) = (names.before.display(), self.name.display());
        let accepted = format!("a second scan of the surface of {before} is expected, made before the first pass");
        let quiet = self.rms(&self.repeat, |at| free[at]);
        let touched = |at: usize| !free[at] && self.pass[at].is_finite() && self.repeat[at].is_finite();
        let removal = self.rms(&self.pass, touched);
        if removal > CLEAR * quiet && (0..free.len()).filter(|&at| touched(at)).count() >= LEAST_PIXELS {
            let sum =
                |of: &[f64]| (0..free.len()).filter(|&at| touched(at)).map(|at| of[at] * self.pass[at]).sum::<f64>();
            let share = sum(&self.repeat) / sum(&self.pass);
            if share.abs() > REMOVED {
                return Err(place.bad(
                    format!(
                        "under the tool it lies {:.1} µm {} {before}, {:.0} % of what {after} shows: it was made after a pass",
                        1e6 * share.abs() * removal,
                        if share > 0.0 { "below" } else { "above" },
                        100.0 * share
                    ),
                    accepted,
                ));
            }
        }
        let (differs, noise) = (self.mean(&self.repeat, |_| true), self.mean(&self.pass, |at| free[at]));
        if noise > 0.0 && differs > (OTHER * noise).max(LEAST) {
            return Err(place.bad(
                format!(
                    "it differs from {before} by {:.1} µm in the mean, where {after} differs by {:.1} µm beside the tool's \
                     path: it shows another surface",
                    1e6 * differs,
                    1e6 * noise
                ),
                accepted,
            ));
        }
        Ok(())
    }

    /// A note if the noise of a scan is as large as the removal of the first pass.
    fn noise_note(&self, free: &[bool]) -> Option<String> {
        let noise = self.rms(&self.repeat, |_| true) / 2f64.sqrt();
        let removal = self.rms(&self.pass, |at| !free[at]);
        (removal > 0.0 && noise > removal).then(|| {
            let (noise, removal) = (1e6 * noise, 1e6 * removal);
            format!("one scan's noise of {noise:.1} µm hides the {removal:.1} µm that the first pass changed")
        })
    }

    fn rms(&self, of: &[f64], takes: impl Fn(usize) -> bool) -> f64 {
        let (sum, count) = Self::sum(of, takes, |d| d * d);
        (sum / f64::max(count, 1.0)).sqrt()
    }

    /// Mean magnitude.
    fn mean(&self, of: &[f64], takes: impl Fn(usize) -> bool) -> f64 {
        let (sum, count) = Self::sum(of, takes, f64::abs);
        sum / f64::max(count, 1.0)
    }

    fn sum(of: &[f64], takes: impl Fn(usize) -> bool, size: impl Fn(f64) -> f64) -> (f64, f64) {
        let known = of.iter().enumerate().filter(|(at, d)| d.is_finite() && takes(*at));
        known.fold((0.0, 0.0), |(sum, count), (_, d)| (sum + size(*d), count + 1.0))
    }
}
