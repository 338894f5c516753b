//! Views of consecutive columns of a row, for loops over SIMD lanes.

use std::ops::Range;

use super::ContactCells;

impl ContactCells {
    /// Views of consecutive columns on a height field `across` columns wide.
    #[inline(always)]
    pub(crate) fn columns(&self, lines: Range<usize>, across: usize) -> Columns<'_> {
        let from = |first: usize| &self.depth[first..first + lines.len()];
        let (first, share, cover) = (lines.start, &self.share[lines.clone()], &self.cover[lines.clone()]);
        let beside = [from(first - across), from(first + across), from(first - 1), from(first + 1)];
        Columns { depth: from(first), beside, share, cover }
    }
}

/// Consecutive columns of a row.
pub(crate) struct Columns<'a> {
    /// Depth at the columns [m], negative in the air, and at their neighbours.
    pub(crate) depth: &'a [f64],
    beside: [&'a [f64]; 4],
    share: &'a [f64],
    cover: &'a [f64],
}

impl Columns<'_> {
    /// The first `count` of them: with a count that a loop knows, it needs no checks.
    #[inline(always)]
    pub(crate) fn first(&self, count: usize) -> Self {
        let [before, after, left, right] = self.beside;
        Self {
            depth: &self.depth[..count],
            beside: [&before[..count], &after[..count], &left[..count], &right[..count]],
            share: &self.share[..count],
            cover: &self.cover[..count],
        }
    }

    /// True if the depth curves as over flat work: by `-whole` [m] in all, within half of `bend` [m], the tool's own
    /// second difference across a cell. Work that has taken the tool's shape curves less; edges and noise curve it
    /// more.
    #[inline(always)]
    pub(crate) fn is_flat(&self, i: usize, [bend, whole]: [f64; 2]) -> bool {
        let here = self.depth[i];
        let along = (self.beside[0][i] - here) + (self.beside[1][i] - here);
        let sideways = (self.beside[2][i] - here) + (self.beside[3][i] - here);
        ((along + sideways + whole).abs() <= 0.5 * bend) & (along.abs() <= 1.5 * bend) & (sideways.abs() <= 1.5 * bend)
    }

    /// Cover of a cell in contact, 0 for others.
    #[inline(always)]
    pub(crate) fn cover(&self, i: usize) -> f64 {
        if self.share[i] > 0.0 { self.cover[i] } else { 0.0 }
    }
}
