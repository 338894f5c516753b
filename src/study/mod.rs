//! A study: a campaign diagnosed, and its report filled from what the laboratory found.

mod fill;
mod maps;

pub use fill::{ReportInput, report};
