//! Consistency of the tool's logged heights with the surface that it left: in contact they follow that surface.
//!
//! ```text
//!   z of the log less the height at which the tool touches the scan, a straight line taken out:
//!   ~~~~~~~~~~~~~  scan and log in one frame        _/\__/‾\_/  one of them mirrored, displaced or of another scale
//! ```
//!
//! For each possible relation between the two frames, the spread of that gap is measured. The likelihood of a normal
//! distribution with unknown variance is proportional to `spread^-n`, so `n ln(spread as read / spread otherwise)` is
//! the logarithm of the odds; `n` counts runs of one sign, because neighbouring poses share their gap.

use std::fmt;

use glam::{DVec2, Vec2Swizzles};
use rayon::prelude::*;
use sdf_bake::simd::in_wide_lanes;
use sdf_bake::{HeightMap, PixelGrid};

use super::super::error::{Place, TrialError};
use super::super::manifest::TRIAL_FILE;
use super::super::poses::{ToolPath, ToolPose};
use super::super::{HeldTool, Trial};
use super::{Names, Surfaces, contact, odds, touching};
use robot::{Tool, Wheel};

/// Minimum spread [m]: the errors of pose and scan of good instruments.
const FINEST: f64 = 2e-6;
/// Share of the spread of the logged heights below which the rest is explained by the surface; above it, the log does
/// not follow the surface.
const FOLLOWS: f64 = 0.5;
/// Maximum number of poses that are checked, the minimum number, and the share of them that must lie on the map.
const LOOKED_AT: usize = 64;
const LEAST_POSES: usize = 12;
const ON_THE_MAP: f64 = 0.7;
/// Range of displacements that are tested [m], and their step.
const REACH: f64 = 10e-3;
const STEP: f64 = 1e-3;
/// Multiple of the largest displacement by effects above which a displacement is a fault of the files; smaller ones
/// partly fit a hidden effect.
const EFFECTS: f64 = 1.5;

/// Possible relation of the log's frame to that of the scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Frame {
    AsRead,
    MirroredX,
    MirroredY,
    HalfTurn,
    Transposed,
    /// The path is displaced [m].
    Displaced(DVec2),
    /// The pixels are larger by a factor; true if the origin is scaled as well.
    Pitch(f64, bool),
    /// The wheel's axis lies along x instead of y, or the reverse.
    TurnedAxis,
}

/// Poses in contact, with the surface that they left.
pub(super) struct Contact<'a> {
    pub(super) poses: Vec<&'a ToolPose>,
    pub(super) map: HeightMap,
}

/// Gaps along a path, without their linear trend.
#[derive(Clone, Copy, Debug)]
struct Gaps {
    /// Root mean square [m].
    spread: f64,
    /// Number of runs of one sign.
    runs: f64,
}

/// Refuses logs whose heights follow the scans only in another frame; returns a note if that is likelier.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<Option<String>, TrialError> {
    let contacts = contacts(surfaces);
    let feed = trial.passes.iter().map(|pass| pass.feed).fold(0.0, f64::max);
    let mut note = None;
    for family in [frames(), displaced(feed)] {
        let Some((frame, gain)) = best(&trial.tool, &contacts, &family) else { continue };
        let [here, there] = [Frame::AsRead, frame].map(|frame| 1e6 * pooled(&trial.tool, &contacts, frame));
        let found = format!(
            "z_mm: along the path the tool lies {here:.1} µm rms off a line above the scans as they are, and {there:.1} µm where \
             {frame}"
        );
        if gain > odds::refusing(family.len()) {
            return Err(Place::file(&trial.folder.join(names.logs[0])).bad(found, frame.guess()));
        }
        if gain > odds::NOTED.ln() {
            note = note.or(Some(format!("{}: {found}: {}", names.logs[0].display(), frame.guess())));
        }
    }
    Ok(note)
}

/// Poses in contact of each pass with the surface that it left, in the frame of the first scan. No poses if that
/// surface was not scanned, though those of other passes were.
pub(super) fn contacts<'a>(surfaces: &'a Surfaces) -> Vec<Contact<'a>> {
    let is_ground = surfaces.after.iter().any(Option::is_some);
    let one = |(pass, (path, after)): (usize, (&'a ToolPath, &'a Option<HeightMap>))| {
        let poses = if is_ground && after.is_none() { Vec::new() } else { touching(path) };
        let stride = poses.len().div_ceil(LOOKED_AT).max(1);
        let levelled = |after| contact::levelled(after, surfaces, pass);
        let map = after.as_ref().map_or_else(|| surfaces.before.clone(), levelled);
        Contact { poses: poses.into_iter().step_by(stride).collect(), map }
    };
    surfaces.paths.iter().zip(&surfaces.after).enumerate().map(one).collect()
}

