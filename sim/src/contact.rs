//! The contact patch: where a tool overlaps the workpiece, and how deep.
//!
//! The patch is cut into the squares around the sheet's columns. Within a square the depth is taken as linear where
//! the patch's rim or the border of the working surface crosses it, and integrated exactly; inside the patch it is taken
//! as quadratic. So sums over squares are second order in the voxel size.

use glam::DVec3;
use serde::Serialize;

use crate::ramp::{ramp_mean, wet_share};
use crate::sheet::Sheet;
use crate::tool::{Pose, Tool};

/// How far the height of a column beside a wall may be off [voxels].
const EDGE_ERROR: f64 = 0.05;

/// What a tool meets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Contact {
    /// Normal force `F = ∫ p n·a dA` along the approach axis a [N].
    pub force: f64,
    /// `∫ p dA` over the surface itself [N]: what drives removal.
    pub load: f64,
    /// Moment of the normal force about the tool's reference point [N m].
    pub moment: DVec3,
    /// Area under pressure, projected along the approach axis [m²].
    pub area: f64,
    /// Highest pressure [Pa].
    pub pressure_max: f64,
}

impl Contact {
    /// Force over area [Pa]; 0 without contact.
    pub fn pressure_mean(&self) -> f64 {
        if self.area > 0.0 { self.force / self.area } else { 0.0 }
    }
}

/// How deep the squares of a sheet lie under a tool; buffers that are filled again and again.
#[derive(Clone, Debug, Default)]
pub struct Squares {
    /// Depth at the column itself [m], negative in the air.
    pub depth: Vec<f64>,
    /// Mean over the square of the depth where it is positive, 0 elsewhere [m].
    pub mean_depth: Vec<f64>,
    /// Share of the square that is under the working surface and in contact where the depth is linear.
    pub share: Vec<f64>,
    /// The same with the depth's curvature along the rim: the patch's area.
    pub area: Vec<f64>,
}

impl Squares {
    /// Measures a tool over a sheet. `gap` [m], one per column or empty, is how much further away the tool's
    /// surface is than its shape says. Squares on the window's border are left out. The border of the working surface
    /// is taken as the mean over a `sweep` [m] of the tool about its pose.
    pub fn measure(&mut self, tool: &Tool, pose: &Pose, sheet: &Sheet, (gap, sweep): (&[f64], DVec3)) {
        let (frame, sweep) = (SheetFrame::new(pose, sheet), sheet.facing.sheet(sweep));
        self.measure_depths(tool, &frame, sheet);
        for (depth, gap) in self.depth.iter_mut().zip(gap) {
            *depth -= gap;
        }
        let lines = sheet.window.lines();
        self.mean_depth.clear();
        self.mean_depth.resize(lines, 0.0);
        self.share.clear();
        self.share.resize(lines, 0.0);
        self.area.clear();
        self.area.resize(lines, 0.0);
        let (rows, across) = (sheet.window.size[0], sheet.window.size[1]);
        for row in 1..rows - 1 {
            for line in row * across + 1..(row + 1) * across - 1 {
                // The depth changes by less than a pitch across a square.
                if self.depth[line] > -sheet.pitch {
                    self.measure_square(tool, (&frame, sweep), sheet, line);
                }
            }
        }
    }

    fn measure_depths(&mut self, tool: &Tool, frame: &SheetFrame, sheet: &Sheet) {
        self.depth.clear();
        let lines = 0..sheet.window.lines();
        // One loop for each kind of tool, so that each is a plain sum of products.
        match tool {
            Tool::Wheel(wheel) => self.depth.extend(lines.map(|line| {
                let at = frame.local(sheet.point(line));
                wheel.radius - 0.5 * wheel.crown * at.y * at.y - (at.x * at.x + at.z * at.z).sqrt()
            })),
            Tool::Pad(_) => self.depth.extend(lines.map(|line| frame.local(sheet.point(line)).z)),
            _ => self.depth.extend(lines.map(|line| tool.depth(frame.local(sheet.point(line))))),
        }
    }

