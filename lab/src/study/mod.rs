//! A study: measurements compared with a model, the model calibrated, what it lacks found and added, step by step, and its
//! report filled from what the laboratory found.

mod calibrated;
mod comparison;
mod conclusion;
mod course;
mod data;
mod failures;
mod fill;
mod maps;
mod measurements;
mod places;
mod progress;
mod record;
mod row_places;
mod scan_data;
mod scan_tests;
mod shares;
mod simulated;
mod track;
mod unit_text;
mod waterfall;

pub use calibrated::{CalibrationReport, calibration_report};
pub use comparison::{Asked, Comparison, ScanFigures, SectionFigures, compare_rows, compare_scans};
pub use conclusion::{suggestion, summary};
pub use course::Course;
pub use data::{
    Compared, Correlations, Detectable, Digest, NextTrial, ParameterEstimate, Provenance, Stated, StudyReport,
    SuggestedEffect, Suspect, TestOfMissing, Verdict,
};
pub use failures::{CovariateFigures, Failures};
pub use fill::{ReportInput, inputs_sha256, report};
pub use measurements::{Data, Measurements};
pub use progress::Progress;
pub use record::{Action, Done, STUDY_FILE, STUDY_FORMAT, StudyRecord};
pub use scan_data::{
    Bin, ComparedPass, CovariatePlot, Direction, ExposureMaps, HeightMaps, Maps, Misfit, PassVolume, ScanComparison,
    ScanSection, Waterfall, WaterfallStep,
};
pub use unit_text::{superscript, with_raised_powers};
