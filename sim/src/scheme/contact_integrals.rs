//! Integrals of a step over the cells in contact.

use glam::DVec3;

use super::contact_state::{ContactState, Side};
use super::lanes::{Bounds, PARTS, dot};
use crate::contact::{Contact, DeepestPoint, HeightFieldFrame};
use crate::covariates::ContactCell;
use crate::extent::Extent;
use crate::height_field::HeightField;
use crate::lines::{Lines, Run};
use crate::physics::Physics;
use crate::pose::{Placement, Pose};
use crate::tool_cells::{CellLoad, CellSums, ToolCells};
use crate::wrench::Wrench;
use effects::Variable;
use sdf_bake::simd::in_wide_lanes;

/// Number of cells that are tested together for the highest pressure.
const LOOKED_AT: usize = 32;

/// Share of a cell's lattice area that faces the approach axis, n·a / n·up.
pub(super) struct ApproachShare(DVec3);

impl ApproachShare {
    pub(super) fn new(pose: &Pose, height_field: &HeightField) -> Self {
        Self(height_field.facing.height_field(pose.approach))
    }

    pub(super) fn of(&self, height_field: &HeightField, line: usize) -> f64 {
        let [u, v] = height_field.slope[line];
        (self.0.z - u * self.0.x - v * self.0.y).max(0.0)
    }

    /// Area of each column's cell that faces the approach axis [m²].
    #[inline(always)]
    pub(super) fn fill(&self, height_field: &HeightField, lines: &Lines, out: &mut Vec<f64>) {
        let area = height_field.pitch * height_field.pitch;
        out.resize(lines.len(), 0.0);
        for Run { lines, lanes } in lines.runs() {
            for (facing, [u, v]) in out[lanes.clone()].iter_mut().zip(&height_field.slope[lines.clone()]) {
                *facing = area * (self.0.z - u * self.0.x - v * self.0.y).max(0.0);
            }
        }
    }

    /// The same in the processor's widest SIMD lanes.
    pub(super) fn fill_wide(&self, height_field: &HeightField, lines: &Lines, out: &mut Vec<f64>) {
        in_wide_lanes(
            #[inline(always)]
            || self.fill(height_field, lines, out),
        );
    }
}

/// Result of a step for the cells in contact, one lane each.
pub(crate) struct ContactStep<'a> {
    /// Columns of the height field in contact.
    pub(crate) lines: &'a Lines,
    /// The tool at the step's start and end; both are its middle in a scheme with one evaluation.
    pub(super) start: &'a Side,
    pub(super) end: &'a Side,
    /// Area of each lane's cell that faces the approach axis [m²].
    pub(super) facing: &'a [f64],
    /// Rate at which the depth grows by the tool's motion, without recession [m/s].
    pub(super) depth_rate: &'a [f64],
    /// Recession, mean over the cell [m].
    pub(super) recession: &'a [f64],
    /// Mean over the cell of the pressure, averaged over the step, and at its end [Pa].
    pub(super) mean_load: &'a [f64],
    pub(super) end_load: &'a [f64],
    /// Dose gained, mean over the cell [1].
    pub(super) dose: &'a [f64],
}

