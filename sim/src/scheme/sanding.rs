//! The sanding scheme: the surface stays as it is, and its coating gains the dose of Eq. (2).
//!
//! A step is evaluated at its middle, with the border and the depth of the working surface swept by the tool's motion.
//! So it may be much longer than a step in which the surface recedes. Height fields are as large as the path ahead
//! needs, and are kept.

use std::ops::Range;

use super::contact_integrals::{ApproachShare, ContactStep};
use super::contact_state::Side;
use super::dose::Dose;
use super::lanes::dot;
use super::{AppliedRemoval, EndForce, Scheme, StepLimits, WindowRequest};
use crate::clock::Phase;
use crate::contact::Ground;
use crate::extent::Extent;
use crate::height_field::{HeightField, Window};
use crate::lines::Lines;
use crate::physics::{InContact, Physics};
use crate::pose::{Placement, Pose};
use crate::record::Removal;
use crate::region::Region;
use crate::settings::{LONGEST_STEADY_STEP, LONGEST_STEP, Pass};
use effects::RunError;
use robot::Tool;
use sdf_bake::simd::in_wide_lanes;

/// Distance of a tool in one step [footprints], and longest such step [s].
const STEP: (f64, f64) = (0.04, LONGEST_STEP);
/// The same while the tool keeps its velocity, so that the middle of the step represents all of it.
const STEADY_STEP: (f64, f64) = (0.06, LONGEST_STEADY_STEP);
/// Relative change of the velocity up to which it counts as kept [1].
const STEADY: f64 = 0.05;
/// Distance of the tool on one height field [footprints]; the surface stays as it was read.
const HEIGHT_FIELD: f64 = 1.0;
/// Maximum number of columns of a height field, unless the next steps need more: about 40 MB.
const MOST_LINES: usize = 1 << 18;
/// Maximum number of poses of the path ahead that choose a window: a tool that hardly moves would need endless time.
const MOST_POSES: f64 = 1e5;

/// State of a step for each cell in contact; its buffers are reused by the next step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sanding {
    /// Columns that are evaluated.
    region: Region,
    /// Gap that effects add between tool and surface [m], by column; empty without any.
    gap: Vec<f64>,
    /// Columns of the height field that are in contact.
    lines: Lines,
    /// The tool in the middle of the step.
    middle: Side,
    /// Mean pressure over each lane's cell [Pa], and its decrease as the tool is lifted [Pa/m].
    load: Vec<f64>,
    stiffness: Vec<f64>,
    /// Zero for each lane: rate of the depth [m/s], and recession of the surface [m].
    zeros: Vec<f64>,
    dose: Dose,
    /// Area of each lane's cell that faces the approach axis [m²].
    facing: Vec<f64>,
}

impl Scheme for Sanding {
    fn recedes(&self) -> bool {
        false
    }

    fn step_limits(&self, pass: &Pass, voxel: f64) -> StepLimits {
        let Pass { tool, path, settings, .. } = *pass;
        let (step_way, footprint) = (settings.step_voxels * voxel, 2.0 * tool.half_footprint(f64::INFINITY).0);
        let longest = |piece: usize| {
            let (share, longest) = if path.is_steady(piece, STEADY, STEADY_STEP.1) { STEADY_STEP } else { STEP };
            StepLimits::longest_step(path, piece, (step_way.max(share * footprint), longest))
        };
        StepLimits {
            step_way: step_way.max(STEADY_STEP.0 * footprint),
            height_field_way: (settings.write_back_voxels * voxel).max(HEIGHT_FIELD * footprint),
            longest_steps: (0..path.pieces()).map(longest).collect(),
        }
    }

    /// As much as the tool will cross and one height field may hold.
    fn next_window(&self, ahead: &WindowRequest) -> (Window, f64) {
        let extent = Extent::of(ahead.tool, 2.0 * ahead.voxel).joined(&ahead.extent);
        let mut time = ahead.until_written.max(ahead.until_end);
        loop {
            let found = (ahead.window)(&extent, time, (time / LONGEST_STEP).ceil().clamp(1.0, MOST_POSES));
            if time <= ahead.until_written || found.0.lines() <= MOST_LINES {
                return found;
            }
            time = (0.5 * time).max(ahead.until_written);
        }
    }

    fn below(&self, search_reach: f64, _: f64) -> f64 {
        2.0 * search_reach
    }

    fn look_at(&mut self, region: Region) {
        self.region = region;
        self.middle.contact_cells.forget();
    }

    fn leave_height_field(&mut self) {}

    fn goes_on(&self) -> bool {
        true
    }

