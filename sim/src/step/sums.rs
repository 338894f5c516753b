//! What a step did, summed over the squares in contact.

use glam::DVec3;

use super::Step;
use crate::contact::{Contact, SheetFrame};
use crate::covariates::Square;
use crate::extent::Extent;
use crate::physics::Physics;
use crate::sheet::Sheet;
use crate::tool::{Pose, Tool};
use crate::tool_cells::{CellSums, ToolCells, Under};

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
}

impl Step {
    /// What the tool meets, as a mean over the step, but for the moment.
    pub fn contact(&self, pose: &Pose, sheet: &Sheet) -> Contact {
        let area = sheet.pitch * sheet.pitch;
        let normal = ApproachShare::new(pose, sheet);
        let (start, squares) = (self.start(), self.start_squares());
        let mut contact = Contact::default();
        for (lane, &line) in self.lines.iter().enumerate() {
            let line = line as usize;
            let facing = area * normal.of(sheet, line);
            contact.force += self.relaxed.mean_load[lane] * facing;
            contact.load += self.relaxed.mean_load[lane] * area * sheet.area_ratio(line);
            contact.area += 0.5 * (squares.area[line] + self.end_squares.area[line]) * facing;
            // The pressure belongs to the square's mean depth; its middle may be deeper.
            let (pressure, depth) = (start.pressure[lane], start.depth[lane]);
            let highest = contact.pressure_max;
            let may_exceed = || pressure * squares.top_at_most(sheet, line) > highest * depth * (1.0 - 1e-9);
            if start.share[lane] > 0.0 && (pressure > highest || may_exceed()) {
                let peak = (squares.top(sheet, line) / depth).max(1.0);
                contact.pressure_max = highest.max(pressure * peak);
            }
        }
        contact
    }

    /// Moment of the mean force about the tool's reference point [N m].
    pub fn moment(&self, pose: &Pose, sheet: &Sheet) -> DVec3 {
        let area = sheet.pitch * sheet.pitch;
        let normal = ApproachShare::new(pose, sheet);
        let moment = |(load, &line): (&f64, &u32)| {
            let arm = sheet.facing.world(sheet.point(line as usize)) - pose.centre;
            arm.cross(pose.approach) * (load * area * normal.of(sheet, line as usize))
        };
        self.relaxed.mean_load.iter().zip(&self.lines).map(moment).sum()
    }

    /// Force at the end of the step, after what it takes off [N].
    pub fn end_force(&self, pose: &Pose, sheet: &Sheet) -> f64 {
        let normal = ApproachShare::new(pose, sheet);
        let force = |(&line, load): (&u32, &f64)| load * normal.of(sheet, line as usize);
        sheet.pitch * sheet.pitch * self.lines.iter().zip(&self.relaxed.end_load).map(force).sum::<f64>()
    }

    /// What happened to each square in contact.
    pub(crate) fn squares(&self) -> impl Iterator<Item = Square> {
        self.lines.iter().enumerate().map(|(lane, &line)| Square {
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
        for (square, &line) in self.squares().zip(&self.lines) {
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
        let frame = SheetFrame::new(pose, sheet);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &line in &self.lines {
            let at = frame.local(sheet.point(line as usize));
            (low, high) = (low.min(at), high.max(at));
        }
        (!self.lines.is_empty()).then_some(Extent { x: (low.x, high.x), y: (low.y, high.y) })
    }

    /// Largest recession of a square in this step [m].
    pub fn recession_max(&self) -> f64 {
        self.relaxed.recession.iter().copied().fold(0.0, f64::max)
    }
}
