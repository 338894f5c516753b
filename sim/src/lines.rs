//! Sorted column indices of a height field, and the runs of consecutive ones.

use std::ops::Range;

/// Sorted column indices. Per-column values are stored as lanes, in the same order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    list: Vec<u32>,
    runs: Vec<Run>,
}

/// A run of consecutive columns, and as many lanes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The column indices.
    pub lines: Range<usize>,
    /// The lane indices.
    pub lanes: Range<usize>,
}

impl Lines {
    /// Removes all.
    pub fn clear(&mut self) {
        self.list.clear();
        self.runs.clear();
    }

    /// Appends a column; its index must be higher than the last.
    pub fn push(&mut self, line: usize) {
        self.extend(line..line + 1);
    }

    /// Appends columns; their indices must be higher than the last.
    pub fn extend(&mut self, lines: Range<usize>) {
        if lines.is_empty() {
            return;
        }
        let first = self.list.len();
        self.list.extend(lines.start as u32..lines.end as u32);
        let end = self.list.len();
        match self.runs.last_mut() {
            Some(run) if run.lines.end == lines.start => (run.lines.end, run.lanes.end) = (lines.end, end),
            _ => self.runs.push(Run { lines, lanes: first..end }),
        }
    }

    /// Replaces the content with the union of two lists, restricted to the columns that `keeps` accepts.
    pub fn merge(&mut self, a: &Self, b: &Self, keeps: impl Fn(usize) -> bool) {
        self.clear();
        let (mut a, mut b) = (a.runs.iter().peekable(), b.runs.iter().peekable());
        let mut next = || match (a.peek(), b.peek()) {
            (Some(first), Some(second)) if second.lines.start < first.lines.start => b.next(),
            (None, _) => b.next(),
            _ => a.next(),
        };
        let mut end = 0;
        while let Some(Run { lines, .. }) = next() {
            let mut line = lines.start.max(end);
            while line < lines.end {
                let kept = (line..lines.end).take_while(|line| keeps(*line)).count();
                self.extend(line..line + kept);
                line += kept + 1;
            }
            end = end.max(lines.end);
        }
    }

    /// The column indices, one by one.
    pub fn list(&self) -> &[u32] {
        &self.list
    }

    /// The runs of consecutive columns.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// Number of columns.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Returns true if there are no columns.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(list: &[usize]) -> Lines {
        let mut lines = Lines::default();
        list.iter().for_each(|line| lines.push(*line));
        lines
    }

    #[test]
    fn runs_know_their_lanes() {
        let mut lines = lines(&[4, 5, 9]);
        lines.extend(10..12);
        lines.extend(20..20);
        assert_eq!(lines.list(), [4, 5, 9, 10, 11]);
        assert_eq!(lines.runs(), [Run { lines: 4..6, lanes: 0..2 }, Run { lines: 9..12, lanes: 2..5 }]);
    }

    #[test]
    fn lists_in_order_are_merged_without_doubles() {
        let mut merged = lines(&[9]);
        merged.merge(&lines(&[1, 4, 5]), &lines(&[0, 4, 7]), |line| line != 7);
        assert_eq!(merged, lines(&[0, 1, 4, 5]));
    }
}
