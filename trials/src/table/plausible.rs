//! Plausibility of a table's quantities in their units.

use std::path::Path;

use super::columns::{Columns, Load, Motion};
use super::{Removed, Row};
use crate::measure::median;
use crate::trial::{Place, TrialError};

/// Plausible range of each quantity's median: key, minimum and maximum [SI].
const PLAUSIBLE: [(&str, f64, f64); 5] = [
    ("force", 1e-2, 1e5),
    ("pressure", 1e1, 1e9),
    ("speed", 1e-3, 300.0),
    ("spindle_rpm", 1e-2, 2e4),
    ("duration", 1e-3, 1e7),
];
/// The same for the mean removal rate, as a depth [m/s] and as a volume [m³/s].
const PLAUSIBLE_REMOVAL: [(Removed, f64, f64); 2] = [(Removed::Depth, 1e-13, 1e-2), (Removed::Volume, 1e-17, 1e-4)];

/// Refuses quantities that are probably in another unit.
///
/// - `radius`: of the tool [m], if the table gives it
pub(super) fn check(columns: &Columns, rows: &[Row], radius: Option<f64>, file: &Path) -> Result<(), TrialError> {
    let middle = |value: &dyn Fn(&Row) -> Option<f64>| median(rows.iter().filter_map(value).map(f64::abs).collect());
    let load = match columns.load.0 {
        Load::Force => middle(&|row| row.force),
        Load::Pressure => middle(&|row| row.pressure),
    };
    let speed = middle(&|row| row.speed);
    let motion = columns.motion.as_ref().map(|(motion, numbers)| match motion {
        Motion::Speed => (numbers, speed),
        Motion::Spindle => (numbers, speed.zip(radius).map(|(speed, radius)| speed / radius)),
    });
    let duration = columns.duration.as_ref().map(|numbers| (numbers, middle(&|row| row.duration)));
    let settings = std::iter::once((&columns.load.1, load)).chain(motion).chain(duration);
    let ranged = settings.map(|(numbers, median)| {
        let range = PLAUSIBLE.iter().find(|(key, ..)| *key == numbers.key);
        (numbers, median, range.map(|(_, low, high)| (*low, *high)))
    });
    let removal = PLAUSIBLE_REMOVAL.iter().find(|(what, ..)| *what == columns.removal.0);
    let removed = (&columns.removed, middle(&|row| row.removal_rate), removal.map(|(_, low, high)| (*low, *high)));
    for (numbers, median, range) in ranged.chain([removed]) {
        let (Some(median), Some((low, high))) = (median, range) else { continue };
        if !(low..=high).contains(&median) {
            let found = format!("the median of {} is {median:.3e} in SI units", numbers.name);
            let accepted = format!("{low:.0e} to {high:.0e} is expected; is the unit right?");
            return Err(Place::cell(file, 1, numbers.at + 1).bad(found, accepted));
        }
    }
    Ok(())
}
