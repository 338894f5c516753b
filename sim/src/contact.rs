//! The contact patch: the cells in which a tool overlaps the workpiece, and their depths.
//!
//! The patch is divided into the cells around the height field's columns. In a cell that the patch's rim or the border
//! of the working surface crosses, the depth is taken as linear and integrated exactly. Inside the patch it is taken as
//! quadratic. So sums over cells are second order in the voxel size. A tool from a mesh has edges between columns: its
//! cells are subdivided (`subdivision`).

mod border;
mod columns;
mod deepest_point;
mod patch;
mod rows;
mod side_face;
mod subdivision;

use std::ops::Range;

use glam::DVec3;
use serde::Serialize;

pub(crate) use self::border::HeightFieldFrame;
use self::border::{Border, Cover, swept_spans};
pub(crate) use self::columns::Columns;
pub(crate) use self::deepest_point::DeepestPoint;
use self::rows::{ClassifyCells, Covers, Depths, NearColumns, UNRESOLVED, rows_around};
use crate::clipped_cell::{ramp_mean, wet_share};
use crate::height_field::HeightField;
use crate::lines::{Lines, Run};
use crate::pose::{Frame, Placement};
use crate::region::Region;
use robot::Tool;

/// Motion of a tool across its own axis up to which the covers are not measured again [voxels].
const SAME_COVER: f64 = 1e-3;

/// Forces on a tool and size of its contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Contact {
    /// Normal force `F = ∫ p n·a dA` along the approach axis a [N].
    pub force: f64,
    /// `∫ p dA` over the surface itself [N]; it drives removal.
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

/// The part of a height field that is evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// The height field.
    pub height_field: &'a HeightField,
    /// Its columns that are evaluated.
    pub region: &'a Region,
}

/// Pose of the tool at the last measurement.
#[derive(Clone, Copy, Debug)]
struct Measured {
    frame: Frame,
    /// Sweep of the tool [m].
    sweep: DVec3,
    /// Reference point when the covers were measured [m].
    over: DVec3,
    /// Reference point when the depths were measured [m].
    centre: DVec3,
}

/// Depths of a height field's cells under a tool; the buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct ContactCells {
    /// Depth at the column itself [m], negative in the air. Known in the region and on the columns around it; in a
    /// sweep, under the pad and around it.
    pub depth: Vec<f64>,
    /// Mean over the cell of the positive part of the depth [m].
    pub mean_depth: Vec<f64>,
    /// Share of the cell that is under the working surface and in contact, for a linear depth.
    pub share: Vec<f64>,
    /// The same, corrected for the depth's curvature along the rim: the patch's area.
    pub area: Vec<f64>,
    /// Mean time in the sweep at which a cell is under the working surface, from the sweep's middle, -1/2 to 1/2.
    /// Non-zero only where the border crosses the cell. Empty without a sweep; known where a cell has a share.
    pub lag: Vec<f64>,
    /// Motion of the tool in the sweep, in its own frame [m].
    pub way: DVec3,
    /// Columns that had a share when they were measured.
    pub wet: Lines,
    /// Share of the cell that is under the working surface, in contact or not. Known where a cell has a share; in a
    /// sweep it is [`UNRESOLVED`] where it has to be computed on demand.
    cover: Vec<f64>,
    /// Region that was measured.
    region: Region,
    /// Columns of each row of the region that may be under the working surface.
    columns: Vec<Range<usize>>,
    /// Those of them whose cells may be in contact.
    near: Vec<Range<usize>>,
    /// Travel along the axis up to which every cell stays entirely in contact or entirely out of contact [m].
    room: f64,
    /// Pose of the tool.
    at: Option<Measured>,
    /// True if cells with curved depths are subdivided, whatever the tool.
    is_subdivided: bool,
}

