//! Depths of whole rows of cells in SIMD lanes, and the cells that need no subdivision or individual measurement.
//!
//! Every operation acts on each cell alone and is exactly rounded, so the number of lanes changes no result.

use std::ops::Range;

use glam::DVec3;

use super::{Border, ContactCells};
use crate::height_field::HeightField;
use crate::region::Region;
use robot::{Shape, Tool};

/// Value of a share that has to be measured individually.
pub(super) const UNRESOLVED: f64 = -1.0;
/// Travel of a tool for which every cell must keep its state before the update without settling is allowed [voxels].
const STEADY: f64 = 0.05;

/// Ranges of columns in each row of a region that may be under a tool, from the `columns` of that row and of its
/// neighbours, with one column more on each side.
pub(super) fn rows_around(
    region: &Region,
    columns: &[Range<usize>],
    across: usize,
) -> impl Iterator<Item = Range<usize>> {
    let first = region.rows.start - 1;
    (0..columns.len() + 2).filter_map(move |place| {
        let beside = columns[place.saturating_sub(2)..columns.len().min(place + 1)].iter();
        let sought = beside.filter(|columns| !columns.is_empty());
        let (start, end) = sought.fold((usize::MAX, 0), |(start, end), row| (start.min(row.start), end.max(row.end)));
        let line = (first + place) * across;
        (start < end).then(|| line + start - 1..line + end + 1)
    })
}

/// Columns that are tested together for contact.
const CHUNK: usize = 4;

/// Positions of consecutive columns of a row in the tool's frame.
#[inline(always)]
fn local(border: &Border, height_field: &HeightField, lines: &Range<usize>) -> impl Iterator<Item = DVec3> {
    let ([u, v], pitch) = (height_field.places()[lines.start], height_field.pitch);
    let heights = height_field.height[lines.clone()].iter().enumerate();
    heights.map(move |(i, height)| border.frame.local(DVec3::new(u, v + f64::from(i as i32) * pitch, *height)))
}

/// Computes the depth at the columns that may be under a tool, and around them.
pub(super) struct Depths<'a> {
    pub(super) border: &'a Border<'a>,
    pub(super) height_field: &'a HeightField,
    pub(super) contact_cells: &'a mut ContactCells,
}

impl pulp::NullaryFnOnce for Depths<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { border, height_field, contact_cells } = self;
        let ContactCells { region, columns, depth, .. } = contact_cells;
        for lines in rows_around(region, columns, height_field.window.size[1]) {
            let places = local(border, height_field, &lines);
            let depths = depth[lines.clone()].iter_mut().zip(places);
            match border.tool {
                Tool::Wheel(wheel) => {
                    for (depth, at) in depths {
                        *depth = wheel.depth(at);
                    }
                }
                Tool::Pad(pad) => {
                    for (depth, at) in depths {
                        *depth = pad.depth(at);
                    }
                }
                tool => {
                    for (depth, at) in depths {
                        *depth = tool.depth(at);
                    }
                }
            }
        }
    }
}

/// Finds the columns of each row whose cells may be in contact. Cells farther in the air than a pitch are dry: the
/// depth changes by less than a pitch across a cell. A pad that only moves along its axis keeps its covers, so it needs
/// all of them; so does a tool whose cells are subdivided.
pub(super) struct NearColumns<'a> {
    pub(super) border: &'a Border<'a>,
    pub(super) height_field: &'a HeightField,
    pub(super) contact_cells: &'a mut ContactCells,
}

