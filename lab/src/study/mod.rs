//! A study: measurements compared with a model, the model calibrated, what it lacks found and added, step by step, and its
//! report filled from what the laboratory found.

mod calibrated;
mod comparison;
mod conclusion;
mod data;
mod failures;
mod maps;
mod measurements;
mod progress;
mod provenance;
mod record;
mod report_from_diagnosis;
mod residual_tests;
mod row_covariates;
mod scan_data;
mod scan_figures;
mod shapley;
mod simulated;
mod study_state;
mod tile_covariates;
mod track;
mod unit_text;
mod waterfall;

pub use calibrated::{CalibrationReport, calibration_report};
pub use comparison::{Asked, Comparison, compare_rows, compare_scans};
pub use conclusion::{suggestion, summary};
pub use data::{
    Compared, Correlations, Detectable, Digest, NextTrial, ParameterEstimate, Provenance, Stated, StudyReport,
    SuggestedEffect, Suspect, TestOfMissing, Verdict,
};
pub use failures::{CovariateFigures, Failures};
pub use measurements::{Data, Measurements};
pub use progress::Progress;
pub use provenance::inputs_sha256;
pub use record::{Action, Done, STUDY_FILE, STUDY_FORMAT, StudyRecord};
pub use report_from_diagnosis::{ReportInput, report};
pub use scan_data::{
    Bin, ComparedPass, CovariatePlot, Direction, ExposureMaps, HeightMaps, Maps, Misfit, PassVolume, ScanComparison,
    ScanSection, Waterfall, WaterfallStep,
};
pub use scan_figures::{ScanFigures, SectionFigures};
pub use study_state::StudyState;
pub use unit_text::{superscript, with_raised_powers};
