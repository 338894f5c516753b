//! A study: compares measurements with a model, calibrates the model, finds and adds missing effects step by step, and
//! fills its report.
//!
//! 1. [`Measurements`] reads a campaign or a table, [`Data`] is either as the laboratory's evidence.
//! 2. [`StudyState`] does one step after the other, and [`StudyRecord`] stores the steps done; [`Progress`] keeps
//!    predictions of a run that was interrupted.
//! 3. [`compare_scans`] and [`compare_rows`] compare without any fit, [`calibration_report`] and [`report()`] report
//!    the results of a fit and a search.
//! 4. [`StudyReport`] holds the contents of a page.
//!
//! ```
//! use study::{Action, StudyRecord};
//!
//! let record = StudyRecord::new("hash of all files".to_owned(), 1);
//! assert_eq!(record.next, Some(Action::Compare));
//! ```

mod attempt_report;
mod calibrated;
mod calibration_answer;
mod comparison;
mod conclusion;
mod data;
mod failures;
mod first_look;
mod hypothesis;
mod ledger;
mod maps;
mod measurements;
mod next_trial_files;
mod pass_tiles;
mod progress;
mod proposal_files;
mod proposal_step;
mod provenance;
mod record;
mod report_from_diagnosis;
mod residual_tests;
mod row_covariates;
mod scan_data;
mod scan_figures;
mod shapley;
pub mod snapshot;
mod study_state;
mod tile_covariates;
mod track;
mod unit_text;
mod waterfall;

pub use attempt_report::{attempt_report, pair_report};
pub use calibrated::{CalibrationReport, calibration_report};
pub use calibration_answer::{CALIBRATION_FILE, CalibrationAnswer};
pub use comparison::{Asked, Comparison, compare_rows, compare_scans};
pub use conclusion::{proposal, summary};
pub use data::{Compared, Conclusion, Digest, DisplayUnit, Provenance, StudyReport};
pub use failures::{CovariateFigures, Failures};
pub use first_look::{EXPECTED_SIMULATIONS, FirstAnswer};
pub use hypothesis::Hypothesis;
pub use ledger::{
    AttemptTexts, Entry, LEDGER_FILE, Ledger, LedgerLine, Standing, TRIED_EFFECTS, is_fitted, model_in_words,
    pair_in_words,
};
pub use measurements::{Data, Measurements, aligned};
pub use next_trial_files::{NEXT_TRIAL, NEXT_TRIAL_NAMES, write_next_trial};
pub use pass_tiles::PassTiles;
pub use progress::Progress;
pub use proposal_files::{MODEL_WITH_PROPOSAL, PROPOSED_EFFECTS, write_proposal};
pub use provenance::inputs_sha256;
pub use record::{Action, Done, STUDY_FILE, STUDY_FORMAT, StudyRecord};
pub use report_from_diagnosis::{ReportInput, report};
pub use scan_data::{
    Bin, ComparedPass, CovariatePlot, Direction, ExposureMaps, HeightMaps, Maps, Misfit, PassVolume, ScanComparison,
    ScanSection, Waterfall, WaterfallStep,
};
pub use scan_figures::{ScanFigures, SectionFigures};
pub use study_state::StudyState;
pub use tile_covariates::{COUNT as TILE_COVARIATES, covariate as tile_covariate};
pub use unit_text::{superscript, with_raised_powers};

#[cfg(test)]
mod tests;
