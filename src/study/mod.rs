//! A study: a campaign compared or diagnosed, and its report filled from what the laboratory found.

mod comparison;
mod fill;
mod maps;
mod places;
mod row_places;
mod scan_tests;
mod shares;
mod simulated;
mod track;
mod waterfall;

pub use comparison::{Asked, Comparison, CovariateFigures, ScanFigures, SectionFigures, compare_rows, compare_scans};
pub use fill::{ReportInput, report};
