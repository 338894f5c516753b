//! What a step did, summed over the squares in contact.

use glam::DVec3;

use super::Step;
use super::lanes::{Bounds, PARTS, dot};
use crate::contact::{Contact, Peak, SheetFrame};
use crate::covariates::Square;
use crate::extent::Extent;
use crate::lines::{Lines, Run};
use crate::physics::Physics;
use crate::sheet::Sheet;
use crate::tool::{Pose, Tool};
use crate::tool_cells::{CellSums, ToolCells, Under};
use sdf_bake::simd::in_wide_lanes;

/// Squares that are looked at together for the highest pressure.
const LOOKED_AT: usize = 32;

/// Share of a square's lattice area that faces the approach axis, n·a / n·up.
pub(super) struct ApproachShare(DVec3);

impl ApproachShare {
    pub(super) fn new(pose: &Pose, sheet: &Sheet) -> Self {
        Self(sheet.facing.sheet(pose.approach))
    }

    pub(super) fn of(&self, sheet: &Sheet, line: usize) -> f64 {
        let [u, v] = sheet.slope[line];
        (self.0.z - u * self.0.x - v * self.0.y).max(0.0)
    }

    /// Area of each line's square that faces the approach axis [m²].
    #[inline(always)]
    pub(super) fn fill(&self, sheet: &Sheet, lines: &Lines, out: &mut Vec<f64>) {
        let area = sheet.pitch * sheet.pitch;
        out.resize(lines.len(), 0.0);
        for Run { lines, lanes } in lines.runs() {
            for (facing, [u, v]) in out[lanes.clone()].iter_mut().zip(&sheet.slope[lines.clone()]) {
                *facing = area * (self.0.z - u * self.0.x - v * self.0.y).max(0.0);
            }
        }
    }
}

impl Step {
    /// What the tool meets, as a mean over the step, but for the moment; and the force at its end, after what it takes off [N].
    pub fn contact(&mut self, pose: &Pose, sheet: &Sheet) -> (Contact, f64) {
        let mut facing = std::mem::take(&mut self.facing);
        let result = in_wide_lanes(
            #[inline(always)]
            || {
                if !self.is_whole {
                    ApproachShare::new(pose, sheet).fill(sheet, &self.lines, &mut facing);
                }
                let (load, area) = self.load_and_area(sheet, &facing);
                let force = dot(&self.relaxed.mean_load, &facing);
                let pressure_max = self.pressure_max(sheet);
                let end_force = if self.is_whole { force } else { dot(&self.relaxed.end_load, &facing) };
                (Contact { force, load, area, pressure_max, ..Contact::default() }, end_force)
            },
        );
        self.facing = facing;
        result
    }

    /// Load [N] and area [m²] of the contact.
    #[inline(always)]
    fn load_and_area(&self, sheet: &Sheet, facing: &[f64]) -> (f64, f64) {
        let (start, end) = (self.start_squares(), &self.end_squares);
        let (mut load, mut area) = (0.0, 0.0);
        for Run { lines, lanes } in self.lines.runs() {
            load += dot(&self.relaxed.mean_load[lanes.clone()], &sheet.area_ratios()[lines.clone()]);
            let facing = &facing[lanes.clone()];
            let end = dot(&end.area[lines.clone()], facing);
            area += if self.is_whole { end } else { 0.5 * (dot(&start.area[lines.clone()], facing) + end) };
        }
        (load * (sheet.pitch * sheet.pitch), area)
    }

    /// Highest pressure [Pa]. That of a lane belongs to the square's mean depth; its middle may be deeper.
    #[inline(always)]
    fn pressure_max(&self, sheet: &Sheet) -> f64 {
        let (start, squares) = (self.start(), self.start_squares());
        let mut highest = 0.0f64;
        for Run { lines: run, lanes } in self.lines.runs() {
            for first in (0..run.len()).step_by(LOOKED_AT) {
                let places = first..run.len().min(first + LOOKED_AT);
                let lanes = lanes.start + places.start..lanes.start + places.end;
                let lines = run.start + places.start..run.start + places.end;
                let lanes_of = (&start.pressure[lanes.clone()], &start.depth[lanes.clone()]);
                if !squares.may_exceed(highest, lanes_of, lines.clone(), sheet) {
                    continue;
                }
                for (line, lane) in lines.zip(lanes).filter(|(_, lane)| start.share[*lane] > 0.0) {
                    let peak = (squares.top(sheet, line) / start.depth[lane]).max(1.0);
                    highest = highest.max(start.pressure[lane] * peak);
                }
            }
        }
        highest
    }

