//! The laboratory: a model held against the scans of a campaign, its parameters fitted, and what it lacks found.

mod blur;
mod coordinates;
mod covariance;
mod evidence;
mod fit;
mod height_view;
mod rows;
mod scans;
mod table_noise;
mod table_reach;
mod table_steps;
mod tiles;

pub use blur::blurred;
pub use coordinates::{Bound, Coordinate, moved};
pub use covariance::{Freedom, TileNoise, Whitener};
pub use evidence::{Evidence, EvidenceError, Split};
pub use fit::{Estimate, Fit, FitOptions, robust_sum};
pub use height_view::HeightView;
pub use rows::{Outlier, RowEvidence};
pub use scans::{ScanEvidence, ScanView};
pub use tiles::{TileGrid, Tiles};
