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
            let lines = first..first + count;
            let lag = squares.lag.get_mut(lines.clone()).unwrap_or_default();
            cover_row(border, sheet, first, (&mut squares.share[lines], lag));
            if squares.lag.is_empty() {
                settle_row(squares, (first, count), (across, sheet.pitch), (0.0, |_| 0.0));
            } else {
                let lag = std::mem::take(&mut squares.lag);
                let sinking = |i: usize| border.sinking * lag[first + i];
                settle_row(squares, (first, count), (across, sheet.pitch), (border.sunk(), sinking));
                squares.lag = lag;
            }
        }
    }
}

/// Share of each square from line `first` on that lies under the working surface, [`UNSETTLED`] where a wheel's border may
/// cross it; and the lag, where there is a sweep.
#[inline(always)]
fn cover_row(border: &Border, sheet: &Sheet, first: usize, (cover, lag): (&mut [f64], &mut [f64])) {
    let frame = &border.frame;
    lag.fill(0.0);
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
            let mut place = 0;
            for part in cover.chunk_by_mut(|one, next| (*one == UNSETTLED) == (*next == UNSETTLED)) {
                let places = place..place + part.len();
                if part[0] == UNSETTLED {
                    let lag = lag.get_mut(places.clone()).unwrap_or_default();
                    cross_row(border, (sheet, pad.radius), first + place, (part, lag));
                }
                place = places.end;
            }
        }
        Tool::Sphere(_) | Tool::Field(_) => cover.fill(1.0),
    }
}

/// Cover of squares that the border of a pad of a `radius` [m] may cross.
#[inline(always)]
fn cross_row(border: &Border, (sheet, radius): (&Sheet, f64), first: usize, (cover, lag): (&mut [f64], &mut [f64])) {
    let lines = first..first + cover.len();
    let points = sheet.places()[lines.clone()].iter().zip(&sheet.height[lines.clone()]);
    let crossed = |(([u, v], height), slope): ((&[f64; 2], &f64), &[f64; 2])| {
        let at = border.frame.local(DVec3::new(*u, *v, *height));
        let within = radius - (at.x * at.x + at.y * at.y).sqrt();
        border.cover_within(within, border.to_middle(at), *slope, 0.5 * sheet.pitch)
    };
    let squares = points.zip(&sheet.slope[lines]);
    if lag.is_empty() {
        cover.iter_mut().zip(squares).for_each(|(share, square)| *share = crossed(square).share);
        return;
    }
    for ((share, lag), square) in cover.iter_mut().zip(lag).zip(squares) {
        let cover = crossed(square);
        (*share, *lag) = (cover.share, cover.lag);
    }
}

/// Settles `count` squares from line `first` on, whose shares hold their cover. In the sweep the tool sinks in by `sunk` [m] on
/// either side of its middle, and by `sinking` while it is over a square.
#[inline(always)]
fn settle_row(
    squares: &mut Squares,
    (first, count): (usize, usize),
    (across, pitch): (usize, f64),
    (sunk, sinking): (f64, impl Fn(usize) -> f64),
) {
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
        let swept_depth = depth + sinking(i);
        let mean = swept_depth + bend / 24.0;
        // The depth changes by less than a pitch across a square.
        let is_dry = (cover == 0.0) | (swept_depth <= -pitch - sunk) | (is_whole & (swept_depth <= -span - sunk));
        let is_full = (cover > 0.0) & is_whole & (swept_depth >= span + sunk) & (mean > 0.0) & !is_dry;
        means[i] = if is_full { cover * mean } else { 0.0 };
        areas[i] = if is_full { cover } else { 0.0 };
        shares[i] = if is_full | is_dry { areas[i] } else { UNSETTLED };
    }
}
