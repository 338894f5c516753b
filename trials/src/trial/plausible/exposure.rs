//! Consistency of exposure masks with the pad's path and with each other: the exposed area lies where the pad stayed
//! long, and stays exposed.
//!
//! The share of exposed pixels increases with the time under the pad. The likelihood under the best monotonic curve
//! (pool adjacent violators) is computed for the masks as read, and for alternative readings: a mirrored, displaced or
//! inverted mask, or another radius. Neighbouring pixels are exposed together, so all pixels within half a radius count
//! as one.

use std::fmt;

use glam::DVec2;
use rayon::prelude::*;
use sdf_bake::PixelGrid;

use super::super::error::{Place, TrialError};
use super::super::manifest::TRIAL_FILE;
use super::super::poses::{ToolPath, ToolPose};
use super::super::{ExposureMask, Trial};
use super::{Names, Surfaces, odds};
use robot::{Pad, Tool};

/// Side of the blocks of pixels that count as one, in radii of the pad.
const SQUARE: f64 = 0.5;
/// Number of quantisation levels of the time under the pad.
const LEVELS: usize = 24;
/// Spacing to which a path is thinned, as a share of the pad's radius.
const THIN: f64 = 0.1;
/// Displacements that are tested, in radii of the pad.
const WAYS: [f64; 4] = [0.5, 1.0, 1.5, 2.0];

/// Alternative reading of a mask.
#[derive(Clone, Copy, Debug, PartialEq)]
enum AlternativeReading {
    MirroredX,
    MirroredY,
    HalfTurn,
    Inverted,
    Displaced(DVec2),
    Radius(f64),
}

/// Positions of the pad, and their durations.
struct DwellPositions<'a> {
    poses: Vec<(&'a ToolPose, f64)>,
    radius: f64,
}

/// Refuses masks that contradict the pad's path or each other.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<Vec<String>, TrialError> {
    let Tool::Pad(Pad { radius }) = trial.tool.shape else { return Ok(Vec::new()) };
    let masks = trial.passes.iter().enumerate().filter(|(_, pass)| !pass.scan.is_missing());
    let masks: Vec<(usize, &ExposureMask)> = masks.filter_map(|(k, pass)| Some((k, pass.scan.mask()?))).collect();
    check_order(trial, &masks, names)?;
    let mut notes = Vec::new();
    for &(number, mask) in &masks {
        let stay = DwellPositions::of(&surfaces.paths[..=number], radius);
        let place = Place::file(&trial.folder.join(names.scans[number]));
        notes
            .extend(judge(mask, &stay, place, trial)?.map(|note| format!("{}: {note}", names.scans[number].display())));
    }
    Ok(notes)
}

/// Refuses a mask that an alternative reading explains far better; returns a note if it is likelier.
fn judge(
    mask: &ExposureMask,
    stay: &DwellPositions,
    place: Place,
    trial: &Trial,
) -> Result<Option<String>, TrialError> {
    let feed = trial.passes.iter().map(|pass| pass.feed).fold(0.0, f64::max);
    let here = stay.likelihood(mask, None);
    let all = readings(stay.radius, feed);
    let tried: Vec<(AlternativeReading, f64)> =
        all.par_iter().map(|&reading| (reading, stay.likelihood(mask, Some(reading)) - here)).collect();
    let Some((reading, gain)) = tried.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1)) else { return Ok(None) };
    let found = format!("what is exposed fits the path of the pad exp({gain:.0}) times better where {reading}");
    if gain > odds::refusing(all.len()) {
        return Err(place.bad(found, reading.guess()));
    }
    Ok((gain > odds::NOTED.ln()).then_some(found))
}

fn readings(radius: f64, feed: f64) -> Vec<AlternativeReading> {
    let mut all = vec![
        AlternativeReading::MirroredX,
        AlternativeReading::MirroredY,
        AlternativeReading::HalfTurn,
        AlternativeReading::Inverted,
    ];
    all.extend([0.1, 0.5, 2.0, 10.0].map(AlternativeReading::Radius));
    for way in WAYS.map(|way| way * radius).into_iter().filter(|way| *way > odds::displaced_by_effects(feed)) {
        all.extend([DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y].map(|along| AlternativeReading::Displaced(way * along)));
    }
    all
}

impl<'a> DwellPositions<'a> {
    fn of(paths: &'a [ToolPath], radius: f64) -> Self {
        let mut poses = Vec::new();
        for path in paths {
            let touching = super::touching(path);
            let mut last: Option<(&ToolPose, f64)> = None;
            for pair in touching.windows(2) {
                let time = pair[1].time - pair[0].time;
                match &mut last {
                    Some((first, sum)) if first.centre.distance(pair[0].centre) < THIN * radius => *sum += time,
                    _ => poses.extend(last.replace((pair[0], time))),
                }
            }
            poses.extend(last);
        }
        Self { poses, radius }
    }

    /// Time for which the pad was over a point [s].
    fn time(&self, at: DVec2, radius: f64) -> f64 {
        let near = |pose: &ToolPose| pose.centre.truncate().distance_squared(at) <= radius * radius;
        self.poses.iter().filter(|(pose, _)| near(pose)).map(|(_, time)| time).sum()
    }

