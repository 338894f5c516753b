//! The laboratory: compares a model with measurements, fits it, and finds the effect that it lacks.
//!
//! The method in ten steps, each with its files:
//!
//! 1. The crate `trial-simulation` runs trials as they were logged and shows the result as the instrument does; `scans` and
//!    `evidence` hold that against what was measured.
//! 2. `height_view`, `exposure_view` and `rows` make data of scans, masks and tables; `tiles` cuts scans up.
//! 3. `covariance` whitens residuals: noise (`tile_noise`), each scan's free pose, and the error of the simulation's own
//!    lattice (`lattice_error`); `blur` fits the instrument.
//! 4. `fit` varies the parameters (`coordinates`, `derivatives`) from where `begin` says, `uncertainty` gives their
//!    intervals; `staged` fits the rate first.
//! 5. `calibration` fits one effect after the other; the errors are the waterfall.
//! 6. `structure`, `covariate_share` and `pass_trend` test what the model leaves.
//! 7. `screen` simulates every effect at a few sizes (`probe`) beside what the base parameters can change (`response`).
//! 8. `suspect` fits the most promising effects, `pair` two together; `significance` gives the Δχ² that noise reaches.
//! 9. `diagnose` runs the search to its `verdict`; `ruled_out` and `detectable` say why others are out and what would show;
//!    `unlisted` finds a formula for what no effect describes, `next_trial` and `next_row` an experiment.
//! 10. `calibrate_scans` and `diagnose` are repeated by the crate `study`: compare, calibrate, diagnose, add.
//!
//! The numbers that decide stand in one table, [`criteria`]. SI units inside; the same seed gives the same bytes on any
//! number of threads.

mod attempt;
mod begin;
mod blur;
mod border;
mod calibrate;
mod calibration;
mod calibration_summary;
mod closure;
mod coarse_scans;
mod column_form;
mod coordinates;
mod covariance;
pub mod covariate_maps;
mod covariate_share;
pub mod criteria;
mod cross_validation;
mod derivatives;
mod detectable;
mod diagnose;
mod error;
mod evidence;
mod exposure_view;
mod extents;
mod finding;
mod first_look;
mod fit;
mod frame;
mod height_view;
mod held;
mod model_origin;
mod model_weights;
mod next_row;
mod next_trial;
mod noise_summary;
mod observation;
mod pair;
mod paired;
mod pass_trend;
mod prepared;
mod probe;
mod remembered;
mod repredicted;
mod reserve;
mod response;
mod round;
mod rows;
mod ruled_out;
mod scan_calibration;
mod scans;
mod screen;
mod sentence;
mod significance;
mod simulated;
mod simulation_errors;
mod space_mapping;
mod spline;
mod staged;
mod structure;
mod summary;
mod suspect;
mod table_library;
mod table_noise;
mod table_ranges;
mod table_reach;
mod table_reads;
mod table_steps;
mod tile_noise;
mod tiles;
mod totals;
mod uncertainty;
mod unfitted;
mod unlisted;
mod verdict;

pub use attempt::{Attempt, Tried};
pub use blur::blurred;
pub use calibrate::{calibrate, calibrate_scans, fit_roughly};
pub use calibration::{Calibration, Fitted, Judged, Order, uncalibrated};
pub use calibration_summary::{CalibrationSummary, Correlation, RemovalError, beginning};
pub use coordinates::{Bound, Coordinate, moved};
pub use covariance::{Freedom, Whitener};
pub use covariate_share::{CovariateBin, CovariateField, CovariateShare, CovariateStudy, covariate_study};
pub use criteria::{CRITERIA, Criterion, CriterionValues};
pub use cross_validation::Prediction;
pub use detectable::{Detectable, Sides, detectable};
pub use diagnose::{Diagnosis, OnProgress, with_values};
pub use error::{LabError, Result};
pub use evidence::{Agreement, ErrorUnit, Evidence, EvidenceError, Split};
pub use exposure_view::ExposureView;
pub use extents::{Extents, Reaches};
pub use finding::Finding;
pub use first_look::{FirstLook, Promise};
pub use fit::{Estimate, Fit, FitOptions, robust_sum};
pub use frame::{FrameCause, FrameEstimate, FrameFreedom, FrameQuantity, FrameValues, aligned};
pub use height_view::HeightView;
pub use model_origin::{Origin, identity, model_origin};
pub use next_row::{next_row, separating_row, testing_row};
pub use next_trial::{Hypothesis, MenuChoice, MenuLine, NextTrial, Worth, next_trial, separating_trial, testing_trial};
pub use noise_summary::NoiseSummary;
pub use observation::Observation;
pub use paired::{Better, Paired, PairedSplit};
pub use pass_trend::{PassTrend, trend_of_rows, trend_of_scans};
pub use probe::{Candidate, Probe};
pub use response::{Look, Projector, Response};
pub use round::Round;
pub use rows::{Outlier, RowEvidence};
pub use scans::{ScanData, ScanEvidence, ScanView};
pub use screen::Screened;
pub use simulated::Simulated;
pub use simulation_errors::SimulationErrors;
pub use spline::spline_columns;
pub use staged::Staged;
pub use structure::{ResidualGrid, SharedTiles, StructureTest, holm, structure_tests};
pub use summary::{
    BASE_STEP, DiagnosisSummary, EffectSummary, ParameterState, ParameterSummary, WaterfallStep, parameter_summary,
};
pub use suspect::Suspect;
pub use tile_noise::{FittedNoise, Kernel, TileNoise};
pub use tiles::{TileGrid, Tiles};
pub use totals::{Total, Totals};
pub use unfitted::Unfitted;
pub use unlisted::{Basis, CurvePoint, FittedForm, Proposal, ProposedForm, propose};
pub use verdict::{Searched, Verdict, unexplained};