impl ContactCells {
    /// Measures the depths under a tool over a region. `gap` [m] is the distance that effects add between tool and
    /// workpiece, one value per column of the grown region, or empty. The contact is a mean over the tool's sweep about
    /// its pose: it uses the time in which the working surface is over a cell, and a pad's depth in that time.
    pub fn measure(&mut self, place: &Placement, &Ground { height_field, region }: &Ground, gap: &[f64]) {
        let &Placement { tool, pose, sweep } = place;
        self.clear(height_field.window.lines());
        self.region.clone_from(region);
        let border = Border::new(place, height_field);
        self.way = border.frame.turned(border.sweep);
        self.lag.resize(if sweep == DVec3::ZERO { 0 } else { height_field.window.lines() }, 0.0);
        let sought =
            |row| if sweep == DVec3::ZERO { region.columns.clone() } else { border.columns(height_field, region, row) };
        self.columns.clear();
        self.columns.extend(region.rows.clone().map(sought));
        let lanes = pulp::Arch::new();
        lanes.dispatch(Depths { border: &border, height_field, contact_cells: self });
        for (line, gap) in region.grown().lines(height_field.window.size[1]).zip(gap) {
            self.depth[line] -= gap;
        }
        self.remove_side_faces(&border, height_field);
        lanes.dispatch(NearColumns { border: &border, height_field, contact_cells: self });
        lanes.dispatch(Covers { border: &border, height_field, contact_cells: self });
        self.settle(&border, height_field);
        let is_pad = matches!(tool, Tool::Pad(_)) && gap.is_empty();
        self.at = is_pad.then_some(Measured { frame: pose.frame, sweep, over: pose.centre, centre: pose.centre });
    }

    /// Forgets the tool's pose, because the height field or how it is measured may have changed.
    pub fn forget(&mut self) {
        self.at = None;
    }

    /// Updates the depths of a pad that has only moved along its axis over the same region of the same height field.
    /// Returns true if that is the only motion; otherwise nothing is measured.
    pub fn measure_deeper(&mut self, place: &Placement, height_field: &HeightField) -> bool {
        let Placement { pose, sweep, .. } = *place;
        let Some(at) = self.at.filter(|at| at.frame == pose.frame && at.sweep == sweep) else { return false };
        let across = (pose.centre - at.over).reject_from_normalized(pose.frame.z);
        if across.length() > SAME_COVER * height_field.pitch {
            return false;
        }
        self.at = Some(Measured { centre: pose.centre, ..at });
        let deeper = pose.frame.z.dot(at.centre - pose.centre);
        for lines in rows_around(&self.region, &self.columns, height_field.window.size[1]) {
            self.depth[lines].iter_mut().for_each(|depth| *depth += deeper);
        }
        self.room -= deeper.abs();
        if self.room > 0.0 {
            for Run { lines, .. } in self.wet.runs() {
                let means = self.mean_depth[lines.clone()].iter_mut().zip(&self.share[lines.clone()]);
                means.for_each(|(mean, share)| *mean += share * deeper);
            }
            return true;
        }
        self.clear(height_field.window.lines());
        self.settle(&Border::new(place, height_field), height_field);
        true
    }

    /// Computes mean depths and shares of all cells from known depths and covers.
    fn settle(&mut self, border: &Border, height_field: &HeightField) {
        pulp::Arch::new().dispatch(ClassifyCells { border, height_field, contact_cells: self });
        let subdivided = self.needs_subdivision(border);
        if subdivided {
            self.unsettle(height_field);
        }
        let across = height_field.window.size[1];
        for (place, row) in self.region.rows.clone().enumerate() {
            let columns = &self.near[place];
            let (mut line, end) = (row * across + columns.start, row * across + columns.end);
            while line < end {
                if self.share[line] == UNRESOLVED {
                    self.share[line] = 0.0;
                    if subdivided {
                        self.measure_subdivided(border, height_field, line);
                    } else {
                        self.measure_cell(border, height_field, line);
                    }
                    line += 1;
                    continue;
                }
                let is_dry = |share: f64| share != UNRESOLVED && (share <= 0.0 || share.is_nan());
                line += self.share[line..end].iter().take_while(|share| is_dry(**share)).count();
                let wet = self.share[line..end].iter().take_while(|share| **share > 0.0).count();
                self.wet.extend(line..line + wet);
                line += wet;
            }
        }
    }

    /// Forgets all cells and allocates for the cells of `lines` columns.
    fn clear(&mut self, lines: usize) {
        for run in self.wet.runs() {
            for values in [&mut self.mean_depth, &mut self.share, &mut self.area] {
                values[run.lines.clone()].fill(0.0);
            }
        }
        self.wet.clear();
        for values in [&mut self.depth, &mut self.mean_depth, &mut self.share, &mut self.area, &mut self.cover] {
            values.resize(lines, 0.0);
        }
    }