    /// Log-likelihood of a mask under an alternative reading.
    fn likelihood(&self, mask: &ExposureMask, reading: Option<AlternativeReading>) -> f64 {
        let PixelGrid { origin, pitch, nx, ny } = mask.pixels;
        let ends = origin + mask.pixels.position(nx - 1, ny - 1);
        let (mut radius, mut inverted) = (self.radius, false);
        if let Some(AlternativeReading::Radius(factor)) = reading {
            radius *= factor
        }
        if reading == Some(AlternativeReading::Inverted) {
            inverted = true
        }
        let stride = (0.25 * SQUARE * self.radius / pitch).floor().max(1.0) as usize;
        let places: Vec<usize> =
            (0..ny).step_by(stride).flat_map(|j| (0..nx).step_by(stride).map(move |i| j * nx + i)).collect();
        let one = |&at: &usize| {
            let exposed = mask.exposed[at]? != inverted;
            let place = mask.pixels.position(at % nx, at / nx);
            let place = match reading {
                Some(AlternativeReading::MirroredX) => DVec2::new(ends.x - place.x, place.y),
                Some(AlternativeReading::MirroredY) => DVec2::new(place.x, ends.y - place.y),
                Some(AlternativeReading::HalfTurn) => ends - place,
                Some(AlternativeReading::Displaced(way)) => place + way,
                _ => place,
            };
            Some((self.time(place, radius), exposed))
        };
        let known: Vec<(f64, bool)> = places.par_iter().filter_map(one).collect();
        let together = (SQUARE * self.radius / (pitch * stride as f64)).powi(2).max(1.0);
        rising(known) / together
    }
}

/// Log-likelihood of binary values under the best probability that increases with a variable.
fn rising(mut known: Vec<(f64, bool)>) -> f64 {
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let size = known.len().div_ceil(LEVELS).max(1);
    // Blocks: number of values, and number of true ones.
    let mut pooled: Vec<(f64, f64)> = Vec::new();
    for chunk in known.chunks(size) {
        pooled.push((chunk.len() as f64, chunk.iter().filter(|(_, yes)| *yes).count() as f64));
        while let [.., (n, a), (m, b)] = pooled[..] {
            if a / n < b / m {
                break;
            }
            pooled.truncate(pooled.len() - 2);
            pooled.push((n + m, a + b));
        }
    }
    let part = |count: f64, all: f64| if count > 0.0 { count * (count / all).ln() } else { 0.0 };
    pooled.iter().map(|&(all, yes)| part(yes, all) + part(all - yes, all)).sum()
}

/// Refuses a mask that shows less exposure than an earlier one.
///
/// - `masks`: with the number of their pass
fn check_order(trial: &Trial, masks: &[(usize, &ExposureMask)], names: &Names) -> Result<(), TrialError> {
    for numbered in masks.windows(2) {
        let (pair, [earlier, later]) = ([0, 1].map(|k| numbered[k].1), [0, 1].map(|k| numbered[k].0));
        let count = |from: bool| {
            let pixels = pair[0].exposed.iter().zip(&pair[1].exposed);
            pixels.filter(|(a, b)| **a == Some(from) && **b == Some(!from)).count() as f64
        };
        let (lost, gained) = (count(true), count(false));
        if lost <= border(pair[0]).max(super::LEAST_PIXELS as f64) {
            continue;
        }
        let exposed = pair[0].exposed.iter().filter(|exposed| **exposed == Some(true)).count() as f64;
        let guess = if lost > gained {
            "they look swapped, or the later one is inverted"
        } else {
            "is one of them mirrored, displaced or of another workpiece?"
        };
        return Err(Place::file(&trial.folder.join(names.scans[later])).bad(
            format!(
                "{:.0} % of what {} shows exposed is coated again",
                100.0 * lost / exposed,
                names.scans[earlier].display()
            ),
            format!("no coating comes back: {guess}"),
        ));
    }
    Ok(())
}

/// Number of exposed pixels beside coated ones: noise moves the border by a pixel.
fn border(mask: &ExposureMask) -> f64 {
    let (nx, all) = (mask.pixels.nx, &mask.exposed);
    let coated = |at: Option<usize>| at.is_some_and(|at| all.get(at) == Some(&Some(false)));
    let is_border = |&at: &usize| {
        all[at] == Some(true)
            && [at.checked_sub(1), Some(at + 1), at.checked_sub(nx), Some(at + nx)].into_iter().any(coated)
    };
    (0..all.len()).filter(is_border).count() as f64
}

impl AlternativeReading {
    fn guess(self) -> String {
        match self {
            Self::MirroredX => {
                "mask and log in one frame are expected: are the cells of each row reversed, or is x_mm?".to_owned()
            }
            Self::MirroredY => "mask and log in one frame are expected: are the rows reversed, or is y_mm?".to_owned(),
            Self::HalfTurn => "mask and log in one frame are expected: are rows and cells reversed?".to_owned(),
            Self::Inverted => "1 where substrate is exposed and 0 where it is coated are expected".to_owned(),
            Self::Displaced(_) => format!(
                "mask and log in one frame are expected: is origin_mm of {TRIAL_FILE} off, or the log of another trial?"
            ),
            Self::Radius(_) => format!("is radius_mm of {TRIAL_FILE} the diameter, or in another unit?"),
        }
    }
}

impl fmt::Display for AlternativeReading {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MirroredX => f.write_str("it is mirrored along x"),
            Self::MirroredY => f.write_str("it is mirrored along y"),
            Self::HalfTurn => f.write_str("it is turned by half a turn"),
            Self::Inverted => f.write_str("0 is exposed and 1 is coated"),
            Self::Displaced(way) => {
                write!(f, "it lies {:.1} mm along x and {:.1} mm along y from there", 1e3 * way.x, 1e3 * way.y)
            }
            Self::Radius(factor) => write!(f, "the pad's radius is {factor} times as large"),
        }
    }
}