/// Frames with another orientation or scale.
fn frames() -> Vec<Frame> {
    vec![
        Frame::MirroredX,
        Frame::MirroredY,
        Frame::HalfTurn,
        Frame::Transposed,
        Frame::TurnedAxis,
        Frame::Pitch(2.0, false),
        Frame::Pitch(0.5, false),
        Frame::Pitch(2.0, true),
        Frame::Pitch(0.5, true),
    ]
}

/// Displacements beyond those that effects cause.
fn displaced(feed: f64) -> Vec<Frame> {
    let steps = (REACH / STEP) as i32;
    let ways = (-steps..=steps).map(|step| f64::from(step) * STEP);
    let far = ways.filter(|way| way.abs() > EFFECTS * odds::displaced_by_effects(feed));
    far.flat_map(|way| [DVec2::new(way, 0.0), DVec2::new(0.0, way)].map(Frame::Displaced)).collect()
}

/// The likeliest of some frames, with the logarithm of its odds against the frame as read.
fn best(tool: &HeldTool, contacts: &[Contact], frames: &[Frame]) -> Option<(Frame, f64)> {
    let here: Vec<Option<Gaps>> = contacts.iter().map(|contact| contact.gaps(tool, Frame::AsRead)).collect();
    let odds = |&frame: &Frame| {
        let there = contacts.iter().map(|contact| contact.gaps(tool, frame));
        let all = contacts.iter().zip(&here).zip(there);
        (frame, all.map(|((contact, here), there)| log_odds(contact.heights(), *here, there)).sum::<f64>())
    };
    let all: Vec<(Frame, f64)> = frames.par_iter().map(odds).collect();
    // The first of equal ones.
    all.into_iter().rev().max_by(|a, b| a.1.total_cmp(&b.1))
}

/// Logarithm of the odds of one frame against another, from the gaps of a pass; zero if neither explains the logged
/// heights.
fn log_odds(heights: Option<Gaps>, here: Option<Gaps>, there: Option<Gaps>) -> f64 {
    let (Some(heights), Some(there)) = (heights, there) else { return 0.0 };
    let here = here.unwrap_or(heights);
    let follows = |gaps: Gaps| gaps.spread < FOLLOWS * heights.spread;
    if !follows(here) && !follows(there) {
        return 0.0;
    }
    here.runs.min(there.runs) * (here.spread.max(FINEST) / there.spread.max(FINEST)).ln()
}

