//! The maximum depth of a cell, which may lie beside its column.

use std::ops::Range;

use glam::DVec3;

use super::patch::Patch;
use super::{Border, ContactCells, HeightFieldFrame};
use crate::height_field::{HeightField, NO_SURFACE};
use crate::pose::Placement;

/// Error bound of a column's height beside a side face [voxels].
const EDGE_ERROR: f64 = 0.05;
/// Distance from the part's edge within which such a column may be among a column's neighbours [pitches].
const AT_EDGE: f64 = 2.25;
/// Distance from the border within which a cell's neighbours may lie outside it [pitches].
const BESIDE: f64 = 3.0;

/// The deepest point under a working surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeepestPoint {
    /// Its depth [m]; negative when the tool is above the surface (the gap).
    pub(crate) depth: f64,
    /// The column in whose cell it lies.
    pub(crate) line: usize,
    /// Its position (u, v, up) [m].
    pub(crate) point: DVec3,
}

impl ContactCells {
    /// The deepest point under the working surface, also between columns and at the border; `None` without a surface.
    /// Beside a side face the height of a column is less certain, and its depth is reduced by the error bound.
    pub(crate) fn peak(&self, place: &Placement, height_field: &HeightField) -> Option<DeepestPoint> {
        let (tool, frame) = (place.tool, HeightFieldFrame::new(&place.pose, height_field));
        let lines: Vec<usize> =
            self.under(place, height_field).filter(|&line| height_field.height[line] > NO_SURFACE).collect();
        let within = |line: usize| tool.within(frame.local(height_field.point(line)));
        let mut best: Option<DeepestPoint> = None;
        for &line in lines.iter().filter(|&&line| within(line) >= 0.0) {
            let depth = self.depth[line] - self.unsure(height_field, line);
            if best.is_none_or(|best| depth > best.depth) {
                best = Some(DeepestPoint { depth, line, point: height_field.point(line) });
            }
        }
        let edges = height_field.edge_distances();
        for line in lines {
            // The surface between columns is as uncertain as the heights of the neighbours.
            let is_at_edge = edges[line] < AT_EDGE * height_field.pitch;
            let unsure = if is_at_edge { EDGE_ERROR * height_field.pitch } else { self.unsure(height_field, line) };
            let floor = best.map_or(f64::NEG_INFINITY, |best| best.depth + unsure);
            // On a plane a neighbour is deeper.
            let is_plain = within(line) > BESIDE * height_field.pitch && self.is_straight(height_field, line);
            if is_plain || !self.may_be_wet(height_field, line, floor) {
                continue;
            }
            let patch = Patch::new((tool, &frame), height_field, line, self.depth[line]);
            if let Some((depth, at)) = patch.top(floor) {
                best = Some(DeepestPoint { depth: depth - unsure, line, point: patch.point(at) });
            }
        }
        best
    }

    /// Largest depth under the working surface [m]; negative when the tool is above the surface (the gap).
    pub fn deepest(&self, place: &Placement, height_field: &HeightField) -> f64 {
        let border = Border::new(&Placement::still(place.tool, place.pose), height_field);
        let mut deepest = f64::NEG_INFINITY;
        for line in self.region.lines(height_field.window.size[1]) {
            if self.depth[line] > deepest && border.cover(height_field, line).share > 0.0 {
                deepest = self.depth[line];
            }
        }
        deepest
    }

    /// Columns under the working surface of a tool that does not sweep.
    fn under(&self, place: &Placement, height_field: &HeightField) -> impl Iterator<Item = usize> {
        let border = Border::new(&Placement::still(place.tool, place.pose), height_field);
        self.region.lines(height_field.window.size[1]).filter(move |&line| border.cover(height_field, line).share > 0.0)
    }

    /// Error bound of a cell's depth [m], by which it may be less deep than its column.
    fn unsure(&self, height_field: &HeightField, line: usize) -> f64 {
        let (along, sideways) = self.differences(line, height_field.window.size[1], height_field.pitch);
        if along.is_whole && sideways.is_whole { 0.0 } else { EDGE_ERROR * height_field.pitch }
    }

    /// Depth [m] at the vertex of the parabolas through a column and its neighbours, if it lies in the column's cell.
    pub fn top(&self, height_field: &HeightField, line: usize) -> f64 {
        let (along, sideways) = self.differences(line, height_field.window.size[1], height_field.pitch);
        self.depth[line] + along.rise() + sideways.rise()
    }

    /// True if the maximum pressure in any cell of a run may exceed `highest` [Pa], from the pressures [Pa] at the mean
    /// depths [m]. The bound needs no division: a parabola's vertex in a cell lies above the column by at most a
    /// quarter of its change across the cell.
    #[inline(always)]
    pub(crate) fn may_exceed(
        &self,
        highest: f64,
        (pressures, depths): (&[f64], &[f64]),
        run: Range<usize>,
        height_field: &HeightField,
    ) -> bool {
        let (across, first, count) = (height_field.window.size[1], run.start, run.len());
        let from = |line: usize| &self.depth[line..line + count];
        let (here, before, after) = (from(first), from(first - across), from(first + across));
        let (left, right) = (from(first - 1), from(first + 1));
        let (pressures, depths) = (&pressures[..count], &depths[..count]);
        let mut any = false;
        for i in 0..count {
            let rise = mean_size(before[i], here[i], after[i], height_field.pitch)
                + mean_size(left[i], here[i], right[i], height_field.pitch);
            let top = here[i] + 0.26 * rise;
            any |= (pressures[i] > highest) | (pressures[i] * top > highest * depths[i]);
        }
        any
    }
}

/// Magnitude of the first difference across a cell; a neighbour beyond a side face does not count.
#[inline(always)]
fn mean_size(before: f64, here: f64, after: f64, pitch: f64) -> f64 {
    let (down, up) = ((before - here).abs(), (after - here).abs());
    let (is_near_before, is_near_after) = (down < 2.0 * pitch, up < 2.0 * pitch);
    let one = if is_near_before { down } else { 0.0 } + if is_near_after { up } else { 0.0 };
    if is_near_before & is_near_after { 0.5 * (after - before).abs() } else { one }
}
