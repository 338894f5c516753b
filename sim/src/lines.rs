//! Lines of a sheet in order, with the runs of those that follow each other.

use std::ops::Range;

/// Lines in order. Values of each are kept as lanes, in the same order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    list: Vec<u32>,
    runs: Vec<Run>,
}

/// Lines that follow each other, as many as lanes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The lines.
    pub lines: Range<usize>,
    /// Their lanes.
    pub lanes: Range<usize>,
}

impl Lines {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.list.clear();
        self.runs.clear();
    }

    /// Adds a line beyond the last one.
    pub fn push(&mut self, line: usize) {
        self.extend(line..line + 1);
    }

    /// Adds lines beyond the last one.
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

    /// Takes the lines that are in either of two lists and that `keeps` wants.
    pub fn merge(&mut self, a: &Self, b: &Self, keeps: impl Fn(usize) -> bool) {
        self.clear();
        let (a, b) = (a.list(), b.list());
        let mut add = |line: u32| {
            if keeps(line as usize) {
                self.push(line as usize);
            }
        };
        let (mut i, mut j) = (0, 0);
        while i < a.len() && j < b.len() {
            let (first, second) = (a[i], b[j]);
            add(first.min(second));
            i += usize::from(first <= second);
            j += usize::from(second <= first);
        }
        a[i..].iter().chain(&b[j..]).for_each(|line| add(*line));
    }

    /// The lines, one by one.
    pub fn list(&self) -> &[u32] {
        &self.list
    }

    /// The lines, run by run.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether there are none.
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
