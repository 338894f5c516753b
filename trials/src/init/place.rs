//! Registration of the log's path with the scans: settings of each pass, position of the first pixel, height of the log
//! above the surface, and width of the ground track.

use std::ops::Range;

use glam::{DVec2, DVec3};
use instruments::log::guess::Role;
use instruments::log::{Channels, Guesses};
use instruments::surface::Surface;

use super::files::Found;
use super::scans::Scans;
use crate::column_unit::ColumnUnit;
use crate::measure::median;
use crate::trial::strokes;

/// Maximum number of log rows that are read.
const MOST_ROWS: usize = 20_000;
/// Distance from a map's border [pixels] within which a track counts as leaving the map.
const AT_BORDER: f64 = 3.0;
/// Quantiles of the removed pixels, sorted across the path, between which the track lies; spikes are left out.
const TRACK: [f64; 2] = [0.005, 0.995];

/// Settings of a pass, estimated from its log.
pub(super) struct PassGuess {
    /// Number of its log.
    pub(super) log: usize,
    /// First and last time of its rows [s]; `None` if the log has no other stroke.
    pub(super) time: Option<[f64; 2]>,
    /// Median force in contact [N].
    pub(super) force: f64,
    /// Median speed in motion [m/s].
    pub(super) feed: f64,
    /// Median spindle speed [rad/s]; `None` if the log has none.
    pub(super) spindle: Option<f64>,
    /// Direction from the first to the last row, unit.
    pub(super) direction: DVec3,
    /// Positions in contact [m].
    pressed: Vec<DVec3>,
}

/// The logs in the frame of the scans.
pub(super) struct Placing {
    /// One for each stroke of each log.
    pub(super) passes: Vec<PassGuess>,
    /// x, y of the first pixel of the scan before that puts the track under the path [m]; `None` if it cannot be
    /// determined.
    pub(super) origin: Option<DVec2>,
    /// True if the position of the scan along the path cannot be determined.
    pub(super) slides_along: bool,
    /// Median height of the logged position above the surface that the last pass left, in contact [m].
    pub(super) gap: Option<f64>,
    /// Width of the track across the path [m].
    pub(super) width: Option<f64>,
}

impl Placing {
    /// Registers the logs with the scan before.
    pub(super) fn of(found: &Found, scans: &Scans) -> Self {
        let strokes = |(log, (_, channels, guesses))| {
            let motion = Motion::of(channels, guesses)?;
            Some(motion.strokes().into_iter().filter_map(|rows| motion.pass(log, rows)).collect::<Vec<_>>())
        };
        let passes: Vec<PassGuess> = found.logs().enumerate().filter_map(strokes).flatten().collect();
        let before = found.maps().find(|(name, _)| *name == scans.reference()).map(|(_, surface)| surface);
        let mut placing = Self { passes, origin: None, slides_along: false, gap: None, width: None };
        let (Some(before), Some(pass)) = (before, placing.passes.last()) else { return placing };
        let Some(pitch) = before.pitch else { return placing };
        let track: Vec<DVec2> = scans.removed.iter().map(|(pixel, _)| *pixel * pitch).collect();
        let Some((origin, slides_along, width)) = laid(&track, pass, before, pitch) else { return placing };
        let own = before.origin.unwrap_or(origin);
        // The height of the surface there is known only in the scan's own frame.
        let lies_on = if own.distance(origin) < width { own } else { origin };
        let gap = match scans.before {
            Some(_) => gap(pass, &after_last(before, scans), lies_on, pitch),
            None => gap(pass, before, lies_on, pitch),
        };
        (placing.origin, placing.slides_along) = (Some(origin), slides_along);
        (placing.gap, placing.width) = (gap, Some(width));
        placing
    }
}

/// A log in SI units; every few rows of a long one.
struct Motion {
    time: Vec<f64>,
    places: Vec<DVec3>,
    force: Vec<f64>,
    /// Spindle speed [rad/s]; `None` if the log has none.
    spindle: Option<Vec<f64>>,
}

impl Motion {
    /// Reads a log by the best guesses of its channels; `None` without a time or a force.
    fn of(channels: &Channels, guesses: &Guesses) -> Option<Self> {
        let step = channels.rows().div_ceil(MOST_ROWS).max(1);
        let si = |role: Role| values(channels, guesses, (role, step));
        let (time, force) = (si(Role::Time)?, si(Role::Force)?);
        let axis = |role: Role| si(role).unwrap_or_else(|| vec![0.0; time.len()]);
        let [x, y, z] = [Role::X, Role::Y, Role::Z].map(axis);
        let places = (0..time.len()).map(|k| DVec3::new(x[k], y[k], z[k])).collect();
        Some(Self { places, spindle: si(Role::Spindle), time, force })
    }

    /// Rows of each stroke.
    fn strokes(&self) -> Vec<Range<usize>> {
        let pressing = 0.5 * high(&self.force);
        let force = median(self.force.iter().copied().filter(|force| *force > pressing).collect()).unwrap_or(0.0);
        let unknown = |value: f64| if value.is_finite() { value } else { 0.0 };
        let rows: Vec<(f64, f64)> = self.time.iter().zip(&self.force).map(|(t, f)| (*t, unknown(*f))).collect();
        strokes(&rows, force)
    }