    fn measure_square(&mut self, tool: &Tool, (frame, sweep): (&SheetFrame, DVec3), sheet: &Sheet, line: usize) {
        let depth = self.depth[line];
        let (along, sideways) = self.differences(line, sheet.window.size[1], sheet.pitch);
        let spans = (0.5 * along.mean.abs(), 0.5 * sideways.mean.abs());
        if depth <= -(spans.0 + spans.1) {
            return;
        }
        let cover = cover(tool, (frame, sweep), sheet, line);
        if cover == 0.0 {
            return;
        }
        let share = wet_share(depth, spans);
        let steep_along = spans.0 > spans.1;
        let (crossed, other) = if steep_along { (along.bend, sideways.bend) } else { (sideways.bend, along.bend) };
        let bent = crossed * wet_square_mean(share) + other * share / 24.0;
        let mean = ramp_mean(depth, spans) + bent;
        if mean > 0.0 {
            self.mean_depth[line] = cover * mean;
            self.share[line] = cover * share;
            let rim = if share < 1.0 { bend_at_rim(depth, &along, &sideways) } else { 0.0 };
            self.area[line] = if rim == 0.0 { cover * share } else { cover * wet_share(depth + rim, spans) };
        }
    }

    fn differences(&self, line: usize, across: usize, pitch: f64) -> (Difference, Difference) {
        let here = self.depth[line];
        let along = Difference::new(self.depth[line - across], here, self.depth[line + across], pitch);
        (along, Difference::new(self.depth[line - 1], here, self.depth[line + 1], pitch))
    }

    /// Curvature ∇²(depth) at a column [1/m].
    pub fn laplacian(&self, sheet: &Sheet, line: usize) -> f64 {
        let (along, sideways) = self.differences(line, sheet.window.size[1], sheet.pitch);
        (along.bend + sideways.bend) / (sheet.pitch * sheet.pitch)
    }

    /// Whether any square next to the window's border is in contact: then the window may be too small.
    pub fn reaches_border(&self, sheet: &Sheet) -> bool {
        let (rows, across) = (sheet.window.size[0], sheet.window.size[1]);
        let ends = |row: usize| (1..across - 1).any(|place| self.share[row * across + place] > 0.0);
        let sides = |place: usize| (1..rows - 1).any(|row| self.share[row * across + place] > 0.0);
        ends(1) || ends(rows - 2) || sides(1) || sides(across - 2)
    }

