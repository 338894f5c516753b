//! The report of a study: one HTML file that says what was compared, what is missing and what to do next.
//!
//! [`StudyReport`] holds what a study found, in SI units (`data`, and `scan_data` for what belongs to one scan).
//! [`page`] draws it; nothing here reads a file, simulates or judges.

mod data;
mod scan_data;

pub use data::{
    Compared, Correlations, Detectable, Digest, NextTrial, ParameterEstimate, Provenance, Stated, StudyReport,
    SuggestedEffect, Suspect, TestOfMissing, Verdict,
};
pub use scan_data::{
    Bin, ComparedPass, CovariatePlot, Direction, ExposureMaps, HeightMaps, Maps, Misfit, PassVolume, ScanComparison,
    ScanSection, Waterfall, WaterfallStep,
};
