//! The surface in one cell, and the depth of a tool at any of its points.
//!
//! The surface is the quadratic through a column and its eight neighbours. The tool is exact, with its kinks and its
//! border. Where depths at columns alone would miss an edge of the tool, the cell is subdivided recursively.

use glam::DVec3;

use super::{Difference, HeightFieldFrame};
use crate::clipped_cell::{ramp_mean, wet_share};
use crate::height_field::HeightField;
use robot::Tool;

/// Number of times that a cell is halved along both sides: sub-cells of a sixteenth of a voxel.
const HALVINGS: u32 = 4;
/// Relative difference between the depth at a sub-cell's middle and the mean of its quarters' middles below which the
/// depth in the sub-cell counts as quadratic.
const QUADRATIC: f64 = 0.01;
/// Steps that move a point outside the working surface to its border; each leaves an error of the square of the tilt.
const BORDER_STEPS: usize = 3;
/// Tolerances: distance outside the border, and distance beyond the cell [pitches].
const BORDER_TOLERANCES: (f64, f64) = (1e-6, 0.1);

/// The cell of a column.
pub(super) struct Patch<'a> {
    tool: &'a Tool,
    frame: &'a HeightFieldFrame,
    /// The column's point (u, v, up) [m].
    column: DVec3,
    /// Differences of the height across the cell [m].
    along: Difference,
    sideways: Difference,
    /// Mixed difference of the height [m].
    twist: f64,
    pitch: f64,
    /// Depth that effects add to the tool's shape [m].
    shift: f64,
    /// Largest distance along the surface per distance across the columns.
    stretch: f64,
}

/// Depth and border distance of a point under the tool [m].
#[derive(Clone, Copy)]
pub(super) struct PointDepth {
    pub(super) depth: f64,
    /// Distance inside the border of the working surface, negative outside.
    pub(super) within: f64,
}

/// A sub-cell of a cell; positions in pitches from the column.
#[derive(Clone, Copy)]
struct Cell {
    middle: [f64; 2],
    side: f64,
    look: PointDepth,
    /// Half of the change of the depth, and of the distance inside the border, across the sub-cell [m].
    spans: [(f64, f64); 2],
}

impl<'a> Patch<'a> {
    /// The cell of a column at which the tool is `depth` [m] deep.
    pub(super) fn new(
        (tool, frame): (&'a Tool, &'a HeightFieldFrame),
        height_field: &HeightField,
        line: usize,
        depth: f64,
    ) -> Self {
        let (across, pitch) = (height_field.window.size[1], height_field.pitch);
        let height = |line: usize| height_field.height[line];
        let along = Difference::new(height(line - across), height(line), height(line + across), pitch);
        let sideways = Difference::new(height(line - 1), height(line), height(line + 1), pitch);
        let corners = [line - across - 1, line - across + 1, line + across - 1, line + across + 1].map(height);
        let is_near = corners.iter().all(|corner| (corner - height(line)).abs() < 2.0 * pitch);
        let twist = if is_near { 0.25 * (corners[0] - corners[1] - corners[2] + corners[3]) } else { 0.0 };
        let column = height_field.point(line);
        let steepest = (along.mean.abs() + 0.5 * along.bend.abs() + 0.5 * twist.abs())
            .hypot(sideways.mean.abs() + 0.5 * sideways.bend.abs() + 0.5 * twist.abs());
        let shift = depth - tool.depth(frame.local(column));
        let stretch = 1f64.hypot(steepest / pitch);
        Self { tool, frame, column, along, sideways, twist, pitch, shift, stretch }
    }

    /// Largest distance along the surface from the column to a corner of a square of side `side` [m].
    pub(super) fn reach(&self, side: f64) -> f64 {
        0.5 * std::f64::consts::SQRT_2 * side * self.pitch * self.stretch
    }

    /// A position in pitches from the column as a point of the height field (u, v, up) [m].
    pub(super) fn point(&self, [u, v]: [f64; 2]) -> DVec3 {
        let Self { along, sideways, .. } = self;
        let bent = 0.5 * (along.bend * u * u + sideways.bend * v * v) + self.twist * u * v;
        self.column + DVec3::new(u * self.pitch, v * self.pitch, along.mean * u + sideways.mean * v + bent)
    }

    pub(super) fn look(&self, at: [f64; 2]) -> PointDepth {
        let at = self.frame.local(self.point(at));
        PointDepth { depth: self.tool.depth(at) + self.shift, within: self.tool.within(at) }
    }

    /// Mean over the cell of the positive part of the depth [m], and the share of the cell where it is positive.
    pub(super) fn wet(&self) -> (f64, f64) {
        let look = self.look([0.0; 2]);
        self.wet_in(&Cell { middle: [0.0; 2], side: 1.0, look, spans: [(0.0, 0.0); 2] }, HALVINGS)
    }

