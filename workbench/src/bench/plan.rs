//! A model to be fitted on request.

use effects::{Library, Model};

/// A model to be fitted.
pub(super) struct Plan {
    /// Label for people.
    pub(super) label: String,
    /// Model with the start values of the fit.
    pub(super) model: Model,
    /// Effects that the model may contain.
    pub(super) library: Library,
    /// Change from the current model.
    pub(super) change: OwnedChange,
    /// Name and text of the effect file made from a typed formula.
    pub(super) effect: Option<(String, String)>,
}

/// Owned counterpart of [`super::replay::Change`].
pub(super) enum OwnedChange {
    /// The first model.
    Base,
    /// One effect is added.
    Add(String),
    /// One effect is removed.
    Remove(String),
    /// The model file is written by the workbench.
    Written,
}
