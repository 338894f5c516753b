//! The laboratory: a model held against the scans of a campaign, its parameters fitted, and what it lacks found.

mod blur;
mod coordinates;
mod covariance;
mod detectable;
mod diagnose;
mod evidence;
mod exposure_view;
mod fit;
mod height_view;
mod probe;
mod rows;
mod scans;
mod screen;
mod significance;
mod summary;
mod suspect;
mod table_noise;
mod table_reach;
mod table_steps;
mod tiles;

pub use blur::blurred;
pub use coordinates::{Bound, Coordinate, moved};
pub use covariance::{Freedom, TileNoise, Whitener};
pub use detectable::{Detectable, detectable};
pub use diagnose::{Diagnosis, Finding, Round, Told, Verdict, calibrate, unexplained, with_values};
pub use evidence::{Agreement, ErrorUnit, Evidence, EvidenceError, Split};
pub use exposure_view::ExposureView;
pub use fit::{Estimate, Fit, FitOptions, robust_sum};
pub use height_view::HeightView;
pub use probe::{Candidate, Probe};
pub use rows::{Outlier, RowEvidence};
pub use scans::{ScanData, ScanEvidence, ScanView};
pub use screen::{Projector, Response, Screened};
pub use summary::{DiagnosisSummary, EffectSummary, ParameterSummary, WaterfallStep};
pub use suspect::{Suspect, suspects};
pub use tiles::{TileGrid, Tiles};