    /// Settings of the pass in a range of rows; `None` if the tool never presses.
    fn pass(&self, log: usize, rows: Range<usize>) -> Option<PassGuess> {
        let (time, places, force) = (&self.time[rows.clone()], &self.places[rows.clone()], &self.force[rows.clone()]);
        let pressing = 0.5 * high(force);
        let is_pressed = |k: &usize| force[*k] > pressing && places[*k].is_finite();
        let pressed: Vec<DVec3> = (0..places.len()).filter(is_pressed).map(|k| places[k]).collect();
        let speeds: Vec<f64> = (1..places.len())
            .map(|k| (places[k] - places[k - 1]).truncate().length() / (time[k] - time[k - 1]))
            .filter(|speed| speed.is_finite())
            .collect();
        let moving = 0.5 * high(&speeds);
        let way = pressed.first().zip(pressed.last()).map_or(DVec3::ZERO, |(first, last)| last - first);
        let spindle = self.spindle.as_ref().map(|speeds| speeds[rows.clone()].iter().copied());
        let between = |k: usize| 0.5 * (self.time[k - 1] + self.time[k]);
        let from = if rows.start == 0 { self.time[0] } else { between(rows.start) };
        let to = if rows.end == self.time.len() { self.time[rows.end - 1] } else { between(rows.end) };
        Some(PassGuess {
            log,
            time: (rows.len() < self.time.len()).then_some([from, to]),
            force: median(force.iter().copied().filter(|force| *force > pressing).collect())?,
            feed: median(speeds.into_iter().filter(|speed| *speed > moving).collect()).unwrap_or(0.0),
            spindle: spindle.and_then(|speeds| median(speeds.filter(|speed| speed.is_finite()).collect())),
            direction: way.with_z(0.0).try_normalize().unwrap_or(DVec3::X),
            pressed,
        })
    }
}

/// SI values of the best candidate for a role, every `step`-th; `None` without a candidate.
fn values(channels: &Channels, guesses: &Guesses, (role, step): (Role, usize)) -> Option<Vec<f64>> {
    let candidate = guesses.best(role)?;
    let unit = match role {
        Role::Spindle => ColumnUnit::parse_spindle(&candidate.unit),
        _ => ColumnUnit::parse(&candidate.unit),
    };
    let (unit, sign) = (unit.ok()?, f64::from(candidate.sign));
    Some(channels.values[candidate.channel].iter().step_by(step).map(|value| unit.to_si(sign * value)).collect())
}

/// The 95th percentile; infinite for no values.
fn high(values: &[f64]) -> f64 {
    let mut known: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    known.sort_by(f64::total_cmp);
    known.get(known.len() * 19 / 20).copied().unwrap_or(f64::INFINITY)
}

/// Position of the first pixel that puts the track under the path, true if it is undetermined along the path, and the
/// track's width [m].
///
/// - `track`: positions relative to the first pixel [m]
fn laid(track: &[DVec2], pass: &PassGuess, before: &Surface, pitch: DVec2) -> Option<(DVec2, bool, f64)> {
    let along = pass.direction.truncate();
    let across = along.perp();
    let path: Vec<DVec2> = pass.pressed.iter().map(|place| place.truncate()).collect();
    let [path_along, path_across] = [along, across].map(|axis| range(path.iter().map(|place| place.dot(axis))));
    let [track_along, track_across] = [along, across].map(|axis| range(track.iter().map(|place| place.dot(axis))));
    let (path_along, path_across, track_along, track_across) = (path_along?, path_across?, track_along?, track_across?);
    let size = DVec2::new(before.nx as f64 - 1.0, before.ny as f64 - 1.0) * pitch;
    let corners = [DVec2::ZERO, DVec2::new(size.x, 0.0), DVec2::new(0.0, size.y), size];
    let map = range_all(corners.iter().map(|corner| corner.dot(along)));
    let border = AT_BORDER * pitch.max_element();
    let ends = [track_along[0] > map[0] + border, track_along[1] < map[1] - border];
    let middle = |range: [f64; 2]| 0.5 * (range[0] + range[1]);
    let shift = match ends {
        [true, true] | [false, false] => middle(path_along) - middle(track_along),
        [true, false] => path_along[0] - track_along[0],
        [false, true] => path_along[1] - track_along[1],
    };
    let origin = along * shift + across * (middle(path_across) - middle(track_across));
    Some((origin, ends == [false, false], track_across[1] - track_across[0]))
}

/// Lowest and highest of some values without the outermost ones; `None` for no values.
fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    Some(TRACK.map(|share| values[(share * last as f64).round() as usize]))
}

fn range_all(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

/// The surface that the last pass left, in the frame of the scan before.
fn after_last(before: &Surface, scans: &Scans) -> Surface {
    let mut after = before.clone();
    for (pixel, depth) in &scans.removed {
        after.heights[pixel.y as usize * before.nx + pixel.x as usize] -= depth;
    }
    after
}

/// Median height of the positions in contact above the map [m].
fn gap(pass: &PassGuess, before: &Surface, origin: DVec2, pitch: DVec2) -> Option<f64> {
    let height = |place: &DVec3| {
        let at = ((place.truncate() - origin) / pitch).round();
        let is_inside = at.cmpge(DVec2::ZERO).all() && at.x < before.nx as f64 && at.y < before.ny as f64;
        is_inside.then(|| before.heights[at.y as usize * before.nx + at.x as usize])
    };
    let gaps = pass.pressed.iter().filter_map(|place| Some(place.z - height(place)?)).filter(|gap| gap.is_finite());
    median(gaps.collect())
}