    /// Measured in the middle of the step, with the motion of the whole step as the sweep.
    fn measured<'a>(&self, tool: &'a Tool, times: Range<f64>, pose_at: &dyn Fn(f64) -> Pose) -> Placement<'a> {
        let sweep = pose_at(times.end).centre - pose_at(times.start).centre;
        Placement { tool, pose: pose_at(0.5 * (times.start + times.end)), sweep }
    }

    fn begin(&mut self, _: &Placement, _: &HeightField, _: &mut Physics) -> Result<(), RunError> {
        Ok(())
    }

    fn force_at(
        &mut self,
        place: &Placement,
        height_field: &HeightField,
        physics: &mut Physics,
        _: f64,
    ) -> Result<EndForce, RunError> {
        self.measure(place, height_field, physics)?;
        let Self { middle, lines, zeros, .. } = self;
        lines.clone_from(&middle.contact_cells.wet);
        middle.lanes.gather(&middle.contact_cells, lines);
        zeros.resize(lines.len(), 0.0);
        physics.place(place, &InContact { height_field, contact_cells: Some(&middle.contact_cells), lines });
        // Eq. (3), pressure.
        middle.lanes.press(physics, zeros)?;
        physics.lap(Phase::Model);
        // Eq. (4), force.
        let force = self.force(&place.pose, height_field);
        physics.lap(Phase::Integrate);
        Ok(force)
    }

    fn is_mean(&self) -> bool {
        true
    }

    fn gap(&self, place: &Placement, height_field: &HeightField) -> f64 {
        self.middle.contact_cells.deepest(place, height_field)
    }

    fn reaches_border(&self, height_field: &HeightField) -> bool {
        self.middle.contact_cells.reaches_border(height_field)
    }

    fn complete(
        &mut self,
        middle: &Placement,
        height_field: &HeightField,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<(), RunError> {
        let Self { middle: Side { centre, contact_cells, lanes }, lines, dose, .. } = self;
        let place = Placement { pose: Pose { centre: *centre, ..middle.pose }, ..*middle };
        physics.place_rest(&place, &InContact { height_field, contact_cells: Some(contact_cells), lines });
        // Eq. (2), dose.
        lanes.sand(physics)?;
        lanes.rate.resize(lines.len(), 0.0);
        dose.gain.clear();
        dose.gain.extend(lanes.dose_rate.iter().zip(&lanes.share).map(|(rate, share)| dt * rate * share));
        physics.lap(Phase::Model);
        Ok(())
    }

    fn step(&self) -> ContactStep<'_> {
        ContactStep {
            lines: &self.lines,
            start: &self.middle,
            end: &self.middle,
            facing: &self.facing,
            depth_rate: &self.zeros,
            recession: &self.zeros,
            mean_load: &self.load,
            end_load: &self.load,
            dose: &self.dose.gain,
        }
    }

    fn apply(&mut self, height_field: &mut HeightField, coating: f64) -> AppliedRemoval {
        let coating_volume = coating * self.dose.add_to(height_field, &self.lines);
        AppliedRemoval { removal: Removal { volume: 0.0, coating_volume }, receded: 0.0 }
    }
}

impl Sanding {
    /// Measures the cells: updates their depths if the tool only moved along its axis, otherwise measures all again.
    fn measure(
        &mut self,
        place: &Placement,
        height_field: &HeightField,
        physics: &mut Physics,
    ) -> Result<(), RunError> {
        let Self { region, gap, middle: Side { centre, contact_cells, .. }, .. } = self;
        *centre = place.pose.centre;
        let ground = Ground { height_field, region };
        physics.gap(place, &ground, gap)?;
        if !gap.is_empty() || !contact_cells.measure_deeper(place, height_field) {
            contact_cells.measure(place, &ground, gap);
        }
        physics.lap(Phase::Cells);
        Ok(())
    }

    /// Force under the pressures, and its slope; fills load, stiffness and facing.
    fn force(&mut self, pose: &Pose, height_field: &HeightField) -> EndForce {
        let Self { middle: Side { lanes, .. }, load, stiffness, facing, lines, .. } = self;
        load.resize(lines.len(), 0.0);
        stiffness.resize(lines.len(), 0.0);
        in_wide_lanes(
            #[inline(always)]
            || {
                ApproachShare::new(pose, height_field).fill(height_field, lines, facing);
                let (pressures, shares, depths) = (&lanes.pressure[..lines.len()], &lanes.share, &lanes.depth);
                for ((load, pressure), share) in load.iter_mut().zip(pressures).zip(shares) {
                    *load = pressure * share;
                }
                for ((stiffness, load), depth) in stiffness.iter_mut().zip(&*load).zip(depths) {
                    *stiffness = load / depth;
                }
                EndForce { force: dot(load, facing), stiffness: dot(stiffness, facing) }
            },
        )
    }
}