    fn wet_in(&self, cell: &Cell, halvings: u32) -> (f64, f64) {
        let reach = self.reach(cell.side);
        if cell.look.depth <= -reach || cell.look.within <= -reach {
            return (0.0, 0.0);
        }
        if halvings == 0 {
            return cell.wet_linear();
        }
        let quarters = self.quarters(cell);
        let depths = quarters.map(|quarter| quarter.look.depth);
        let mean = 0.25 * depths.iter().sum::<f64>();
        let bent = mean - cell.look.depth;
        let saddle = 0.25 * (depths[0] - depths[1] - depths[2] + depths[3]);
        let is_full = |quarter: &Cell| quarter.look.depth >= 0.5 * reach && quarter.look.within >= 0.5 * reach;
        if quarters.iter().all(is_full) && bent.abs().max(saddle.abs()) <= QUADRATIC * mean {
            // Exact for a quadratic: the quarters' middles see three quarters of its curvature.
            return (mean + bent / 3.0, 1.0);
        }
        let parts = quarters.map(|quarter| self.wet_in(&quarter, halvings - 1));
        parts.iter().fold((0.0, 0.0), |(mean, share), part| (mean + 0.25 * part.0, share + 0.25 * part.1))
    }

    fn quarters(&self, cell: &Cell) -> [Cell; 4] {
        let off = 0.25 * cell.side;
        let middles = [[-off, -off], [-off, off], [off, -off], [off, off]];
        let middles = middles.map(|[u, v]| [cell.middle[0] + u, cell.middle[1] + v]);
        let looks = middles.map(|at| self.look(at));
        let spans = |value: fn(&PointDepth) -> f64| {
            let [a, b, c, d] = looks.each_ref().map(value);
            (0.25 * ((c + d) - (a + b)).abs(), 0.25 * ((b + d) - (a + c)).abs())
        };
        let spans = [spans(|look| look.depth), spans(|look| look.within)];
        [0, 1, 2, 3].map(|i| Cell { middle: middles[i], side: 0.5 * cell.side, look: looks[i], spans })
    }

    /// The deepest point under the working surface: its depth [m] and position; `None` if none is deeper than `floor`
    /// [m].
    ///
    /// The best of nine by nine positions is taken; then the search is repeated around it at half the spacing until it
    /// improves no more.
    pub(super) fn top(&self, floor: f64) -> Option<(f64, [f64; 2])> {
        let (mut best, mut middle, mut half, mut idle) = (None, [0.0; 2], 0.5, 0);
        while half > 1e-7 && idle < 2 {
            let before = best.map_or(f64::NEG_INFINITY, |(depth, _)| depth);
            for step in 0..81 {
                let place =
                    |axis: usize, step: i32| (middle[axis] + half * (0.25 * f64::from(step - 4))).clamp(-0.5, 0.5);
                if let Some((depth, at)) = self.depth_inside([place(0, step / 9), place(1, step % 9)])
                    && best.is_none_or(|(deepest, _)| depth > deepest)
                {
                    best = Some((depth, at));
                }
            }
            let (depth, at) = best?;
            // No point between the positions is deeper than that: depths change by no more than the distance.
            if depth + self.reach(0.25 * half) <= floor {
                return None;
            }
            idle = if depth > before + 1e-12 { 0 } else { idle + 1 };
            (middle, half) = (at, 0.5 * half);
        }
        best.filter(|(depth, _)| *depth > floor)
    }

    /// Depth [m] at a position, or at the nearest position on the border if it lies outside the working surface.
    fn depth_inside(&self, mut at: [f64; 2]) -> Option<(f64, [f64; 2])> {
        for _ in 0..BORDER_STEPS {
            let place = self.frame.local(self.point(at));
            let within = self.tool.within(place);
            if within >= 0.0 {
                break;
            }
            let inward = match self.tool {
                Tool::Wheel(_) => self.frame.y * -place.y.signum(),
                _ => (self.frame.x * place.x + self.frame.y * place.y) / -place.x.hypot(place.y),
            };
            at = [at[0] - inward.x * within / self.pitch, at[1] - inward.y * within / self.pitch];
        }
        let look = self.look(at);
        let is_near = look.within >= -BORDER_TOLERANCES.0 * self.pitch
            && at.iter().all(|place| place.abs() <= 0.5 + BORDER_TOLERANCES.1);
        is_near.then_some((look.depth, at))
    }
}

impl Cell {
    /// Mean depth [m] and share in contact, with depth and border taken as linear.
    fn wet_linear(&self) -> (f64, f64) {
        let Self { look, spans, .. } = self;
        let cover = if look.within.is_finite() { wet_share(look.within, spans[1]) } else { 1.0 };
        (cover * ramp_mean(look.depth, spans[0]), cover * wet_share(look.depth, spans[0]))
    }
}
