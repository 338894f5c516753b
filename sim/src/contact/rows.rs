//! Whole rows of squares in the processor's widest lanes: their depths, and those of them that need no closer look.
//!
//! Every operation acts on each square alone and is exactly rounded: the lanes decide nothing.

use glam::DVec3;

use super::{Border, Squares};
use crate::region::Region;
use crate::sheet::Sheet;
use crate::tool::Tool;

/// Share of a square that has to be measured by itself.
pub(super) const UNSETTLED: f64 = -1.0;

/// Measures the depth at the columns of a region.
pub(super) struct Depths<'a> {
    pub(super) border: &'a Border<'a>,
    pub(super) sheet: &'a Sheet,
    pub(super) region: Region,
    pub(super) depth: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Depths<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { border, sheet, region, depth } = self;
        let (across, frame) = (sheet.window.size[1], &border.frame);
        for row in region.rows {
            let lines = row * across + region.columns.start..row * across + region.columns.end;
            let points = sheet.places()[lines.clone()].iter().zip(&sheet.height[lines.clone()]);
            let depths = depth[lines].iter_mut().zip(points);
            match border.tool {
                Tool::Wheel(wheel) => {
                    for (depth, ([u, v], height)) in depths {
                        let at = frame.local(DVec3::new(*u, *v, *height));
                        *depth = wheel.radius - 0.5 * wheel.crown * at.y * at.y - (at.x * at.x + at.z * at.z).sqrt();
                    }
                }
                Tool::Pad(_) => {
                    for (depth, ([u, v], height)) in depths {
                        *depth = frame.local(DVec3::new(*u, *v, *height)).z;
                    }
                }
                tool => {
                    for (depth, ([u, v], height)) in depths {
                        *depth = tool.depth(frame.local(DVec3::new(*u, *v, *height)));
                    }
                }
            }
        }
    }
}

/// Settles the squares that are wet all over or dry all over; the others get [`UNSETTLED`] for their share.
pub(super) struct Settle<'a> {
    pub(super) border: &'a Border<'a>,
    pub(super) sheet: &'a Sheet,
    pub(super) squares: &'a mut Squares,
}

impl pulp::NullaryFnOnce for Settle<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { border, sheet, squares } = self;
        let (across, columns) = (sheet.window.size[1], squares.region.columns.clone());
        for row in squares.region.rows.clone() {
            let (first, count) = (row * across + columns.start, columns.len());
            cover_row(border, sheet, first, &mut squares.share[first..first + count]);
            settle_row(squares, (first, count), across, sheet.pitch);
        }
    }
}

/// Share of each square from line `first` on that lies under the working surface; [`UNSETTLED`] where a wheel's border may
/// cross it.
#[inline(always)]
fn cover_row(border: &Border, sheet: &Sheet, first: usize, cover: &mut [f64]) {
    let frame = &border.frame;
    let lines = first..first + cover.len();
    let points = sheet.places()[lines.clone()].iter().zip(&sheet.height[lines]);
    match border.tool {
        Tool::Wheel(wheel) => {
            for (cover, ([u, v], height)) in cover.iter_mut().zip(points) {
                let within = 0.5 * wheel.width - frame.local(DVec3::new(*u, *v, *height)).y.abs();
                let beside = if within <= -border.near { 0.0 } else { UNSETTLED };
                *cover = if within >= border.near { 1.0 } else { beside };
            }
        }
        Tool::Pad(pad) => {
            for (cover, ([u, v], height)) in cover.iter_mut().zip(points) {
                let at = frame.local(DVec3::new(*u, *v, *height));
                let square = at.x * at.x + at.y * at.y;
                let beside = if square >= border.ring.1 { 0.0 } else { UNSETTLED };
                *cover = if square <= border.ring.0 { 1.0 } else { beside };
            }
            let mut line = first;
            for part in cover.chunk_by_mut(|one, next| (*one == UNSETTLED) == (*next == UNSETTLED)) {
                if part[0] == UNSETTLED {
                    cross_row(border, (sheet, pad.radius), line, part);
                }
                line += part.len();
            }
        }
        Tool::Sphere(_) | Tool::Field(_) => cover.fill(1.0),
    }
}

/// Share of squares that the border of a pad of a `radius` [m] may cross.
#[inline(always)]
fn cross_row(border: &Border, (sheet, radius): (&Sheet, f64), first: usize, cover: &mut [f64]) {
    let lines = first..first + cover.len();
    let points = sheet.places()[lines.clone()].iter().zip(&sheet.height[lines.clone()]);
    for ((cover, ([u, v], height)), slope) in cover.iter_mut().zip(points).zip(&sheet.slope[lines]) {
        let at = border.frame.local(DVec3::new(*u, *v, *height));
        let within = radius - (at.x * at.x + at.y * at.y).sqrt();
        *cover = border.share_within(within, border.to_middle(at), *slope, 0.5 * sheet.pitch);
    }
}

/// Settles `count` squares from line `first` on, whose shares hold their cover.
#[inline(always)]
fn settle_row(squares: &mut Squares, (first, count): (usize, usize), across: usize, pitch: f64) {
    let from = |line: usize| &squares.depth[line..line + count];
    let (here, before, after) = (from(first), from(first - across), from(first + across));
    let (left, right) = (from(first - 1), from(first + 1));
    let lines = first..first + count;
    let means = &mut squares.mean_depth[lines.clone()];
    let (shares, areas) = (&mut squares.share[lines.clone()], &mut squares.area[lines]);
    let wall = 2.0 * pitch;
    for i in 0..count {
        let (depth, cover) = (here[i], shares[i]);
        let is_whole = ((before[i] - depth).abs() < wall)
            & ((after[i] - depth).abs() < wall)
            & ((left[i] - depth).abs() < wall)
            & ((right[i] - depth).abs() < wall);
        let span = 0.5 * (0.5 * (after[i] - before[i])).abs() + 0.5 * (0.5 * (right[i] - left[i])).abs();
        let bend = (after[i] - 2.0 * depth + before[i]) + (right[i] - 2.0 * depth + left[i]);
        let mean = depth + bend / 24.0;
        // The depth changes by less than a pitch across a square.
        let is_dry = (cover == 0.0) | (depth <= -pitch) | (is_whole & (depth <= -span));
        let is_full = (cover > 0.0) & is_whole & (depth >= span) & (mean > 0.0) & !is_dry;
        means[i] = if is_full { cover * mean } else { 0.0 };
        areas[i] = if is_full { cover } else { 0.0 };
        shares[i] = if is_full | is_dry { areas[i] } else { UNSETTLED };
    }
}
