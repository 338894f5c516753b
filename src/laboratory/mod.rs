//! The laboratory: a model held against the scans of a campaign, its parameters fitted, and what it lacks found.

mod blur;
mod coordinates;
mod covariance;
mod evidence;
mod exposure_view;
mod fit;
mod height_view;
mod probe;
mod scans;
mod screen;
mod tiles;

pub use blur::blurred;
pub use coordinates::{Bound, Coordinate, moved};
pub use covariance::{Freedom, TileNoise, Whitener};
pub use evidence::{Evidence, EvidenceError, Split};
pub use exposure_view::ExposureView;
pub use fit::{Estimate, Fit, FitOptions, robust_sum};
pub use height_view::HeightView;
pub use probe::{Candidate, Probe};
pub use scans::{ScanData, ScanEvidence, ScanView};
pub use screen::{Projector, Response, Screened};
pub use tiles::{TileGrid, Tiles};
