//! The deepest point of a square, which may lie beside its column.

use std::ops::Range;

use super::Squares;
use crate::sheet::Sheet;

impl Squares {
    /// Depth [m] at the peak of the parabolas through a column and its neighbours, if it is in the column's square.
    pub fn top(&self, sheet: &Sheet, line: usize) -> f64 {
        let (along, sideways) = self.differences(line, sheet.window.size[1], sheet.pitch);
        self.depth[line] + along.rise() + sideways.rise()
    }

    /// Whether the pressure at the top of any square of a run may exceed the `highest` [Pa] so far, by their pressures [Pa] at
    /// their mean depths [m]. A bound that takes no division: a parabola's peak in a square lies within a quarter of its rise
    /// across the square above the column.
    #[inline(always)]
    pub(crate) fn may_exceed(
        &self,
        highest: f64,
        (pressures, depths): (&[f64], &[f64]),
        run: Range<usize>,
        sheet: &Sheet,
    ) -> bool {
        let (across, first, count) = (sheet.window.size[1], run.start, run.len());
        let from = |line: usize| &self.depth[line..line + count];
        let (here, before, after) = (from(first), from(first - across), from(first + across));
        let (left, right) = (from(first - 1), from(first + 1));
        let (pressures, depths) = (&pressures[..count], &depths[..count]);
        let mut any = false;
        for i in 0..count {
            let rise = mean_size(before[i], here[i], after[i], sheet.pitch)
                + mean_size(left[i], here[i], right[i], sheet.pitch);
            let top = here[i] + 0.26 * rise;
            any |= (pressures[i] > highest) | (pressures[i] * top > highest * depths[i]);
        }
        any
    }
}

/// Size of the first difference across a square; a neighbour beyond a wall does not count.
#[inline(always)]
fn mean_size(before: f64, here: f64, after: f64, pitch: f64) -> f64 {
    let (down, up) = ((before - here).abs(), (after - here).abs());
    let (is_near_before, is_near_after) = (down < 2.0 * pitch, up < 2.0 * pitch);
    let one = if is_near_before { down } else { 0.0 } + if is_near_after { up } else { 0.0 };
    if is_near_before & is_near_after { 0.5 * (after - before).abs() } else { one }
}
