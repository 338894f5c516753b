//! Slopes of a height field's surface, whole rows in the processor's widest SIMD lanes.

use std::ops::Range;

use super::{HeightField, NO_SURFACE};

/// Computes slopes from heights.
pub(super) struct Bend<'a> {
    pub(super) height_field: &'a mut HeightField,
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
}

impl pulp::NullaryFnOnce for Bend<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { height_field, rows, columns } = self;
        let [last_row, across] = [height_field.window.size[0] - 1, height_field.window.size[1]];
        for row in rows {
            let inner = columns.start.max(1)..columns.end.min(across - 1);
            if row == 0 || row == last_row {
                columns.clone().for_each(|column| bend_one(height_field, [row, column]));
                continue;
            }
            if columns.start == 0 {
                bend_one(height_field, [row, 0]);
            }
            if columns.end == across {
                bend_one(height_field, [row, across - 1]);
            }
            if !inner.is_empty() {
                bend_row(height_field, row * across + inner.start, inner.len());
            }
        }
    }
}

/// Height of a neighbour [m], which may be outside the window.
#[inline(always)]
fn beside(height_field: &HeightField, [row, column]: [i64; 2]) -> f64 {
    let [rows, across] = height_field.window.size;
    let is_there = row >= 0 && column >= 0 && row < rows as i64 && column < across as i64;
    if is_there { height_field.height[row as usize * across + column as usize] } else { NO_SURFACE }
}

/// Slopes at a column that may lack neighbours on some sides.
#[inline(always)]
fn bend_one(height_field: &mut HeightField, [row, column]: [usize; 2]) {
    let line = row * height_field.window.size[1] + column;
    let (row, column) = (row as i64, column as i64);
    let (before, after) = (beside(height_field, [row - 1, column]), beside(height_field, [row + 1, column]));
    let (left, right) = (beside(height_field, [row, column - 1]), beside(height_field, [row, column + 1]));
    let here = height_field.height[line];
    let [u, v] = [slope(before, here, after, height_field.pitch), slope(left, here, right, height_field.pitch)];
    height_field.slope[line] = [u, v];
    height_field.area_ratio[line] = (1.0 + u * u + v * v).sqrt();
}

/// Slopes at `count` columns from `first` on that have neighbours on all sides.
#[inline(always)]
fn bend_row(height_field: &mut HeightField, first: usize, count: usize) {
    let across = height_field.window.size[1];
    let from = |line: usize| &height_field.height[line..line + count];
    let (here, before, after) = (from(first), from(first - across), from(first + across));
    let (left, right) = (from(first - 1), from(first + 1));
    let (slopes, ratios) =
        (&mut height_field.slope[first..first + count], &mut height_field.area_ratio[first..first + count]);
    for i in 0..count {
        let u = slope(before[i], here[i], after[i], height_field.pitch);
        let v = slope(left[i], here[i], right[i], height_field.pitch);
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