impl ContactStep<'_> {
    /// Contact averaged over the step, with the moment left at 0, and the force at its end after recession [N].
    pub(crate) fn contact(&self, height_field: &HeightField) -> (Contact, f64) {
        in_wide_lanes(
            #[inline(always)]
            || {
                let (load, area) = self.load_and_area(height_field);
                let force = dot(self.mean_load, self.facing);
                let pressure_max = self.pressure_max(height_field);
                let contact = Contact { force, load, area, pressure_max, ..Contact::default() };
                (contact, dot(self.end_load, self.facing))
            },
        )
    }

    /// Load [N] and area [m²] of the contact.
    #[inline(always)]
    fn load_and_area(&self, height_field: &HeightField) -> (f64, f64) {
        let (mut load, mut area) = (0.0, 0.0);
        for Run { lines, lanes } in self.lines.runs() {
            load += dot(&self.mean_load[lanes.clone()], &height_field.area_ratios()[lines.clone()]);
            let facing = &self.facing[lanes.clone()];
            let of = |side: &Side| dot(&side.contact_cells.area[lines.clone()], facing);
            area += 0.5 * (of(self.start) + of(self.end));
        }
        (load * (height_field.pitch * height_field.pitch), area)
    }

    /// Highest pressure [Pa]. A lane's pressure belongs to the cell's mean depth; the cell's middle may be deeper.
    #[inline(always)]
    fn pressure_max(&self, height_field: &HeightField) -> f64 {
        let Side { lanes: start, contact_cells, .. } = self.start;
        let mut highest = 0.0f64;
        for Run { lines: run, lanes } in self.lines.runs() {
            for first in (0..run.len()).step_by(LOOKED_AT) {
                let places = first..run.len().min(first + LOOKED_AT);
                let lanes = lanes.start + places.start..lanes.start + places.end;
                let lines = run.start + places.start..run.start + places.end;
                let lanes_of = (&start.pressure[lanes.clone()], &start.depth[lanes.clone()]);
                if !contact_cells.may_exceed(highest, lanes_of, lines.clone(), height_field) {
                    continue;
                }
                for (line, lane) in lines.zip(lanes).filter(|(_, lane)| start.share[*lane] > 0.0) {
                    let peak = (contact_cells.top(height_field, line) / start.depth[lane]).max(1.0);
                    highest = highest.max(start.pressure[lane] * peak);
                }
            }
        }
        highest
    }

    /// Highest pressure [Pa] at the start of the step: the highest at a cell's mean depth, or that at the deepest
    /// point, scaled by the ratio of the depths.
    pub(crate) fn pressure_to(&self, peak: Option<&DeepestPoint>) -> f64 {
        let start = &self.start.lanes;
        let wet = |lane: &usize| start.share[*lane] > 0.0;
        let highest = (0..self.lines.len()).filter(wet).map(|lane| start.pressure[lane]).fold(0.0, f64::max);
        let lane_of =
            |peak: &DeepestPoint| self.lines.list().iter().position(|&line| line as usize == peak.line).filter(wet);
        let at =
            |peak: &DeepestPoint| lane_of(peak).map(|lane| start.pressure[lane] * (peak.depth / start.depth[lane]));
        peak.and_then(at).map_or(highest, |pressure| highest.max(pressure))
    }

    /// The deepest point under the working surface at the start of the step; `None` where there is no surface.
    pub(crate) fn start_peak(&self, place: &Placement, height_field: &HeightField) -> Option<DeepestPoint> {
        self.start.contact_cells.peak(place, height_field)
    }

    /// Extent of the contact at the end of the step, up to its rim; `None` without contact.
    pub(crate) fn patch(&self, place: &Placement, height_field: &HeightField) -> Option<Extent> {
        self.end.contact_cells.extent(place, height_field)
    }

    /// Moment of the mean force about the tool's reference point [N m].
    pub(crate) fn moment(&self, pose: &Pose, height_field: &HeightField) -> DVec3 {
        let area = height_field.pitch * height_field.pitch;
        let normal = ApproachShare::new(pose, height_field);
        let moment = |(load, &line): (&f64, &u32)| {
            let arm = height_field.facing.world(height_field.point(line as usize)) - pose.centre;
            arm.cross(pose.approach) * (load * area * normal.of(height_field, line as usize))
        };
        self.mean_load.iter().zip(self.lines.list()).map(moment).sum()
    }

    /// Wrench at the end of the step about a pose's reference point. `drag` is the friction per normal force at a point
    /// of the workpiece's frame [m].
    pub(crate) fn wrench(&self, pose: &Pose, height_field: &HeightField, drag: impl Fn(DVec3) -> DVec3) -> Wrench {
        let area = height_field.pitch * height_field.pitch;
        let mut wrench = Wrench::default();
        for (load, &line) in self.end_load.iter().zip(self.lines.list()) {
            let [u, v] = height_field.slope[line as usize];
            let point = height_field.facing.world(height_field.point(line as usize));
            // p n dA, with n dA = (-slope, 1) du dv.
            let normal = height_field.facing.world(DVec3::new(-u, -v, 1.0)) * (load * area);
            wrench.add(normal + drag(point) * normal.length(), point - pose.centre);
        }
        wrench
    }

    /// Results of the step for each cell in contact.
    pub(crate) fn contact_cells(&self) -> impl Iterator<Item = ContactCell> {
        self.lines.list().iter().enumerate().map(|(lane, &line)| ContactCell {
            line: line as usize,
            share: 0.5 * (self.start.lanes.share[lane] + self.end.lanes.share[lane]),
            load: self.mean_load[lane],
            recession: self.recession[lane],
            dose: self.dose[lane],
        })
    }

    /// Results for each cell of the tool: means over its contact, and the amounts removed under it.
    pub(crate) fn cell_sums(
        &self,
        place: &Placement,
        height_field: &HeightField,
        physics: &Physics,
        dt: f64,
    ) -> CellSums {
        let mut sums = CellSums::default();
        let (places, frame) = (ToolCells::of(place.tool), HeightFieldFrame::new(&place.pose, height_field));
        for (cell, &line) in self.contact_cells().zip(self.lines.list()) {
            let at = frame.local(height_field.point(line as usize));
            sums.add(
                places.place(at),
                &CellLoad {
                    share: cell.share,
                    load: cell.load,
                    slip_speed: physics.slip_speed(place.tool, at),
                    recession: cell.recession / dt,
                    dose: cell.dose / dt,
                    surface: height_field.pitch * height_field.pitch * height_field.area_ratio(line as usize),
                    coating: physics.coating,
                },
            );
        }
        sums
    }

    /// Extent of the contact; `None` without contact.
    pub(crate) fn extent(&self, pose: &Pose, height_field: &HeightField) -> Option<Extent> {
        let (x, y) = in_wide_lanes(
            #[inline(always)]
            || self.bounds(&HeightFieldFrame::new(pose, height_field), height_field),
        );
        (!self.lines.is_empty()).then_some(Extent { x, y })
    }

    /// Bounds of the contact along the tool's x and y [m].
    #[inline(always)]
    fn bounds(&self, frame: &HeightFieldFrame, height_field: &HeightField) -> ((f64, f64), (f64, f64)) {
        let (mut x, mut y) = (Bounds::NONE, Bounds::NONE);
        if frame.is_upright() {
            // If heights do not matter, the ends of a run lie furthest out.
            let ends = self.lines.runs().iter().flat_map(|Run { lines, .. }| [lines.start, lines.end - 1]);
            for at in ends.map(|line| frame.local(height_field.point(line))) {
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
            let (places, last) = height_field.places()[lines.clone()].as_chunks::<PARTS>();
            let (heights, last_heights) = height_field.height[lines.clone()].as_chunks::<PARTS>();
            for (places, heights) in places.iter().zip(heights) {
                (0..PARTS).for_each(|part| take(part, places[part], heights[part]));
            }
            last.iter().zip(last_heights).for_each(|(place, height)| take(0, *place, *height));
        }
        (x.range(), y.range())
    }

    /// Variables of the workpiece's cells at the end of the step, one value per lane.
    pub(crate) fn means(&self) -> [(Variable, &[f64]); 5] {
        let ContactState { depth, pressure, rate, dose_rate, .. } = &self.end.lanes;
        [
            (Variable::Depth, depth),
            (Variable::DepthRate, self.depth_rate),
            (Variable::Pressure, pressure),
            (Variable::Rate, rate),
            (Variable::DoseRate, dose_rate),
        ]
    }
}