impl pulp::NullaryFnOnce for NearColumns<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { border, height_field, contact_cells } = self;
        let takes_all = matches!(border.tool, Tool::Pad(_)) || contact_cells.needs_subdivision(border);
        let ContactCells { region, columns, near, depth, .. } = contact_cells;
        near.clone_from(columns);
        if takes_all {
            return;
        }
        // Far beyond the rounding of the depths.
        let dry = -1.01 * height_field.pitch - 2.0 * border.sunk();
        for (row, columns) in region.rows.clone().zip(near) {
            let first = row * height_field.window.size[1];
            let depths = &depth[first + columns.start..first + columns.end];
            let (before, after) = (dry_chunks(depths.chunks(CHUNK), dry), dry_chunks(depths.rchunks(CHUNK), dry));
            let (most, from) = (columns.end, columns.start + (before * CHUNK).min(columns.len()));
            let count = columns.end.saturating_sub(after * CHUNK).saturating_sub(from);
            // Whole SIMD lanes.
            *columns = from..(from + count.next_multiple_of(CHUNK)).min(most);
        }
    }
}

/// Number of chunks in the air, up to the first with a depth above `dry` [m].
#[inline(always)]
fn dry_chunks<'a>(chunks: impl Iterator<Item = &'a [f64]>, dry: f64) -> usize {
    chunks.take_while(|chunk| chunk.iter().fold(true, |all, depth| all & (*depth <= dry))).count()
}

/// Computes the share of each cell under the working surface, [`UNRESOLVED`] where a wheel's border may cross it; in a
/// sweep also the lag.
pub(super) struct Covers<'a> {
    pub(super) border: &'a Border<'a>,
    pub(super) height_field: &'a HeightField,
    pub(super) contact_cells: &'a mut ContactCells,
}

impl pulp::NullaryFnOnce for Covers<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { border, height_field, contact_cells } = self;
        for (row, columns) in contact_cells.region.rows.clone().zip(&contact_cells.near) {
            let first = row * height_field.window.size[1];
            let lines = first + columns.start..first + columns.end;
            if lines.is_empty() {
                continue;
            }
            let lag = contact_cells.lag.get_mut(lines.clone()).unwrap_or_default();
            cover_row(border, height_field, &lines, (&mut contact_cells.cover[lines.clone()], lag));
        }
    }
}

#[inline(always)]
fn cover_row(
    border: &Border,
    height_field: &HeightField,
    lines: &Range<usize>,
    (cover, lag): (&mut [f64], &mut [f64]),
) {
    lag.fill(0.0);
    match border.tool {
        Tool::Wheel(wheel) => {
            for (cover, at) in cover.iter_mut().zip(local(border, height_field, lines)) {
                let within = wheel.within(at);
                let beside = if within <= -border.near { 0.0 } else { UNRESOLVED };
                *cover = if within >= border.near { 1.0 } else { beside };
            }
        }
        Tool::Pad(_) => {
            for (cover, at) in cover.iter_mut().zip(local(border, height_field, lines)) {
                let square = at.x * at.x + at.y * at.y;
                let beside = if square >= border.ring.1 { 0.0 } else { UNRESOLVED };
                *cover = if square <= border.ring.0 { 1.0 } else { beside };
            }
            let mut place = 0;
            for part in cover.chunk_by_mut(|one, next| (*one == UNRESOLVED) == (*next == UNRESOLVED)) {
                let places = place..place + part.len();
                if part[0] == UNRESOLVED {
                    let lag = lag.get_mut(places.clone()).unwrap_or_default();
                    cross_row(border, height_field, &(lines.start + place..lines.start + places.end), (part, lag));
                }
                place = places.end;
            }
        }
        _ => cover.fill(1.0),
    }
}

/// Cover of cells that the border of a pad may cross.
#[inline(always)]
fn cross_row(
    border: &Border,
    height_field: &HeightField,
    lines: &Range<usize>,
    (cover, lag): (&mut [f64], &mut [f64]),
) {
    let contact_cells = local(border, height_field, lines).zip(&height_field.slope[lines.clone()]);
    if lag.is_empty() {
        for (share, (at, slope)) in cover.iter_mut().zip(contact_cells) {
            *share = border.disc_cover(at, *slope, height_field.pitch).share;
        }
        return;
    }
    for ((share, lag), (at, slope)) in cover.iter_mut().zip(lag).zip(contact_cells) {
        let cover = border.disc_cover(at, *slope, height_field.pitch);
        (*share, *lag) = (cover.share, cover.lag);
    }
}

