//! The laboratory: compares a model with measurements, fits it, and finds missing effects.
//!
//! The method in ten steps, each with its files:
//!
//! 1. The crate `trial-simulation` simulates trials as they were logged and as the instrument sees them; `scans` and
//!    `evidence` compare the result with the measurements.
//! 2. `height_view`, `exposure_view` and `rows` convert scans, masks and tables to data (`observation` is their interface); `tiles` cuts scans up.
//! 3. `covariance` whitens residuals: noise (`tile_noise`, `noise_fit`, `border_noise`), each scan's free pose, and the simulation's lattice
//!    error (`simulation_errors`, `mask_errors`); `nuisances` fits the instrument's blur.
//! 4. `fit` varies the parameters (`coordinates`, `derivatives`) from the starting values of `begin`; `uncertainty`
//!    gives their intervals; `staged` fits the rate first.
//! 5. `calibration` fits one effect after the other; the errors form the waterfall.
//! 6. `structure`, `covariate_share` and `pass_trend` test the residuals.
//! 7. `screen` simulates every effect at a few sizes (`probe`) and projects out the base parameters (`response`).
//! 8. `suspect` fits the most promising effects, `pair` two together, `leaders` ends the fits of those that predict best; `significance` gives the Δχ² that noise reaches.
//! 9. `diagnose` runs the search to its `verdict`; `ruled_out` and `detectable` give reasons against the others and
//!    detectable sizes; `unlisted` finds a formula where no effect fits. The crate `experiments` proposes the
//!    next experiment.
//! 10. The crate `study` repeats the steps: compare, calibrate, diagnose, add.
//!
//! All decision criteria stand in one table, [`criteria`]. Units are SI; the same seed gives the same bytes on any
//! number of threads.

mod attempt;
mod begin;
mod border_noise;
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
mod leaders;
mod mask_errors;
mod model_origin;
mod model_weights;
mod neighbourhood;
mod next_trial;
mod noise_fit;
mod noise_summary;
mod nuisances;
mod observation;
mod pair;
mod paired;
mod pass_trend;
mod pose_columns;
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
mod table_relation;
mod table_steps;
mod tile_noise;
mod tiles;
mod totals;
mod uncertainty;
mod unfitted;
mod unlisted;
mod verdict;

pub use attempt::{Attempt, Tried};
pub use calibrate::{calibrate, calibrate_scans, fit_roughly};
pub use calibration::{Calibration, Fitted, Judged, Order, uncalibrated};
pub use calibration_summary::{CalibrationSummary, Correlation, RemovalError, beginning, correlations};
pub use coordinates::{Bound, Coordinate, moved};
pub use covariance::{Freedom, Whitener};
pub use covariate_share::{CovariateBin, CovariateField, CovariateShare, CovariateStudy, covariate_study};
pub use criteria::{self, CRITERIA, Criterion, CriterionValues};
pub use cross_validation::{Prediction, prior};
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
pub use next_trial::{MenuChoice, MenuLine, NextTrial, Worth};
pub use noise_summary::NoiseSummary;
pub use nuisances::Nuisances;
pub use observation::{Observation, Untouched};
pub use paired::{Better, Paired, PairedSplit};
pub use pass_trend::{PassTrend, trend_of_rows, trend_of_scans};
pub use probe::{Candidate, Probe};
pub use response::{Baseline, Projector, Response};
pub use round::Round;
pub use rows::{Outlier, RowEvidence};
pub use scans::{ScanEvidence, ScanView};
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
