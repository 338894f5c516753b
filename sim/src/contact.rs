//! The contact patch: where a tool overlaps the workpiece, and how deep.
//!
//! The patch is cut into the squares around the sheet's columns. Within a square the depth is taken as linear where
//! the patch's rim or the border of the working surface crosses it, and integrated exactly; inside the patch it is taken
//! as quadratic. So sums over squares are second order in the voxel size.

mod peak;
mod rows;
mod wall;

use glam::DVec3;
use serde::Serialize;

use self::rows::{Depths, Settle, UNSETTLED};
use crate::ramp::{ramp_mean, wet_share};
use crate::region::Region;
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
    /// Depth at the column itself [m], negative in the air; known in the region and on the lines around it.
    pub depth: Vec<f64>,
    /// Mean over the square of the depth where it is positive, 0 elsewhere [m].
    pub mean_depth: Vec<f64>,
    /// Share of the square that is under the working surface and in contact where the depth is linear.
    pub share: Vec<f64>,
    /// The same with the depth's curvature along the rim: the patch's area.
    pub area: Vec<f64>,
    /// When in the sweep a square is under the working surface: the mean time from the sweep's middle, -1/2 to 1/2; other
    /// than 0 where the border crosses the square. Empty without a sweep; known where a square has a share.
    pub lag: Vec<f64>,
    /// Way of the tool in the sweep, in its own frame [m].
    pub way: DVec3,
    /// Lines that had a share when they were measured, in order.
    pub wet: Vec<u32>,
    /// What was measured.
    region: Region,
}

impl Squares {
    /// Measures a tool over a region of a sheet. `gap` [m], one per line of the grown region or empty, is how much further
    /// away the tool's surface is than its shape says. Contact is taken as the mean over a `sweep` [m] of the tool about its
    /// pose: with the time that the working surface is over a square, and the depth of a pad in that time.
    pub fn measure(
        &mut self,
        tool: &Tool,
        pose: &Pose,
        (sheet, region): (&Sheet, &Region),
        (gap, sweep): (&[f64], DVec3),
    ) {
        self.clear(sheet.window.lines());
        self.region.clone_from(region);
        let across = sheet.window.size[1];
        let border = Border::new(tool, SheetFrame::new(pose, sheet), sheet, sweep);
        self.way = border.frame.turned(border.sweep);
        self.lag.resize(if sweep == DVec3::ZERO { 0 } else { sheet.window.lines() }, 0.0);
        let lanes = pulp::Arch::new();
        lanes.dispatch(Depths { border: &border, sheet, region: region.grown(), depth: &mut self.depth });
        for (line, gap) in region.grown().lines(across).zip(gap) {
            self.depth[line] -= gap;
        }
        self.leave_walls(&border, sheet);
        lanes.dispatch(Settle { border: &border, sheet, squares: self });
        for row in region.rows.clone() {
            let (mut line, end) = (row * across + region.columns.start, row * across + region.columns.end);
            while line < end {
                if self.share[line] == UNSETTLED {
                    self.share[line] = 0.0;
                    self.measure_square(&border, sheet, line);
                    line += 1;
                    continue;
                }
                let wet = self.share[line..end].iter().take_while(|share| **share > 0.0).count();
                self.wet.extend(line as u32..(line + wet) as u32);
                line += wet.max(1);
            }
        }
    }

    /// Forgets all squares and makes room for those of so many lines.
    fn clear(&mut self, lines: usize) {
        for run in runs(&self.wet) {
            for values in [&mut self.mean_depth, &mut self.share, &mut self.area] {
                values[run.clone()].fill(0.0);
            }
        }
        self.wet.clear();
        for values in [&mut self.depth, &mut self.mean_depth, &mut self.share, &mut self.area] {
            values.resize(lines, 0.0);
        }
    }

