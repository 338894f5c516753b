//! Pages for people: one HTML file with everything in it, which loads nothing.
//!
//! [`Page`] gathers sections, [`Table`]s, [`Chart`]s and pictures; [`study`] draws what a study found,
//! [`trial_check`] what the checks of a trial found. Nothing here reads a
//! file, simulates or judges.

mod axis;
mod chart;
mod map_image;
mod page;
pub mod study;
mod table;
pub mod trial_check;

pub(crate) use axis::{Axis, short};
pub use chart::{Chart, Series, Stroke, WIDE, stacked};
pub use page::Page;
pub(crate) use page::escape;
pub(crate) use table::exact;
pub use table::{Cell, Table};