    /// Highest pressure [Pa] at the start of the step: that at a square's mean depth, or at the deepest point, which is as
    /// much higher as it lies deeper.
    pub(crate) fn pressure_to(&self, peak: Option<&Peak>) -> f64 {
        let start = self.start();
        let wet = |lane: &usize| start.share[*lane] > 0.0;
        let highest = (0..self.lines.len()).filter(wet).map(|lane| start.pressure[lane]).fold(0.0, f64::max);
        let lane_of = |peak: &Peak| self.lines.list().iter().position(|&line| line as usize == peak.line).filter(wet);
        let at = |peak: &Peak| lane_of(peak).map(|lane| start.pressure[lane] * (peak.depth / start.depth[lane]));
        peak.and_then(at).map_or(highest, |pressure| highest.max(pressure))
    }

    /// Extent of the contact at the end of the step, to its rim; `None` without any.
    pub(crate) fn patch(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> Option<Extent> {
        self.end_squares.extent(tool, pose, sheet)
    }

    /// Moment of the mean force about the tool's reference point [N m].
    pub fn moment(&self, pose: &Pose, sheet: &Sheet) -> DVec3 {
        let area = sheet.pitch * sheet.pitch;
        let normal = ApproachShare::new(pose, sheet);
        let moment = |(load, &line): (&f64, &u32)| {
            let arm = sheet.facing.world(sheet.point(line as usize)) - pose.centre;
            arm.cross(pose.approach) * (load * area * normal.of(sheet, line as usize))
        };
        self.relaxed.mean_load.iter().zip(self.lines.list()).map(moment).sum()
    }

    /// What happened to each square in contact.
    pub(crate) fn squares(&self) -> impl Iterator<Item = Square> {
        self.lines.list().iter().enumerate().map(|(lane, &line)| Square {
            line: line as usize,
            share: 0.5 * (self.start().share[lane] + self.end.share[lane]),
            load: self.relaxed.mean_load[lane],
            recession: self.relaxed.recession[lane],
            dose: self.dose[lane],
        })
    }

    /// What happened under each cell of the tool: means over its contact, and what was taken under it.
    pub fn cell_sums(&self, (tool, pose): (&Tool, &Pose), sheet: &Sheet, physics: &Physics, dt: f64) -> CellSums {
        let mut sums = CellSums::default();
        let (places, frame) = (ToolCells::of(tool), SheetFrame::new(pose, sheet));
        for (square, &line) in self.squares().zip(self.lines.list()) {
            let at = frame.local(sheet.point(line as usize));
            sums.add(
                places.place(at),
                &Under {
                    share: square.share,
                    load: square.load,
                    slip_speed: physics.slip_speed(tool, at),
                    recession: square.recession / dt,
                    dose: square.dose / dt,
                    surface: sheet.pitch * sheet.pitch * sheet.area_ratio(line as usize),
                    coating: physics.coating,
                },
            );
        }
        sums
    }

    /// Extent of the contact; `None` without any.
    pub fn extent(&self, pose: &Pose, sheet: &Sheet) -> Option<Extent> {
        let (x, y) = in_wide_lanes(
            #[inline(always)]
            || self.bounds(&SheetFrame::new(pose, sheet), sheet),
        );
        (!self.lines.is_empty()).then_some(Extent { x, y })
    }

    /// Bounds of the contact along the tool's x and y [m].
    #[inline(always)]
    fn bounds(&self, frame: &SheetFrame, sheet: &Sheet) -> ((f64, f64), (f64, f64)) {
        let (mut x, mut y) = (Bounds::NONE, Bounds::NONE);
        if frame.is_upright() {
            // Where heights do not matter, the ends of a run lie furthest out.
            let ends = self.lines.runs().iter().flat_map(|Run { lines, .. }| [lines.start, lines.end - 1]);
            for at in ends.map(|line| frame.local(sheet.point(line))) {
                x.take(0, at.x);
                y.take(0, at.y);
            }
            return (x.range(), y.range());
        }
        let mut take = |part: usize, [u, v]: [f64; 2], height: f64| {
            let at = frame.local(DVec3::new(u, v, height));
            x.take(part, at.x);
            y.take(part, at.y);
        };
        for Run { lines, .. } in self.lines.runs() {
            let (places, last) = sheet.places()[lines.clone()].as_chunks::<PARTS>();
            let (heights, last_heights) = sheet.height[lines.clone()].as_chunks::<PARTS>();
            for (places, heights) in places.iter().zip(heights) {
                (0..PARTS).for_each(|part| take(part, places[part], heights[part]));
            }
            last.iter().zip(last_heights).for_each(|(place, height)| take(0, *place, *height));
        }
        (x.range(), y.range())
    }

    /// Largest recession of a square in this step [m].
    pub fn recession_max(&self) -> f64 {
        self.relaxed.recession.iter().copied().fold(0.0, f64::max)
    }
}