    fn measure_square(&mut self, border: &Border, sheet: &Sheet, line: usize) {
        let (along, sideways) = self.differences(line, sheet.window.size[1], sheet.pitch);
        let spans = (0.5 * along.mean.abs(), 0.5 * sideways.mean.abs());
        let most = spans.0 + spans.1 + border.sunk();
        if self.depth[line] <= -most - border.sunk() {
            return;
        }
        let cover = border.cover(sheet, line);
        let depth = self.depth[line] + border.sinking * cover.lag;
        if cover.share == 0.0 || depth <= -most {
            return;
        }
        let (mean, share, area) = if depth >= most {
            (depth + (along.bend + sideways.bend) / 24.0, 1.0, 1.0)
        } else {
            partly_wet(depth, spans, border.sunk(), (&along, &sideways))
        };
        if mean > 0.0 {
            self.mean_depth[line] = cover.share * mean;
            self.share[line] = cover.share * share;
            self.area[line] = cover.share * area;
            if let Some(lag) = self.lag.get_mut(line) {
                *lag = cover.lag;
            }
            self.wet.push(line as u32);
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

    /// Whether any square on the region's border is in contact: then the region may be too small.
    pub fn reaches_border(&self, sheet: &Sheet) -> bool {
        self.region.border(sheet.window.size[1]).any(|line| self.share[line] > 0.0)
    }

    /// Largest depth under the working surface [m], negative: the gap.
    pub fn deepest(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> f64 {
        self.under(tool, pose, sheet).map(|line| self.depth[line]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// As [`Squares::deepest`], between columns as well. Beside a wall a column's height is less sure than elsewhere, and
    /// counts as that much deeper.
    pub fn peak(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> f64 {
        let at = |line: usize| {
            let (along, sideways) = self.differences(line, sheet.window.size[1], sheet.pitch);
            let unsure = if along.is_whole && sideways.is_whole { 0.0 } else { EDGE_ERROR * sheet.pitch };
            self.top(sheet, line) - unsure
        };
        self.under(tool, pose, sheet).map(at).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Lines under the working surface.
    fn under(&self, tool: &Tool, pose: &Pose, sheet: &Sheet) -> impl Iterator<Item = usize> {
        let border = Border::new(tool, SheetFrame::new(pose, sheet), sheet, DVec3::ZERO);
        self.region.lines(sheet.window.size[1]).filter(move |&line| border.cover(sheet, line).share > 0.0)
    }
}

/// Mean along the rim of what the depth's curvature adds to the linear depth across a square [m]. The rim is the line on
/// which the linear depth is zero; it is taken from border to border about its point nearest to the square's middle. A square
/// of one depth has none.
fn bend_at_rim(depth: f64, along: &Difference, sideways: &Difference) -> f64 {
    let steepness = along.mean * along.mean + sideways.mean * sideways.mean;
    if steepness == 0.0 {
        return 0.0;
    }
    let off = (depth * depth / (steepness * steepness)).min(0.5 / steepness);
    let spread = 1.0 / (12.0 * along.mean.abs().max(sideways.mean.abs()).powi(2));
    let across = |mean: f64, other: f64| mean * mean * off + other * other * spread;
    0.5 * (along.bend * across(along.mean, sideways.mean) + sideways.bend * across(sideways.mean, along.mean))
}

/// Integral of x²/2 over the wet part of a unit square that is wet from x = 1/2 inwards over `share`: 1/24 when all is.
fn wet_square_mean(share: f64) -> f64 {
    (0.125 - (0.5 - share).powi(3)) / 6.0
}

/// Mean depth, share and area of a square that the patch's rim crosses, by its middle's depth, over a sweep in which the
/// tool sinks in by `sunk` [m] on either side of its middle.
fn partly_wet(
    depth: f64,
    spans: (f64, f64),
    sunk: f64,
    (along, sideways): (&Difference, &Difference),
) -> (f64, f64, f64) {
    let steep_along = spans.0 > spans.1;
    let spans = swept_spans(spans, sunk);
    let share = wet_share(depth, spans);
    let (crossed, other) = if steep_along { (along.bend, sideways.bend) } else { (sideways.bend, along.bend) };
    let bent = crossed * wet_square_mean(share) + other * share / 24.0;
    let rim = if share < 1.0 { bend_at_rim(depth, along, sideways) } else { 0.0 };
    let area = if rim == 0.0 { share } else { wet_share(depth + rim, spans) };
    (ramp_mean(depth, spans) + bent, share, area)
}

/// Spans of a square with a sweep of `swept` [m] on either side of its middle: two boxes have the spread of the square's own,
/// the sweep is the other.
#[inline(always)]
fn swept_spans((a, b): (f64, f64), swept: f64) -> (f64, f64) {
    if swept == 0.0 { (a, b) } else { ((a * a + b * b).sqrt(), swept) }
}

/// Cuts lines in order into those that follow each other.
pub(crate) fn runs(lines: &[u32]) -> impl Iterator<Item = std::ops::Range<usize>> {
    lines.chunk_by(|line, next| line + 1 == *next).map(|run| run[0] as usize..run[0] as usize + run.len())
}

/// A tool's frame in the coordinates of a sheet (u, v, up).
pub(crate) struct SheetFrame {
    centre: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
}

impl SheetFrame {
    pub(crate) fn new(pose: &Pose, sheet: &Sheet) -> Self {
        let [centre, x, y, z] = [pose.centre, pose.frame.x, pose.frame.y, pose.frame.z].map(|v| sheet.facing.sheet(v));
        Self { centre, x, y, z }
    }

    /// A point of the sheet in the tool's frame.
    #[inline(always)]
    pub(crate) fn local(&self, point: DVec3) -> DVec3 {
        self.turned(point - self.centre)
    }

    /// A vector of the sheet in the tool's frame.
    #[inline(always)]
    fn turned(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.x.dot(v), self.y.dot(v), self.z.dot(v))
    }
}

/// How much of a square lies under the working surface in a sweep, and when.
#[derive(Clone, Copy)]
struct Cover {
    share: f64,
    /// As in [`Squares::lag`].
    lag: f64,
}

/// The border of a tool's working surface over a sheet.
struct Border<'a> {
    tool: &'a Tool,
    frame: SheetFrame,
    /// Sweep of the tool [m, u v up].
    sweep: DVec3,
    /// By how much a pad sinks in over the sweep, the same everywhere [m].
    sinking: f64,
    /// Distance from the border beyond which a square is wholly within or beside it [m].
    near: f64,
    /// Squares of the radii between which a pad's border may cross a square [m²].
    ring: (f64, f64),
}

impl<'a> Border<'a> {
    fn new(tool: &'a Tool, frame: SheetFrame, sheet: &Sheet, sweep: DVec3) -> Self {
        let sweep = sheet.facing.sheet(sweep);
        // Half a square's diagonal, and what a slope of one adds.
        let near = sheet.pitch + 0.5 * sweep.length();
        let radius = tool.rim_radius();
        let inner = radius - near;
        let ring = (inner * inner.abs(), (radius + near).powi(2));
        let sinking = if matches!(tool, Tool::Pad(_)) { -frame.z.dot(sweep) } else { 0.0 };
        Self { tool, frame, sweep, sinking, near, ring }
    }

    /// How far a pad sinks in or out on either side of the sweep's middle [m].
    #[inline(always)]
    fn sunk(&self) -> f64 {
        0.5 * self.sinking.abs()
    }

    /// Cover of a column's square over the sweep.
    #[inline]
    fn cover(&self, sheet: &Sheet, line: usize) -> Cover {
        let at = self.frame.local(sheet.point(line));
        let (is_within, is_near) = match self.tool {
            Tool::Pad(_) => {
                let square = at.x * at.x + at.y * at.y;
                (square <= self.ring.0, square > self.ring.0 && square < self.ring.1)
            }
            tool => {
                let within = tool.within(at);
                (within > 0.0, within.abs() < self.near)
            }
        };
        if is_near { self.crossed(at, sheet, line) } else { Cover { share: f64::from(is_within), lag: 0.0 } }
    }

    /// The same for a square that the border may cross, its middle `at` a place of the tool's frame [m].
    fn crossed(&self, at: DVec3, sheet: &Sheet, line: usize) -> Cover {
        let inward = match self.tool {
            Tool::Wheel(_) => self.frame.y * -at.y.signum(),
            _ => self.to_middle(at),
        };
        self.cover_within(self.tool.within(at), inward, sheet.slope[line], 0.5 * sheet.pitch)
    }

    /// Unit vector of the sheet from a place of the tool's frame towards the middle of its face.
    #[inline(always)]
    fn to_middle(&self, at: DVec3) -> DVec3 {
        -(self.frame.x * at.x + self.frame.y * at.y).normalize_or_zero()
    }

    /// Cover of a square of half side `half` [m] whose middle lies `within` the border [m], which is crossed `inward`.
    #[inline(always)]
    fn cover_within(&self, within: f64, inward: DVec3, [slope_u, slope_v]: [f64; 2], half: f64) -> Cover {
        let swept = 0.5 * self.sweep.dot(inward);
        let own = ((inward.x + inward.z * slope_u).abs() * half, (inward.y + inward.z * slope_v).abs() * half);
        let spans = swept_spans(own, swept.abs());
        let share = wet_share(within, spans);
        if swept == 0.0 {
            return Cover { share, lag: 0.0 };
        }
        // Exact for a point: it is under the surface from one end of the sweep to when the border crosses it.
        let lag = -0.5 * (1.0 - share) * swept / (spans.0 * spans.0 + swept * swept).sqrt();
        Cover { share, lag }
    }
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
