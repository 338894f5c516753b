//! Undo history of the models.

use serde::{Deserialize, Serialize};

/// Numbers of models in the order in which they were visited, and the current position.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Trail {
    numbers: Vec<usize>,
    at: usize,
}

impl Trail {
    /// Returns the number of the current model.
    pub(crate) fn current(&self) -> Option<usize> {
        self.numbers.get(self.at).copied()
    }

    /// Goes to a model; drops the redo entries, but keeps their models.
    pub(crate) fn go(&mut self, number: usize) {
        if self.current() == Some(number) {
            return;
        }
        self.numbers.truncate(if self.numbers.is_empty() { 0 } else { self.at + 1 });
        self.numbers.push(number);
        self.at = self.numbers.len() - 1;
    }

    /// Goes back one entry; returns false at the first entry.
    pub(crate) fn undo(&mut self) -> bool {
        let can = self.can_undo();
        self.at -= usize::from(can);
        can
    }

    /// Goes forward one entry; returns false at the last entry.
    pub(crate) fn redo(&mut self) -> bool {
        let can = self.can_redo();
        self.at += usize::from(can);
        can
    }

    /// Returns true if there is an earlier entry.
    pub(crate) fn can_undo(&self) -> bool {
        self.at > 0
    }

    /// Returns true if there is a later entry.
    pub(crate) fn can_redo(&self) -> bool {
        self.at + 1 < self.numbers.len()
    }

    /// Returns true if all numbers lie between 1 and `most` and the position is valid; checks a history read from a
    /// file.
    pub(crate) fn is_within(&self, most: usize) -> bool {
        let known = self.numbers.iter().all(|number| (1..=most).contains(number));
        known && (self.at < self.numbers.len() || (self.numbers.is_empty() && self.at == 0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_goes_back_and_forth_and_a_new_model_ends_what_could_be_redone() {
        let mut trail = Trail::default();
        assert!(!trail.undo() && !trail.redo() && trail.current().is_none() && trail.is_within(0));
        (1..=3).for_each(|number| trail.go(number));
        assert!(trail.undo() && trail.undo() && !trail.undo());
        assert_eq!(trail.current(), Some(1));
        assert!(trail.redo());
        assert_eq!(trail.current(), Some(2));
        trail.go(4);
        assert!(!trail.can_redo() && trail.undo());
        assert_eq!(trail.current(), Some(2));
        assert!(trail.is_within(4) && !trail.is_within(3));
    }
}