    fn measure_cell(&mut self, border: &Border, height_field: &HeightField, line: usize) {
        let (along, sideways) = self.differences(line, height_field.window.size[1], height_field.pitch);
        let spans = (0.5 * along.mean.abs(), 0.5 * sideways.mean.abs());
        let most = spans.0 + spans.1 + border.sunk();
        if self.depth[line] <= -most - border.sunk() {
            return;
        }
        let cover = self.cover_of(border, height_field, line);
        let depth = self.depth[line] + border.sinking * cover.lag;
        if self.lag.is_empty() {
            self.cover[line] = cover.share;
        }
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
            self.wet.push(line);
        }
    }

    fn cover_of(&self, border: &Border, height_field: &HeightField, line: usize) -> Cover {
        let share = self.cover[line];
        if share == UNRESOLVED {
            return border.cover(height_field, line);
        }
        Cover { share, lag: self.lag.get(line).copied().unwrap_or(0.0) }
    }

    fn differences(&self, line: usize, across: usize, pitch: f64) -> (Difference, Difference) {
        let here = self.depth[line];
        let along = Difference::new(self.depth[line - across], here, self.depth[line + across], pitch);
        (along, Difference::new(self.depth[line - 1], here, self.depth[line + 1], pitch))
    }

    /// The part of a run of columns of one row, on a height field `across` columns wide, whose depths and neighbours
    /// are known.
    pub(crate) fn known(&self, lines: &Range<usize>, across: usize) -> Range<usize> {
        let row = lines.start / across;
        if !self.region.rows.contains(&row) {
            return lines.start..lines.start;
        }
        let start = (row * across + self.region.columns.start).clamp(lines.start, lines.end);
        start..(row * across + self.region.columns.end).clamp(start, lines.end)
    }

    /// Share of a cell whose height falls when the surface under the tool recedes; the rest belongs to the groove's
    /// side face.
    pub(crate) fn cover_of_groove(&self, line: usize) -> f64 {
        if self.share[line] > 0.0 && self.lag.is_empty() { self.cover[line] } else { 1.0 }
    }

    /// Curvature ∇²(depth) at a column [1/m].
    pub fn laplacian(&self, height_field: &HeightField, line: usize) -> f64 {
        let (along, sideways) = self.differences(line, height_field.window.size[1], height_field.pitch);
        (along.bend + sideways.bend) / (height_field.pitch * height_field.pitch)
    }

    /// True if any cell on the region's border is in contact: then the region may be too small.
    pub fn reaches_border(&self, height_field: &HeightField) -> bool {
        self.region.border(height_field.window.size[1]).any(|line| self.share[line] > 0.0)
    }
}

/// Mean along the rim of what the depth's curvature adds to the linear depth across a cell [m]. The rim is the zero
/// line of the linear depth, taken across the cell about its point nearest to the cell's middle. A cell of constant
/// depth has no rim.
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

/// Integral of x²/2 over the part of a unit cell in contact, which extends from x = 1/2 inwards over `share`; 1/24 for
/// a full cell.
fn wet_cell_mean(share: f64) -> f64 {
    (0.125 - (0.5 - share).powi(3)) / 6.0
}

/// Mean depth, share and area of a cell that the patch's rim crosses, from its middle's depth, over a sweep in which
/// the tool sinks in by `sunk` [m] on either side of its middle.
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
    let bent = crossed * wet_cell_mean(share) + other * share / 24.0;
    let rim = if share < 1.0 { bend_at_rim(depth, along, sideways) } else { 0.0 };
    let area = if rim == 0.0 { share } else { wet_share(depth + rim, spans) };
    (ramp_mean(depth, spans) + bent, share, area)
}

/// First and second difference across a cell; a neighbour beyond a side face does not count.
struct Difference {
    mean: f64,
    bend: f64,
    /// True if both neighbours count.
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

    /// Height of the parabola's vertex above the column, if it lies in the cell.
    fn rise(&self) -> f64 {
        if self.bend < 0.0 && self.mean.abs() <= -0.5 * self.bend * (1.0 + 1e-9) {
            -0.5 * self.mean * self.mean / self.bend
        } else {
            0.0
        }
    }
}
