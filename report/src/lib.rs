//! Self-contained HTML pages that load nothing.
//!
//! [`Page`] collects sections, [`Table`]s, [`Chart`]s and pictures; [`study`] draws the results of a study,
//! [`trial_check`] the checks of a trial. This crate reads no file, simulates nothing and judges nothing.

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
