//! A study: measurements compared with a model, the model calibrated, what it lacks found and added, step by step, and its
//! report filled from what the laboratory found.

mod calibrated;
mod comparison;
mod conclusion;
mod course;
mod failures;
mod fill;
mod maps;
mod measurements;
mod places;
mod progress;
mod record;
mod row_places;
mod scan_tests;
mod shares;
mod simulated;
mod track;
mod waterfall;

pub use calibrated::{CalibrationReport, calibration_report};
pub use comparison::{Asked, Comparison, ScanFigures, SectionFigures, compare_rows, compare_scans};
pub use conclusion::{suggestion, summary};
pub use course::Course;
pub use failures::{CovariateFigures, Failures};
pub use fill::{ReportInput, inputs_sha256, report};
pub use measurements::{Data, Measurements};
pub use progress::Progress;
pub use record::{Action, Done, STUDY_FILE, STUDY_FORMAT, StudyRecord};
