//! The report of a study: its content, its form, and its display in a browser.

mod browser;
mod content;
mod form;
mod proposal;
mod study;
