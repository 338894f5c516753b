//! The part of a height field that a step evaluates.

use std::ops::Range;

use crate::height_field::Window;

/// A rectangle of a window's columns, each with neighbours on all sides.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Region {
    /// Range of rows, along u.
    pub rows: Range<usize>,
    /// Range of positions in a row, along v.
    pub columns: Range<usize>,
}

impl Region {
    /// All columns of a window that have neighbours on all sides.
    pub fn inside(window: &Window) -> Self {
        Self::common(window, window)
    }

    /// Those of them that are also in `part`.
    pub fn common(window: &Window, part: &Window) -> Self {
        let range = |d: usize| {
            let first = i64::from(part.low[d]) - i64::from(window.low[d]);
            let end = (window.size[d] - 1) as i64;
            let last = (first + part.size[d] as i64).clamp(1, end);
            first.clamp(1, last) as usize..last as usize
        };
        Self { rows: range(0), columns: range(1) }
    }

    /// Its column indices in a window that is `across` columns wide.
    pub fn lines(&self, across: usize) -> impl Iterator<Item = usize> {
        let columns = self.columns.clone();
        self.rows.clone().flat_map(move |row| columns.clone().map(move |column| row * across + column))
    }

    /// The region and the columns around it.
    pub fn grown(&self) -> Self {
        let more = |range: &Range<usize>| range.start - 1..range.end + 1;
        Self { rows: more(&self.rows), columns: more(&self.columns) }
    }

    /// The same in a window of a size, as far as it reaches.
    pub(crate) fn grown_within(&self, [rows, across]: [usize; 2]) -> Self {
        let more = |range: &Range<usize>, size: usize| range.start.saturating_sub(1)..(range.end + 1).min(size);
        Self { rows: more(&self.rows, rows), columns: more(&self.columns, across) }
    }

    /// Its outermost columns; the corners appear twice.
    pub fn border(&self, across: usize) -> impl Iterator<Item = usize> {
        let Self { rows, columns } = self.clone();
        let ends = [rows.start, rows.end - 1].into_iter();
        let ends = ends.flat_map(move |row| columns.clone().map(move |column| row * across + column));
        let sides = [self.columns.start, self.columns.end - 1].into_iter();
        ends.chain(sides.flat_map(move |column| rows.clone().map(move |row| row * across + column)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_region_keeps_to_lines_with_neighbours() {
        let window = Window { low: [-3, 5], size: [6, 7] };
        assert_eq!(Region::inside(&window), Region { rows: 1..5, columns: 1..6 });
        let part = Window { low: [-1, 2], size: [3, 6] };
        let region = Region::common(&window, &part);
        assert_eq!(region, Region { rows: 2..5, columns: 1..3 });
        assert_eq!(region.lines(7).collect::<Vec<_>>(), [15, 16, 22, 23, 29, 30]);
        assert_eq!(region.grown(), Region { rows: 1..6, columns: 0..4 });
        assert_eq!(Region::inside(&window).border(7).count(), 2 * (4 + 5));
        let beside = Window { low: [40, 2], size: [3, 6] };
        assert_eq!(Region::common(&window, &beside).lines(7).count(), 0);
    }
}
