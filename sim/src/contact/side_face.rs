//! The side face that a wheel leaves beside its groove.
//!
//! The border of the working surface crosses cells. Where the wheel has sunk in, the height of such a cell's column is
//! a mean of groove and side face, which conserves volume; but the wheel touches the groove alone. The step between
//! them is the difference, at the column, of two surfaces continued linearly: the one beside the wheel and the one
//! under it. On a smooth surface that difference is third order in the pitch.

use super::{Border, ContactCells};
use crate::height_field::HeightField;
use crate::region::Region;
use robot::Tool;

impl ContactCells {
    /// Removes the side face from the depths of the cells that a wheel's border crosses and of their neighbours.
    pub(super) fn remove_side_faces(&mut self, border: &Border, height_field: &HeightField) {
        if !matches!(border.tool, Tool::Wheel(_)) {
            return;
        }
        let axis = border.frame.y;
        let is_along_u = axis.x.abs() > axis.y.abs();
        let rising = if is_along_u { axis.x } else { axis.y }.signum();
        let half_width = 0.5 * border.tool.width();
        let (mut rims, rows) = ([usize::MAX; 2], Row::all(&self.region, height_field.window.size[1], is_along_u));
        for row in rows {
            let mut side_faces = [None; 2];
            for ((rim, side_face), outwards) in rims.iter_mut().zip(&mut side_faces).zip([1, -1]) {
                let sign = rising * outwards as f64;
                let side = Side { border, height_field, row, outwards, sign, half_width };
                *rim = side.rim((*rim).min(row.count - 1));
                *side_face = side.side_face(&self.depth, *rim);
            }
            for (line, part) in side_faces.into_iter().flatten().flatten() {
                self.depth[line] -= part;
            }
        }
    }
}

/// A row of columns that runs along a wheel's axis rather than across it.
#[derive(Clone, Copy)]
struct Row {
    first: usize,
    /// Index step from one column to the next.
    stride: usize,
    count: usize,
}

impl Row {
    /// The rows of a region in a window `across` columns wide, extended by one column at either end.
    fn all(region: &Region, across: usize, is_along_u: bool) -> impl Iterator<Item = Self> {
        let Region { rows, columns } = region.grown();
        let first = rows.start * across + columns.start;
        let (stride, count, step, lanes) =
            if is_along_u { (across, rows.len(), 1, columns.len()) } else { (1, columns.len(), across, rows.len()) };
        (1..lanes - 1).map(move |lane| Self { first: first + lane * step, stride, count })
    }
}

/// One of a wheel's two sides across a row.
struct Side<'a> {
    border: &'a Border<'a>,
    height_field: &'a HeightField,
    row: Row,
    /// Direction in the row that leads out of the wheel, and the sign of the wheel's y on this side.
    outwards: isize,
    sign: f64,
    /// Half of the wheel's width [m].
    half_width: f64,
}

impl Side<'_> {
    /// The column some steps outwards from a position in the row.
    fn line(&self, place: usize, steps: isize) -> Option<usize> {
        let place = place.checked_add_signed(steps * self.outwards).filter(|place| *place < self.row.count)?;
        Some(self.row.first + place * self.row.stride)
    }

    /// Distance of a column inside this side [m].
    #[inline(always)]
    fn within(&self, line: usize) -> f64 {
        self.half_width - self.sign * self.border.frame.local(self.height_field.point(line)).y
    }

    /// Share of a column's cell inside this side.
    fn share(&self, line: usize) -> f64 {
        let inward = self.border.frame.y * -self.sign;
        self.border
            .cover_within(self.within(line), inward, self.height_field.slope[line], 0.5 * self.height_field.pitch)
            .share
    }

    /// Position of the outermost cell of the row that is partly inside this side, searched from `place` on.
    fn rim(&self, mut place: usize) -> usize {
        let axis = self.border.frame.y;
        let reach = -0.5 * self.height_field.pitch * (axis.x.abs() + axis.y.abs());
        let is_within = |line: &usize| self.within(*line) > reach;
        while self.line(place, 1).filter(is_within).is_some() {
            place = place.strict_add_signed(self.outwards);
        }
        while self.line(place, 0).filter(is_within).is_none() && self.line(place, -1).is_some() {
            place = place.strict_add_signed(-self.outwards);
        }
        place
    }

    /// Columns around the rim with the depth that the side face adds to each [m]; `None` without a side face.
    fn side_face(&self, depth: &[f64], rim: usize) -> Option<[(usize, f64); 3]> {
        let [inmost, far, inner] = [self.line(rim, -3)?, self.line(rim, -2)?, self.line(rim, -1)?];
        let [here, outer, outmost] = [self.line(rim, 0)?, self.line(rim, 1)?, self.line(rim, 2)?];
        if depth[here] <= -self.height_field.pitch {
            return None;
        }
        let side_face = (2.0 * depth[outer] - depth[outmost]) - (2.0 * depth[inner] - depth[far]);
        if side_face <= 0.0 || side_face >= 2.0 * self.height_field.pitch {
            return None;
        }
        let inner_part = (1.0 - self.share(inner)) * side_face;
        // The surface under the wheel, extrapolated with its curvature: no part of it lies deeper.
        let groove = 3.0 * (depth[inner] - inner_part - depth[far]) + depth[inmost];
        let part = ((1.0 - self.share(here)) * side_face).min((depth[here] - groove).max(0.0));
        Some([(inner, inner_part), (here, part), (outer, side_face)])
    }
}
