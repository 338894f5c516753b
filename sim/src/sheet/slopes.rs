//! Slopes of a height field's surface, whole rows in the processor's widest SIMD lanes.

use std::ops::Range;

use super::{NO_SURFACE, Sheet};

/// Computes slopes from heights.
pub(super) struct Bend<'a> {
    pub(super) sheet: &'a mut Sheet,
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
}

impl pulp::NullaryFnOnce for Bend<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { sheet, rows, columns } = self;
        let [last_row, across] = [sheet.window.size[0] - 1, sheet.window.size[1]];
        for row in rows {
            let inner = columns.start.max(1)..columns.end.min(across - 1);
            if row == 0 || row == last_row {
                columns.clone().for_each(|column| bend_one(sheet, [row, column]));
                continue;
            }
            if columns.start == 0 {
                bend_one(sheet, [row, 0]);
            }
            if columns.end == across {
                bend_one(sheet, [row, across - 1]);
            }
            if !inner.is_empty() {
                bend_row(sheet, row * across + inner.start, inner.len());
            }
        }
    }
}

/// Height of a neighbour [m], which may be outside the window.
#[inline(always)]
fn beside(sheet: &Sheet, [row, column]: [i64; 2]) -> f64 {
    let [rows, across] = sheet.window.size;
    let is_there = row >= 0 && column >= 0 && row < rows as i64 && column < across as i64;
    if is_there { sheet.height[row as usize * across + column as usize] } else { NO_SURFACE }
}

/// Slopes at a column that may lack neighbours on some sides.
#[inline(always)]
fn bend_one(sheet: &mut Sheet, [row, column]: [usize; 2]) {
    let line = row * sheet.window.size[1] + column;
    let (row, column) = (row as i64, column as i64);
    let (before, after) = (beside(sheet, [row - 1, column]), beside(sheet, [row + 1, column]));
    let (left, right) = (beside(sheet, [row, column - 1]), beside(sheet, [row, column + 1]));
    let here = sheet.height[line];
    let [u, v] = [slope(before, here, after, sheet.pitch), slope(left, here, right, sheet.pitch)];
    sheet.slope[line] = [u, v];
    sheet.area_ratio[line] = (1.0 + u * u + v * v).sqrt();
}

/// Slopes at `count` columns from `first` on that have neighbours on all sides.
#[inline(always)]
fn bend_row(sheet: &mut Sheet, first: usize, count: usize) {
    let across = sheet.window.size[1];
    let from = |line: usize| &sheet.height[line..line + count];
    let (here, before, after) = (from(first), from(first - across), from(first + across));
    let (left, right) = (from(first - 1), from(first + 1));
    let (slopes, ratios) = (&mut sheet.slope[first..first + count], &mut sheet.area_ratio[first..first + count]);
    for i in 0..count {
        let u = slope(before[i], here[i], after[i], sheet.pitch);
        let v = slope(left[i], here[i], right[i], sheet.pitch);
        slopes[i] = [u, v];
        ratios[i] = (1.0 + u * u + v * v).sqrt();
    }
}

/// Slope at a column from its neighbours; a step of more than two pitches is a side face and does not count.
#[inline(always)]
fn slope(before: f64, here: f64, after: f64, pitch: f64) -> f64 {
    let (has_before, has_after) = ((before - here).abs() < 2.0 * pitch, (after - here).abs() < 2.0 * pitch);
    let from = if has_before { before } else { here };
    let to = if has_after { after } else { here };
    (to - from) / if has_before & has_after { 2.0 * pitch } else { pitch }
}
