//! Position of the tool in contact: on the surface that it ground, neither above it nor deep inside.
//!
//! ```text
//!        ___                      ___
//!      /     \  gap > 0         /     \  gap < 0: the tool lies in the surface
//!      \_ _ _/                 _\_____/_
//!    _____________            ___________ surface
//! ```

use std::path::Path;

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use sdf_bake::{HeightMap, PixelGrid};

use super::super::error::{Place, TrialError};
use super::super::manifest::TRIAL_FILE;
use super::super::poses::{ToolPath, ToolPose};
use super::super::{HeldTool, Trial};
use super::{Names, Surfaces, touching};
use crate::measure::{CLEARANCE, DegreesOfFreedom, median, register};
use robot::{Tool, Wheel};

/// Largest gap between a tool in contact and the surface [m]: five times the clearance for errors of pose, scan and
/// part. It is less than the millimetre or more that a wrong unit, sign or reference point causes on a bead.
const ABOVE: f64 = 5.0 * CLEARANCE;
/// Gap for a note [m]: the logarithmic middle between the largest gap of valid campaigns (0.13 mm) and the limit.
const HIGH: f64 = 0.25e-3;
/// Share of its radius by which a wheel's rim may be compressed: soft rims reach a few hundredths; a log of the tip is
/// off by a whole radius. √(0.003 · 1) is about 0.05.
const RIM_GIVES: f64 = 0.05;
/// Depth by which the foam behind a pad may be compressed [m]: interface pads are 5 to 10 mm thick.
const PAD_GIVES: f64 = 10e-3;
/// Maximum number of poses that are checked.
const LOOKED_AT: usize = 48;
/// Common wrong factors of a radius, and their descriptions.
const RADII: [(f64, &str); 7] = [
    (10.0, "10 times too large"),
    (0.1, "10 times too small"),
    (2.0, "the diameter"),
    (0.5, "half of the radius"),
    (1e3, "1000 times too large"),
    (1e-3, "1000 times too small"),
    (1.0 / 25.4, "in inches"),
];
/// Relative difference up to which a radius matches one of those factors.
const SAME_RADIUS: f64 = 0.1;

/// Hypothetical mistake in the files.
#[derive(Clone, Copy, Default)]
struct SupposedMistake {
    /// Added to the tool's height over the part [m].
    lift: f64,
    /// Factor on the tool's z.
    log_scale: Option<f64>,
    /// Factor on all heights.
    map_scale: Option<f64>,
    /// The approach axis points into the part.
    turned: bool,
}

/// Gaps of a pass [m], relative to the surface before it and to the one that it left; positive if the tool is above.
#[derive(Clone, Copy)]
struct Gaps {
    before: f64,
    /// Relative to the surface after the pass; equal to `before` if no surface was scanned.
    after: f64,
}

/// A pass with the surfaces before and after it, in the frame of the first scan.
struct PassSurfaces<'a> {
    tool: &'a HeldTool,
    poses: Vec<&'a ToolPose>,
    before: &'a HeightMap,
    after: Option<&'a HeightMap>,
}

/// Smallest gap between a tool and a surface on its whole path [m]; `None` if it never was over the map.
pub fn least_gap(tool: &HeldTool, path: &ToolPath, map: &HeightMap) -> Option<f64> {
    let poses = spread_out(&path.poses.iter().collect::<Vec<_>>(), &map.pixels);
    let gaps = poses.par_iter().filter_map(|pose| gap(tool, pose, (map, SupposedMistake::default())));
    gaps.collect::<Vec<f64>>().into_iter().reduce(f64::min)
}

/// Refuses a pass without any contact on the map.
pub(super) fn check_place(touching: &[&ToolPose], map: &HeightMap, place: &Place) -> Result<(), TrialError> {
    let PixelGrid { origin, nx, ny, .. } = map.pixels;
    if touching.is_empty() || touching.iter().any(|pose| map.pixels.nearest(pose.centre.truncate()).is_some()) {
        return Ok(());
    }
    let (low, high) = touching.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), pose| {
        (low.min(pose.centre.truncate()), high.max(pose.centre.truncate()))
    });
    let shown = |low: DVec2, high: DVec2| {
        format!("x {:.2} to {:.2} mm, y {:.2} to {:.2} mm", low.x * 1e3, high.x * 1e3, low.y * 1e3, high.y * 1e3)
    };
    Err(place.clone().bad(
        format!("all contact is at {}", shown(low, high)),
        format!("a path over the map at {} is expected", shown(origin, map.pixels.position(nx - 1, ny - 1))),
    ))
}