    /// Largest depth under the working surface [m], negative: the gap.
    pub fn deepest(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> f64 {
        let frame = SheetFrame::new(pose, sheet);
        let under = |&line: &usize| cover(tool, (&frame, DVec3::ZERO), sheet, line) > 0.0;
        (0..self.depth.len()).filter(under).map(|line| self.depth[line]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// As [`Squares::deepest`], between columns as well. Beside a wall a column's height is less sure than elsewhere, and
    /// counts as that much deeper.
    pub fn peak(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> f64 {
        let [rows, across] = sheet.window.size;
        let frame = SheetFrame::new(pose, sheet);
        let inner = |&line: &usize| {
            let (row, place) = (line / across, line % across);
            row > 0
                && row + 1 < rows
                && place > 0
                && place + 1 < across
                && cover(tool, (&frame, DVec3::ZERO), sheet, line) > 0.0
        };
        let at = |line: usize| {
            let (along, sideways) = self.differences(line, across, sheet.pitch);
            let unsure = if along.is_whole && sideways.is_whole { 0.0 } else { EDGE_ERROR * sheet.pitch };
            self.top(sheet, line) - unsure
        };
        (0..self.depth.len()).filter(inner).map(at).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Depth [m] at the peak of the parabolas through a column and its neighbours, if it is in the column's square.
    pub fn top(&self, sheet: &Sheet, line: usize) -> f64 {
        let (along, sideways) = self.differences(line, sheet.window.size[1], sheet.pitch);
        self.depth[line] + along.rise() + sideways.rise()
    }
}

/// Mean along the rim of what the depth's curvature adds to the linear depth across a square [m]. The rim is the line on
/// which the linear depth is zero; it is taken from border to border about its point nearest to the square's middle.
fn bend_at_rim(depth: f64, along: &Difference, sideways: &Difference) -> f64 {
    let steepness = along.mean * along.mean + sideways.mean * sideways.mean;
    let off = (depth * depth / (steepness * steepness)).min(0.5 / steepness);
    let spread = 1.0 / (12.0 * along.mean.abs().max(sideways.mean.abs()).powi(2));
    let across = |mean: f64, other: f64| mean * mean * off + other * other * spread;
    0.5 * (along.bend * across(along.mean, sideways.mean) + sideways.bend * across(sideways.mean, along.mean))
}

/// Integral of x²/2 over the wet part of a unit square that is wet from x = 1/2 inwards over `share`: 1/24 when all is.
fn wet_square_mean(share: f64) -> f64 {
    (0.125 - (0.5 - share).powi(3)) / 6.0
}

/// A tool's frame in the coordinates of a sheet (u, v, up).
struct SheetFrame {
    centre: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl SheetFrame {
    fn new(pose: &Pose, sheet: &Sheet) -> Self {
        let [centre, x, y, z] = [pose.centre, pose.frame.x, pose.frame.y, pose.frame.z].map(|v| sheet.facing.sheet(v));
        Self { centre, x, y, z }
    }

    /// A point of the sheet in the tool's frame.
    fn local(&self, point: DVec3) -> DVec3 {
        let from = point - self.centre;
        DVec3::new(self.x.dot(from), self.y.dot(from), self.z.dot(from))
    }
}

/// Share of a column's square that lies under the working surface, as a mean over the tool's `sweep` [m, u v up].
fn cover(tool: &Tool, (frame, sweep): (&SheetFrame, DVec3), sheet: &Sheet, line: usize) -> f64 {
    let at = frame.local(sheet.point(line));
    let within = tool.within(at);
    // Half a square's diagonal, and what a slope of one adds.
    if within.abs() >= sheet.pitch + 0.5 * sweep.length() {
        return if within > 0.0 { 1.0 } else { 0.0 };
    }
    let inward = match tool {
        Tool::Wheel(_) => frame.y * -at.y.signum(),
        _ => -(frame.x * at.x + frame.y * at.y).normalize_or_zero(),
    };
    let swept = 0.5 * sweep.dot(inward).abs();
    let [slope_u, slope_v] = sheet.slope[line];
    let half = 0.5 * sheet.pitch;
    let spans = ((inward.x + inward.z * slope_u).abs() * half, (inward.y + inward.z * slope_v).abs() * half);
    if swept == 0.0 {
        return wet_share(within, spans);
    }
    // Two boxes have the spread of the square's own; the sweep is the other.
    wet_share(within, (spans.0.hypot(spans.1), swept))
}

/// First and second difference across a square; a neighbour beyond a wall does not count.
struct Difference {
    mean: f64,
    bend: f64,
    /// Whether both neighbours count.
    is_whole: bool,
}

impl Difference {
    fn new(before: f64, here: f64, after: f64, pitch: f64) -> Self {
        let near = |other: f64| (other - here).abs() < 2.0 * pitch;
        match (near(before), near(after)) {
            (true, true) => Self { mean: 0.5 * (after - before), bend: after - 2.0 * here + before, is_whole: true },
            (true, false) => Self { mean: here - before, bend: 0.0, is_whole: false },
            (false, true) => Self { mean: after - here, bend: 0.0, is_whole: false },
            (false, false) => Self { mean: 0.0, bend: 0.0, is_whole: false },
        }
    }

    /// Height of the parabola's peak above the column, if it is in the square.
    fn rise(&self) -> f64 {
        if self.bend < 0.0 && self.mean.abs() <= -0.5 * self.bend * (1.0 + 1e-9) {
            -0.5 * self.mean * self.mean / self.bend
        } else {
            0.0
        }
    }
}
