//! Cells that the depths at columns alone do not resolve: they are subdivided into sub-cells of a sixteenth of a voxel.
//!
//! This applies to every tool from a mesh, whose edges lie between columns, and to every tool that is held still.

use glam::DVec3;

use super::border::Border;
use super::patch::Patch;
use super::rows::UNRESOLVED;
use super::{ContactCells, HeightFieldFrame};
use crate::extent::Extent;
use crate::height_field::{HeightField, NO_SURFACE};
use crate::pose::Placement;
use robot::Tool;

/// Second difference below which depths count as a plane [pitches]: a thousand times the rounding error of the heights.
const STRAIGHT: f64 = 1e-6;
/// Sub-cells along a side of a cell in which the rim of the patch is searched for.
const RIM_CELLS: usize = 8;

impl ContactCells {
    /// Subdivides cells with curved depths from now on, whatever the tool.
    pub(crate) fn look_closer(&mut self) {
        self.is_subdivided = true;
    }

    /// True if cells are subdivided for this tool.
    pub(super) fn needs_subdivision(&self, border: &Border) -> bool {
        (self.is_subdivided || matches!(border.tool, Tool::Field(_))) && border.sweep == DVec3::ZERO
    }

    /// Marks the cells to be measured one by one: all that may be in contact, except cells that are entirely in or out
    /// of contact and whose depths lie on a plane.
    pub(super) fn unsettle(&mut self, height_field: &HeightField) {
        for (row, columns) in self.region.rows.clone().zip(self.columns.clone()) {
            for line in columns.map(|column| row * height_field.window.size[1] + column) {
                let is_settled = self.share[line] == 1.0 || self.share[line] == 0.0;
                let is_plain = is_settled && self.is_straight(height_field, line);
                if self.may_be_wet(height_field, line, 0.0) && !is_plain {
                    (self.mean_depth[line], self.share[line], self.area[line]) = (0.0, UNRESOLVED, 0.0);
                }
            }
        }
    }

    /// True if a point of a cell may lie deeper than `depth` [m]: depths change by at most the distance along the
    /// surface.
    pub(super) fn may_be_wet(&self, height_field: &HeightField, line: usize, depth: f64) -> bool {
        // Half a diagonal, and how much the slope may still change within the cell.
        let reach = 0.75 * height_field.pitch * (height_field.area_ratio(line) + 0.5);
        height_field.height[line] > NO_SURFACE && self.depth[line] + reach > depth
    }

    /// True if the depths at a column and its eight neighbours lie on a plane.
    pub(super) fn is_straight(&self, height_field: &HeightField, line: usize) -> bool {
        let across = height_field.window.size[1];
        let bend = |step: usize| self.depth[line - step] - 2.0 * self.depth[line] + self.depth[line + step];
        [1, across, across - 1, across + 1].into_iter().all(|step| bend(step).abs() <= STRAIGHT * height_field.pitch)
    }

    /// Measures a cell by subdivision.
    pub(super) fn measure_subdivided(&mut self, border: &Border, height_field: &HeightField, line: usize) {
        let patch = Patch::new((border.tool, &border.frame), height_field, line, self.depth[line]);
        let (mean, share) = patch.wet();
        if mean > 0.0 {
            (self.mean_depth[line], self.share[line], self.area[line]) = (mean, share, share);
            self.wet.push(line);
        }
    }

    /// Extent of the patch in the tool's frame, with rim and border located between columns; `None` without contact.
    pub(crate) fn extent(&self, place: &Placement, height_field: &HeightField) -> Option<Extent> {
        let (frame, across) = (HeightFieldFrame::new(&place.pose, height_field), height_field.window.size[1]);
        let is_full = |line: &usize| self.share[*line] == 1.0;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for line in self.wet.runs().iter().flat_map(|run| run.lines.clone()) {
            if [line, line - 1, line + 1, line - across, line + across].iter().all(is_full) {
                continue;
            }
            let patch = Patch::new((place.tool, &frame), height_field, line, self.depth[line]);
            rim_points(&patch, &mut |at| {
                let at = frame.local(patch.point(at));
                (low, high) = (low.min(at), high.max(at));
            });
        }
        (low.x <= high.x).then_some(Extent { x: (low.x, high.x), y: (low.y, high.y) })
    }
}

/// Points in contact on a fine lattice in a cell, and the points at which its lines cross the rim or the border.
fn rim_points(patch: &Patch, take: &mut impl FnMut([f64; 2])) {
    let place = |i: usize| i as f64 / RIM_CELLS as f64 - 0.5;
    let side = RIM_CELLS + 1;
    let looks: Vec<f64> = (0..side * side)
        .map(|i| patch.look([place(i / side), place(i % side)]))
        .map(|look| look.depth.min(look.within))
        .collect();
    for i in 0..side * side {
        let at = [place(i / side), place(i % side)];
        if looks[i] > 0.0 {
            take(at);
        }
        let next = [(i / side < RIM_CELLS).then_some(i + side), (i % side < RIM_CELLS).then_some(i + 1)];
        for (axis, next) in next.into_iter().enumerate() {
            if let Some(next) = next.filter(|&next| (looks[next] > 0.0) != (looks[i] > 0.0)) {
                let mut crossed = at;
                crossed[axis] += looks[i] / (looks[i] - looks[next]) / RIM_CELLS as f64;
                take(crossed);
            }
        }
    }
}