/// Refuses a tool that is far above the surface or far inside it; returns notes on smaller gaps.
pub(super) fn check(trial: &Trial, surfaces: &Surfaces, names: &Names) -> Result<Vec<String>, TrialError> {
    let mut notes = Vec::new();
    let mut earlier = (surfaces.before.clone(), names.before);
    for (pass, path) in surfaces.paths.iter().enumerate() {
        let after = surfaces.after[pass].as_ref().map(|after| levelled(after, surfaces, pass));
        let poses = spread_out(&touching(path), &surfaces.before.pixels);
        let worked = PassSurfaces { tool: &trial.tool, poses, before: &earlier.0, after: after.as_ref() };
        let files = Files { log: &trial.folder.join(names.logs[pass]), before: earlier.1, after: names.scans[pass] };
        if let Some(gaps) = worked.gaps(SupposedMistake::default()) {
            notes.extend(judge(&worked, gaps, &files)?.map(|note| format!("{}: {note}", names.logs[pass].display())));
        }
        if let Some(after) = after {
            earlier = (after, names.scans[pass]);
        }
    }
    Ok(notes)
}

/// A scan registered with the first one by offset and tilt; unchanged if that fails.
pub(super) fn levelled(after: &HeightMap, surfaces: &Surfaces, pass: usize) -> HeightMap {
    let free = surfaces.free_until(pass);
    let found = register(after, &surfaces.before, DegreesOfFreedom::Plane, |at| free[at]);
    found.map_or_else(|_| after.clone(), |found| found.levelled(after))
}

/// A subset of the poses over the map, evenly spread.
fn spread_out<'a>(touching: &[&'a ToolPose], map: &PixelGrid) -> Vec<&'a ToolPose> {
    let over: Vec<&ToolPose> =
        touching.iter().copied().filter(|pose| map.nearest(pose.centre.truncate()).is_some()).collect();
    let stride = over.len().div_ceil(LOOKED_AT).max(1);
    over.into_iter().step_by(stride).collect()
}

/// The files that a message may name.
struct Files<'a> {
    log: &'a Path,
    before: &'a Path,
    after: &'a Path,
}

/// Refuses gaps that no contact has; returns a note on those that only a soft tool or an offset explains.
fn judge(worked: &PassSurfaces, gaps: Gaps, files: &Files) -> Result<Option<String>, TrialError> {
    let described = |gap: f64, file: &Path| format!("z_mm: {}", describe(gap, file));
    if worked.is_contact(gaps) {
        // A pad's foam may be compressed by millimetres, which no file records.
        let is_deep = gaps.after < -ABOVE && worked.after.is_some();
        return Ok(if gaps.before > HIGH {
            Some(described(gaps.before, files.before))
        } else {
            (is_deep || gaps.after > HIGH).then(|| described(gaps.after, files.after))
        });
    }
    if gaps.before <= ABOVE && gaps.after > ABOVE {
        let log = files.log.file_name().unwrap_or_default().to_string_lossy();
        let accepted = format!(
            "heights in mm on the zero of {} are expected: are they in another unit or of the other sign, or is z_mm of {log} \
             {:.2} mm too high?",
            files.before.display(),
            1e3 * gaps.after
        );
        return Err(Place::file(&files.log.with_file_name(files.after))
            .bad(format!("{}: more was removed than it reached", describe(gaps.after, files.after)), accepted));
    }
    let (gap, file) = if gaps.before > ABOVE { (gaps.before, files.before) } else { (gaps.after, files.after) };
    Err(Place::file(files.log)
        .bad(described(gap, file), format!("contact is expected: {}", worked.guesses(gap).join(" or "))))
}

/// Description of a gap.
fn describe(gap: f64, surface: &Path) -> String {
    let (size, side) = (1e3 * gap.abs(), if gap > 0.0 { "above" } else { "below" });
    format!("while it presses, the tool lies {size:.2} mm {side} the surface of {}", surface.display())
}