/// Root mean square of the gaps of all passes [m].
fn pooled(tool: &HeldTool, contacts: &[Contact], frame: Frame) -> f64 {
    let spreads = contacts.iter().filter_map(|contact| contact.gaps(tool, frame)).map(|gaps| gaps.spread.powi(2));
    let (sum, count) = spreads.fold((0.0, 0.0), |(sum, count), square| (sum + square, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Mean gap between a path and a map [m]; `None` if too little of it is known.
pub(super) fn touch_level(tool: &HeldTool, contact: &Contact, map: &HeightMap) -> Option<f64> {
    let relief = relief(map);
    let gap = |pose: &&ToolPose| {
        let at = pose.centre.truncate();
        map.pixels.nearest(at)?;
        Some(pose.centre.z - touch(tool, (pose, at), map, relief)?)
    };
    let gaps: Vec<f64> = contact.poses.iter().filter_map(gap).collect();
    (gaps.len() >= LEAST_POSES).then(|| gaps.iter().sum::<f64>() / gaps.len() as f64)
}

/// Height difference between the lowest and the highest pixel [m].
fn relief(map: &HeightMap) -> f64 {
    let known = map.heights.iter().filter(|height| height.is_finite());
    let (low, high) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &h| (low.min(h), high.max(h)));
    high - low
}

/// Logarithm of the odds that a path belongs to the surface of another pass.
pub(super) fn odds_of_another(tool: &HeldTool, own: &Contact, other: &HeightMap) -> f64 {
    let there = gaps_along(tool, &own.poses, other, |at| at);
    log_odds(own.heights(), own.gaps(tool, Frame::AsRead), there)
}

impl Contact<'_> {
    /// The logged heights as gaps to a plane.
    fn heights(&self) -> Option<Gaps> {
        Gaps::of(&self.poses.iter().enumerate().map(|(k, pose)| (k as f64, pose.centre.z)).collect::<Vec<_>>())
    }

    fn gaps(&self, tool: &HeldTool, frame: Frame) -> Option<Gaps> {
        let PixelGrid { origin, pitch, nx, ny } = self.map.pixels;
        let ends = origin + self.map.pixels.position(nx - 1, ny - 1);
        let along = |place: &(dyn Fn(DVec2) -> DVec2 + Sync)| gaps_along(tool, &self.poses, &self.map, place);
        match frame {
            Frame::AsRead => along(&|at| at),
            Frame::MirroredX => along(&|at| DVec2::new(ends.x - at.x, at.y)),
            Frame::MirroredY => along(&|at| DVec2::new(at.x, ends.y - at.y)),
            Frame::HalfTurn => along(&|at| ends - at),
            Frame::Transposed => along(&|at| at.yx()),
            Frame::Displaced(way) => along(&|at| at - way),
            Frame::Pitch(factor, moves) => {
                let origin = if moves { factor * origin } else { origin };
                let pixels = PixelGrid { origin, pitch: factor * pitch, nx, ny };
                gaps_along(tool, &self.poses, &HeightMap { pixels, heights: self.map.heights.clone() }, |at| at)
            }
            Frame::TurnedAxis => {
                let turned = |pose: &&ToolPose| ToolPose { axis: pose.approach.cross(pose.axis), ..**pose };
                let poses: Vec<ToolPose> = self.poses.iter().map(turned).collect();
                gaps_along(tool, &poses.iter().collect::<Vec<_>>(), &self.map, |at| at)
            }
        }
    }
}

impl Gaps {
    /// Gaps from values at positions, without their linear trend; `None` if they are too few.
    fn of(gaps: &[(f64, f64)]) -> Option<Self> {
        if gaps.len() < LEAST_POSES {
            return None;
        }
        let count = gaps.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| gaps.iter().map(of).sum::<f64>() / count;
        let (at, level) = (mean(&|gap| gap.0), mean(&|gap| gap.1));
        let slope = mean(&|gap| (gap.0 - at) * (gap.1 - level)) / mean(&|gap| (gap.0 - at).powi(2));
        let left: Vec<f64> = gaps.iter().map(|gap| gap.1 - level - slope * (gap.0 - at)).collect();
        let spread = (left.iter().map(|left| left * left).sum::<f64>() / count).sqrt();
        let changes = left.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count();
        Some(Self { spread, runs: (changes + 1) as f64 })
    }
}

/// Gaps of a path to a map, with the log's positions transformed; `None` if too much of the path lies outside the map.
fn gaps_along(
    tool: &HeldTool,
    poses: &[&ToolPose],
    map: &HeightMap,
    place: impl Fn(DVec2) -> DVec2 + Sync,
) -> Option<Gaps> {
    let relief = relief(map);
    let gap = |(k, pose): (usize, &&ToolPose)| {
        let at = place(pose.centre.truncate());
        map.pixels.nearest(at)?;
        Some((k as f64, pose.centre.z - touch(tool, (pose, at), map, relief)?))
    };
    let gaps: Vec<(f64, f64)> = poses.iter().enumerate().filter_map(gap).collect();
    if (gaps.len() as f64) < ON_THE_MAP * poses.len() as f64 {
        return None;
    }
    Gaps::of(&gaps)
}

/// Height of a wheel's centre where it touches a map; for a disc the mean height under it, because a pad's foam
/// averages it out [m]. `None` if nothing is known below.
fn touch(tool: &HeldTool, (pose, at): (&ToolPose, DVec2), map: &HeightMap, relief: f64) -> Option<f64> {
    match &tool.shape {
        Tool::Wheel(wheel) => {
            // Beyond this distance a wheel's rim is above its lowest point by more than the map's relief.
            let reach = (2.0 * wheel.radius * relief).sqrt().min(wheel.radius).hypot(0.5 * wheel.width);
            let rows = rows_within(map, at, reach);
            let most = in_wide_lanes(
                #[inline(always)]
                || highest_centre(wheel, pose.axis.truncate(), &rows),
            );
            most.is_finite().then_some(most)
        }
        disc => {
            let reach = disc.rim_radius();
            let rows = rows_within(map, at, reach);
            let under = rows.iter().flat_map(|row| row.places().zip(row.heights));
            let known = under.filter(|(from, height)| from.length_squared() <= reach * reach && height.is_finite());
            let (sum, count) = known.fold((0.0, 0), |(sum, count), (_, height)| (sum + height, count + 1));
            (count > 0).then(|| sum / f64::from(count))
        }
    }
}

/// Pixels of a row of a map near a place.
struct Row<'a> {
    /// From the place to the first pixel [m].
    first: DVec2,
    /// [m]
    pitch: f64,
    /// [m]; NaN where unknown.
    heights: &'a [f64],
}

