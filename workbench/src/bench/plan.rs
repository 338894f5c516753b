//! A model that somebody wants.

use effects::{Library, Model};

/// A model that is to be made.
pub(super) struct Plan {
    /// For people.
    pub(super) label: String,
    /// With the values from which its fit begins.
    pub(super) model: Model,
    /// Effects that it may have.
    pub(super) library: Library,
    /// How command lines make it.
    pub(super) change: How,
    /// Effect file that was typed.
    pub(super) effect: Option<(String, String)>,
}

/// As [`super::replay::Change`], with names of its own.
pub(super) enum How {
    /// The first model.
    Base,
    /// An effect more.
    Add(String),
    /// An effect fewer.
    Remove(String),
    /// Its file is written.
    Written,
}
