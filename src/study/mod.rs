//! A study: measurements compared with a model, the model calibrated, what it lacks found and added, step by step, and its
//! report filled from what the laboratory found.

mod calibrated;
mod conclusion;
mod course;
mod fill;
mod maps;
mod measurements;
mod record;

pub use calibrated::{CalibrationReport, calibration_report};
pub use conclusion::{suggestion, summary};
pub use course::Course;
pub use fill::{ReportInput, inputs_sha256, report};
pub use measurements::{Data, Measurements};
pub use record::{Action, Done, STUDY_FILE, STUDY_FORMAT, StudyRecord};