impl Row<'_> {
    /// Positions of the pixels relative to the place [m].
    #[inline(always)]
    fn places(&self) -> impl Iterator<Item = DVec2> {
        let (first, pitch) = (self.first, self.pitch);
        (0..self.heights.len()).map(move |i| DVec2::new(first.x + pitch * i as f64, first.y))
    }
}

/// The pixels of a map within a square of half width `reach` [m] around a place.
fn rows_within(map: &HeightMap, at: DVec2, reach: f64) -> Vec<Row<'_>> {
    let pixels = map.pixels;
    let clamp = |value: f64, most: usize| value.clamp(0.0, most as f64) as usize;
    let low = (at - reach - pixels.origin) / pixels.pitch;
    let high = (at + reach - pixels.origin) / pixels.pitch + 1.0;
    let columns = clamp(low.x, pixels.nx)..clamp(high.x, pixels.nx);
    let row = |j: usize| Row {
        first: pixels.position(columns.start, j) - at,
        pitch: pixels.pitch,
        heights: &map.heights[j * pixels.nx..][columns.clone()],
    };
    if columns.is_empty() { Vec::new() } else { (clamp(low.y, pixels.ny)..clamp(high.y, pixels.ny)).map(row).collect() }
}

/// Height of the centre of a wheel with an axis along `axis` where it touches the highest pixel [m]; −∞ where nothing is
/// known.
#[inline(always)]
fn highest_centre(wheel: &Wheel, axis: DVec2, rows: &[Row]) -> f64 {
    let (half, squared) = (0.5 * wheel.width, wheel.radius * wheel.radius);
    let mut most = f64::NEG_INFINITY;
    for row in rows {
        for (from, &height) in row.places().zip(row.heights) {
            let along = from.dot(axis);
            let forward = from.length_squared() - along * along;
            let centre = height + (squared - forward).max(0.0).sqrt();
            // Without branches, so that several pixels are taken at once; an unknown height is never above.
            let is_above = (along.abs() <= half) & (forward < squared) & (centre > most);
            most = if is_above { centre } else { most };
        }
    }
    most
}

impl Frame {
    /// The possible cause, as a question.
    fn guess(self) -> String {
        match self {
            Self::AsRead => String::new(),
            Self::MirroredX => "scans and log in one frame are expected: the cells of each row look reversed in all scans, which mirror = \"x\" in \
                              [scan] undoes, or x_mm has the other sign"
                .to_owned(),
            Self::MirroredY => "scans and log in one frame are expected: the rows of all scans look reversed, which mirror = \"y\" in [scan] \
                              undoes, or y_mm has the other sign"
                .to_owned(),
            Self::HalfTurn => "scans and log in one frame are expected: rows and cells of all scans look reversed".to_owned(),
            Self::Transposed => "scans and log in one frame are expected: x_mm and y_mm look swapped".to_owned(),
            Self::Displaced(way) => format!(
                "scans and log in one frame are expected: origin_mm of {TRIAL_FILE} looks {:.0} mm off along x and {:.0} mm along y",
                1e3 * way.x,
                1e3 * way.y
            ),
            Self::Pitch(factor, _) => {
                let times = if factor > 1.0 { "half" } else { "twice" };
                format!("scans and log in one scale are expected: is pitch_mm of {TRIAL_FILE} {times} the right one?")
            }
            Self::TurnedAxis => format!("is axis of {TRIAL_FILE} turned by 90°?"),
        }
    }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AsRead => f.write_str("they are as read"),
            Self::MirroredX => f.write_str("all scans are mirrored along x"),
            Self::MirroredY => f.write_str("all scans are mirrored along y"),
            Self::HalfTurn => f.write_str("all scans are turned by half a turn"),
            Self::Transposed => f.write_str("x and y change places"),
            Self::Displaced(way) => {
                write!(f, "the path lies {:.0} mm along x and {:.0} mm along y from there", -1e3 * way.x, -1e3 * way.y)
            }
            Self::Pitch(factor, _) => write!(f, "pixels are {factor} times as wide"),
            Self::TurnedAxis => f.write_str("the axis is turned by 90°"),
        }
    }
}
