//! The pixels that a tool did not touch.

use glam::DVec3;
use rayon::prelude::*;
use sdf_bake::HeightMap;

use crate::trial::{HeldTool, Pass, ToolPath, ToolPose};
use robot::{Tool, Wheel};

/// Distance to the tool that counts as touched [m]: covers errors of pose and scan, and grinding dust.
pub const CLEARANCE: f64 = 0.1e-3;
/// Poses closer together than this share of a pixel count as one.
const SAME_POSE: f64 = 0.5;
/// Poses that are first tested together.
const TOGETHER: usize = 16;
/// Distance that is far above the rounding of a gap [m].
const ROUNDING: f64 = 1e-8;

/// For each pixel, true if no point of the tool came closer to the surface than `clearance` [m] on the whole path.
///
/// - `surface`: the workpiece before the pass; pixels without a height count as touched
/// - `clearance`: for instance [`CLEARANCE`]
pub fn untouched(surface: &HeightMap, path: &ToolPath, tool: &HeldTool, clearance: f64) -> Vec<bool> {
    let poses = thinned(&path.poses, SAME_POSE * surface.pixels.pitch);
    let groups: Vec<PoseGroup> = poses.chunks(TOGETHER).map(PoseGroup::of).collect();
    let pixels = surface.pixels;
    let is_free = |at: usize| {
        let place = pixels.position(at % pixels.nx, at / pixels.nx);
        let point = place.extend(surface.heights[at]);
        point.is_finite() && groups.iter().all(|group| group.is_clear(tool, point, (pixels.pitch, clearance)))
    };
    (0..pixels.len()).into_par_iter().map(is_free).collect()
}

/// For each pixel, true if no point of the tool came closer than `clearance` [m] in any of some passes; see
/// [`untouched`].
pub fn untouched_in_passes(surface: &HeightMap, passes: &[Pass], tool: &HeldTool, clearance: f64) -> Vec<bool> {
    let mut free = vec![true; surface.heights.len()];
    for pass in passes {
        let alone = untouched(surface, &pass.tool_path(tool), tool, clearance);
        free.iter_mut().zip(alone).for_each(|(free, alone)| *free &= alone);
    }
    free
}

/// Successive poses.
struct PoseGroup<'a> {
    poses: &'a [ToolPose],
    middle: ToolPose,
    /// Greatest distance of a pose from the middle one [m]; infinite if the tool turns.
    spread: f64,
}

impl<'a> PoseGroup<'a> {
    /// The group of some poses, at least one.
    fn of(poses: &'a [ToolPose]) -> Self {
        let middle = poses[poses.len() / 2];
        let turns = |pose: &ToolPose| pose.axis != middle.axis || pose.approach != middle.approach;
        let distance = |pose: &ToolPose| if turns(pose) { f64::INFINITY } else { pose.centre.distance(middle.centre) };
        Self { poses, middle, spread: poses.iter().map(distance).fold(0.0, f64::max) }
    }

    /// Returns true if the gap at a point exceeds the clearance [m] in every pose.
    ///
    /// If the tool does not turn, a gap and a distance beside the face change by at most the distance that the tool
    /// moves. A point that is clear of the middle pose by the spread is then clear of every pose.
    fn is_clear(&self, tool: &HeldTool, point: DVec3, (pixel, clearance): (f64, f64)) -> bool {
        let reach = self.spread + ROUNDING;
        gap(tool, &self.middle, point, pixel + reach) > clearance + reach
            || self.poses.iter().all(|pose| gap(tool, pose, point, pixel) > clearance)
    }
}

/// Selects poses that lie at least `way` [m] from the previous selected one.
fn thinned(poses: &[ToolPose], way: f64) -> Vec<ToolPose> {
    let mut kept: Vec<ToolPose> = Vec::new();
    for pose in poses {
        if kept.last().is_none_or(|last| last.centre.distance(pose.centre) >= way) {
            kept.push(*pose);
        }
    }
    kept.extend(poses.last());
    kept
}

/// Distance [m] from a point to the tool's working face; infinite if the point is more than a pixel beside the face.
/// Any tool other than a wheel is taken as a disc.
fn gap(tool: &HeldTool, pose: &ToolPose, point: DVec3, pixel: f64) -> f64 {
    let from_centre = point - pose.centre;
    match &tool.shape {
        Tool::Wheel(Wheel { radius, width, .. }) => {
            let along = from_centre.dot(pose.axis);
            let radial = (from_centre.length_squared() - along * along).max(0.0).sqrt();
            if along.abs() <= 0.5 * width + pixel { radial - radius } else { f64::INFINITY }
        }
        disc => {
            let height = -from_centre.dot(pose.approach);
            let beside = (from_centre + pose.approach * height).length();
            if beside <= disc.rim_radius() + pixel { height } else { f64::INFINITY }
        }
    }
}