impl PassSurfaces<'_> {
    /// True if such gaps are plausible for a tool in contact.
    fn is_contact(&self, gaps: Gaps) -> bool {
        let gives = match &self.tool.shape {
            Tool::Wheel(Wheel { radius, .. }) => (RIM_GIVES * radius).max(ABOVE),
            _ => PAD_GIVES,
        };
        gaps.before <= ABOVE && (-gives..=ABOVE).contains(&gaps.after)
    }

    /// Medians over the poses; `None` if no pose has a surface below it.
    fn gaps(&self, supposed: SupposedMistake) -> Option<Gaps> {
        let to = |map: &HeightMap| {
            let gaps = self.poses.par_iter().filter_map(|pose| gap(self.tool, &supposed.pose(pose), (map, supposed)));
            median(gaps.collect())
        };
        let before = to(self.before)?;
        Some(Gaps { before, after: self.after.map_or(Some(before), to)? })
    }

    /// Mistakes that explain a gap, as questions.
    fn guesses(&self, gap: f64) -> Vec<String> {
        // With the mistake corrected, a wheel lies on the surface; the compression of a pad's foam is unknown.
        let is_near = |gaps: &Gaps| gaps.after >= -ABOVE || matches!(self.tool.shape, Tool::Pad(_));
        let explains = |supposed| self.gaps(supposed).is_some_and(|gaps| self.is_contact(gaps) && is_near(&gaps));
        let log = |scale: f64| SupposedMistake { log_scale: Some(scale), ..SupposedMistake::default() };
        let maps = |scale: f64| SupposedMistake { map_scale: Some(scale), ..SupposedMistake::default() };
        let mut known: Vec<(SupposedMistake, &str)> = vec![
            (maps(1e3), "the heights of the scans look like m"),
            (maps(-1.0), "the heights of the scans have the other sign"),
            (log(1e3), "z_mm looks like m"),
            (log(1e-3), "z_mm looks like µm"),
            (log(-1.0), "z_mm has the other sign"),
            (SupposedMistake { turned: true, ..SupposedMistake::default() }, "nx, ny, nz point into the part"),
        ];
        if let Tool::Wheel(Wheel { radius, .. }) = self.tool.shape {
            known.push((
                SupposedMistake { lift: radius, ..SupposedMistake::default() },
                "z_mm is the wheel's lowest point, not its centre",
            ));
        }
        let known = known.into_iter().filter(|(supposed, _)| explains(*supposed)).map(|(_, words)| words.to_owned());
        let guesses: Vec<String> = known.chain(self.radius(gap)).collect();
        if guesses.is_empty() {
            let side = if gap > 0.0 { "above" } else { "below" };
            return vec![format!("the zero of z_mm lies {:.2} mm {side} that of the scans", 1e3 * gap.abs())];
        }
        guesses
    }

    /// The mistake in `radius_mm` that explains a gap.
    fn radius(&self, gap: f64) -> Option<String> {
        let Tool::Wheel(Wheel { radius, .. }) = self.tool.shape else { return None };
        let right = radius + gap;
        let near = |(factor, _): &&(f64, &str)| (right * factor / radius - 1.0).abs() < SAME_RADIUS;
        RADII.iter().find(near).map(|(_, words)| {
            format!("radius_mm = {} of {TRIAL_FILE} is {words}: {:.1} would touch", 1e3 * radius, 1e3 * right)
        })
    }
}

impl SupposedMistake {
    fn pose(self, pose: &ToolPose) -> ToolPose {
        let approach = if self.turned { -pose.approach } else { pose.approach };
        let centre = pose.centre * DVec3::new(1.0, 1.0, self.log_scale.unwrap_or(1.0)) + self.lift * approach;
        ToolPose { centre, approach, ..*pose }
    }
}

/// Distance that the tool must move against its approach axis to touch the map [m]; negative if it lies inside. `None`
/// if no pixel lies below it.
fn gap(tool: &HeldTool, pose: &ToolPose, (map, supposed): (&HeightMap, SupposedMistake)) -> Option<f64> {
    let (pixels, scale, disc) = (map.pixels, supposed.map_scale.unwrap_or(1.0), tool.shape.rim_radius());
    let lift = |(at, &height): (usize, &f64)| {
        let place = pixels.position(at % pixels.nx, at / pixels.nx);
        let from = place.extend(scale * height) - pose.centre;
        let up = from.dot(pose.approach);
        match &tool.shape {
            Tool::Wheel(Wheel { radius, width, .. }) => {
                let along = from.dot(pose.axis);
                let forward = (from.length_squared() - up * up - along * along).max(0.0);
                let is_below = along.abs() <= 0.5 * width && forward < radius * radius;
                is_below.then(|| up + (radius * radius - forward).sqrt())
            }
            _ => (from.length_squared() - up * up <= disc * disc).then_some(up),
        }
    };
    let known = map.heights.iter().enumerate().filter(|(_, height)| height.is_finite());
    known.filter_map(lift).reduce(f64::max).map(|lift| -lift)
}
