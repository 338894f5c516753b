//! The report of a study: what it holds, its form, and how a browser takes it.

mod browser;
mod content;
mod form;
mod proposal;
mod study;