/// Settles the cells that are entirely in or entirely out of contact; the others get [`UNRESOLVED`] as their share.
pub(super) struct ClassifyCells<'a> {
    pub(super) border: &'a Border<'a>,
    pub(super) height_field: &'a HeightField,
    pub(super) contact_cells: &'a mut ContactCells,
}

impl pulp::NullaryFnOnce for ClassifyCells<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { border, height_field, contact_cells } = self;
        let (across, mut is_steady) = (height_field.window.size[1], true);
        for (place, row) in contact_cells.region.rows.clone().enumerate() {
            let columns = &contact_cells.near[place];
            let (first, count) = (row * across + columns.start, columns.len());
            is_steady &= if contact_cells.lag.is_empty() {
                settle_row(contact_cells, (first, count), (across, height_field.pitch), (0.0, |_| 0.0))
            } else {
                let lag = std::mem::take(&mut contact_cells.lag);
                let row = &lag[first..first + count];
                let sinking = |i: usize| border.sinking * row[i];
                let row_is_steady =
                    settle_row(contact_cells, (first, count), (across, height_field.pitch), (border.sunk(), sinking));
                contact_cells.lag = lag;
                row_is_steady
            };
        }
        contact_cells.room = if is_steady { STEADY * height_field.pitch } else { 0.0 };
    }
}

/// Settles `count` cells from column `first` on. Over the sweep the tool sinks in by `sunk` [m] on either side of its
/// middle, and by `sinking` while it is over a cell. Returns true if all cells would keep their state under a travel of
/// [`STEADY`].
#[inline(always)]
fn settle_row(
    contact_cells: &mut ContactCells,
    (first, count): (usize, usize),
    (across, pitch): (usize, f64),
    (sunk, sinking): (f64, impl Fn(usize) -> f64),
) -> bool {
    let from = |line: usize| &contact_cells.depth[line..line + count];
    let (here, before, after) = (from(first), from(first - across), from(first + across));
    let (left, right) = (from(first - 1), from(first + 1));
    let lines = first..first + count;
    let (covers, means) = (&contact_cells.cover[lines.clone()], &mut contact_cells.mean_depth[lines.clone()]);
    let (shares, areas) = (&mut contact_cells.share[lines.clone()], &mut contact_cells.area[lines]);
    let (wall, room) = (2.0 * pitch, STEADY * pitch);
    let mut is_steady = true;
    for i in 0..count {
        let (depth, cover) = (here[i], covers[i]);
        let is_whole = ((before[i] - depth).abs() < wall)
            & ((after[i] - depth).abs() < wall)
            & ((left[i] - depth).abs() < wall)
            & ((right[i] - depth).abs() < wall);
        let span = 0.5 * (0.5 * (after[i] - before[i])).abs() + 0.5 * (0.5 * (right[i] - left[i])).abs() + sunk;
        let bend = (after[i] - 2.0 * depth + before[i]) + (right[i] - 2.0 * depth + left[i]);
        let swept_depth = depth + sinking(i);
        let mean = swept_depth + bend / 24.0;
        // The depth changes by less than a pitch across a cell.
        let dry_at = if is_whole & (span < pitch + sunk) { -span } else { -pitch - sunk };
        let is_dry = (cover == 0.0) | (swept_depth <= dry_at);
        let is_full = (cover > 0.0) & is_whole & (swept_depth >= span) & (mean > 0.0) & !is_dry;
        means[i] = if is_full { cover * mean } else { 0.0 };
        areas[i] = if is_full { cover } else { 0.0 };
        shares[i] = if is_full | is_dry { areas[i] } else { UNRESOLVED };
        let stays_full = is_full & (swept_depth >= span + room) & (mean > room);
        is_steady &= (cover == 0.0) | stays_full | (swept_depth <= dry_at - room);
    }
    is_steady
}
